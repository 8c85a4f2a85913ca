//! The settings of multiperspective rasterisation.

use crate::methods::declare_settings;

declare_settings! {
    /// Settings of multiperspective rasterisation.
    pub struct MultiperspectiveSettings of "multiperspective" {
        /// The rays of a tile may miss their places by this much, or it is divided.
        accuracy_px: f32 = 0.5, range(0.01, 100.0), unit("pixels");
    }
}
