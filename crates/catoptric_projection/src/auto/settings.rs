//! The settings of the automatic choice.

use catoptric_engine::method::declare_settings;

declare_settings! {
    /// Settings of the automatic choice.
    pub struct AutoSettings of "auto" {
        /// The rays of a tile may miss their places by this much, or it is divided.
        accuracy_px: f32 = 0.5, range(0.01, 100.0), unit("pixels");
    }
}
