//! The settings of multiperspective rasterisation.

use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// The model of the rays of a tile.
    pub enum ModelOfRays {
        /// A bundle: every coordinate a quadratic in the place in the picture.
        Bundles = "bundles",
        /// Every pixel's own ray and how it changes from pixel to pixel: slower, with smaller errors.
        Rays = "rays",
    }
}

declare_settings! {
    /// Settings of multiperspective rasterisation.
    pub struct MultiperspectiveSettings of "multiperspective" {
        /// The model that stands for the rays of a tile.
        model: ModelOfRays = ModelOfRays::Bundles;
        /// The bundle of a tile may miss its rays' places by this much, or it is divided, and pixels of small tiles get
        /// their own rays.
        accuracy_px: f32 = 0.5, range(0.01, 100.0), unit("pixels");
    }
}
