//! The planar mirror's settings.

use catoptric_engine::method::declare_settings;

declare_settings! {
    /// Settings of planar mirrors.
    pub struct PlanarMirrorSettings of "planar_mirror" {
        /// The most mirrored copies of the scene that are drawn in a frame; the environment is drawn in place of those
        /// left out, and the report counts them.
        max_lists: u32 = 512, range(1.0, 65536.0);
    }
}
