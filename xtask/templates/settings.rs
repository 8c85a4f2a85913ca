//! The settings of `{{name}}`.

use catoptric_engine::method::declare_settings;

declare_settings! {
    /// Settings of `{{name}}`.
    pub struct {{type}}Settings of "{{name}}" {
        /// Texels a side of its table.
        size: u32 = 64, range(4.0, 4096.0);
    }
}
