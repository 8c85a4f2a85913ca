//! The light field's settings.

use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// A set of values that the other settings start from.
    pub enum Preset {
        /// 16 x 16 views of 64 x 64 pixels a slab: captured in seconds.
        Small = "small",
        /// The paper's sizes, 32 x 32 views of 128 x 128 pixels a slab, with a depth for each ray.
        Full = "full",
        /// The paper's sizes, its one disparity a slab and its one bounce.
        Faithful = "faithful",
    }
}

declare_choices! {
    /// The distance at which the four views about a ray are taken to meet it.
    pub enum Disparity {
        /// Infinity.
        None = "none",
        /// The distance of a plane, one for each slab (the paper's).
        Plane = "plane",
        /// The captured depth, ray by ray.
        Depth = "depth",
    }
}

declare_choices! {
    /// The numbers by which the rays that leave a region are kept.
    pub enum Layout {
        /// Where they meet one of six planes of views, three times as wide as the region, and their slope (the
        /// paper's).
        Slabs = "slabs",
        /// Where they leave the region's box, and their direction over half of all: nothing lies before the views, and
        /// these stand closer together. As many views a slab in the mean, as many a length everywhere.
        Box = "box",
    }
}

declare_choices! {
    /// The paths of rays from the eye out of a region.
    pub enum Transfer {
        /// One reflection or refraction, at the first surface (the paper's).
        First = "first",
        /// Traced exactly among the region's reflectors and lenses, up to the order, until they leave it.
        Traced = "traced",
        /// Traced once and stored in a light field of their own, with one path after the first surface, and blended
        /// (Heidrich, Lensch, Cohen, Seidel 1999).
        Stored = "stored",
    }
}

declare_choices! {
    /// The picture behind reflectors and lenses.
    pub enum Background {
        /// The scene, drawn.
        Scene = "scene",
        /// The slabs, looked up where the eye is in their region: then nothing but the region's reflectors is drawn,
        /// whatever the scene's size (the paper's).
        Slabs = "slabs",
    }
}

declare_choices! {
    /// The form of views, in memory and in a baked file. But for `none`, depths are in blocks, too, of 8 bytes for
    /// 4 x 4 rays.
    pub enum Compression {
        /// Radiance with a shared exponent, four bytes a pixel, and depths of two.
        None = "none",
        /// Blocks of 4 x 4 pixels in 8 bytes, radiance up to 64 (the paper's).
        Bc1 = "bc1",
        /// Blocks of 4 x 4 pixels in 16 bytes, of any radiance.
        Bc6h = "bc6h",
        /// Blocks of 4 x 4 pixels in 16 bytes, radiance up to 64, with less error in each.
        Bc7 = "bc7",
    }
}

declare_settings! {
    /// Settings of the light field.
    pub struct LightFieldSettings of "light_field" {
        /// The set of values that the other settings start from.
        preset: Preset = Preset::Small;
        /// The numbers by which the rays that leave a region are kept.
        layout: Layout = Layout::Slabs, baked();
        /// Views a side of a slab.
        st: u32 = 16, range(2.0, 256.0), baked();
        /// Side of a view.
        uv: u32 = 64, range(4.0, 1024.0), unit("pixels"), baked();
        /// Rays a pixel of a view when capturing.
        capture_samples: u32 = 1, one_of(&[1, 4, 9, 16]), baked();
        /// The form of views, in memory and in a baked file.
        compression: Compression = Compression::None, baked();
        /// The distance at which the four views about a ray are taken to meet it.
        disparity: Disparity = Disparity::Depth;
        /// The paths of rays from the eye out of a region.
        transfer: Transfer = Transfer::Traced;
        /// Views a side of the light field of stored rays (`transfer = "stored"`).
        transfer_st: u32 = 16, range(2.0, 64.0);
        /// Side of each of its views.
        transfer_uv: u32 = 64, range(4.0, 256.0), unit("pixels");
        /// The picture behind reflectors and lenses.
        background: Background = Background::Scene;
        /// Distance of the focal plane from a slab's st plane; 0: by the captured depth, slab by slab.
        focal_distance: f32 = 0.0, at_least(0.0), unit("scene units");
        /// The manifest of views made elsewhere (`catoptric bake views` writes one), in place of capturing them;
        /// empty: captured.
        views: String = String::new();
        /// Margin about the reflectors of regions that the scene does not give, as a share of their boxes' diagonal.
        region_margin: f32 = 0.0, range(0.0, 1.0), baked();
    }

    fn start(&self) -> Self {
        Self::preset(self.preset)
    }
}

impl LightFieldSettings {
    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let small = Self { preset, ..Self::default() };
        match preset {
            Preset::Small => small,
            Preset::Full => Self { st: 32, uv: 128, ..small },
            Preset::Faithful => {
                Self { st: 32, uv: 128, disparity: Disparity::Plane, transfer: Transfer::First, ..small }
            }
        }
    }
}
