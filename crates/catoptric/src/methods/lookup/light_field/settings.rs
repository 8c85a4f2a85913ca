//! The light field's settings.

use crate::error::RenderError;
use crate::methods::{Settings, from_table_with_presets, within};
use serde::{Deserialize, Serialize};

/// Where the other settings start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// 16 x 16 views of 64 x 64 a slab: captured in seconds.
    #[default]
    Small,
    /// The paper's sizes, 32 x 32 views of 128 x 128 a slab, with per-ray depth.
    Full,
    /// The paper's sizes, its one disparity a slab and its one bounce.
    Faithful,
}

/// What the four views about a ray are taken to see by it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Disparity {
    /// What is infinitely far.
    None,
    /// What lies on a plane, one for each slab (the paper's).
    Plane,
    /// What lies as far as the captured depth says, ray by ray.
    #[default]
    Depth,
}

/// How rays get from the eye out of a region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transfer {
    /// By one reflection or refraction, at the first surface (the paper's).
    First,
    /// Exactly: paths among the region's reflectors and lenses are traced, up to the order, until they leave it.
    #[default]
    Traced,
    /// By rays that were traced, and kept in a light field of their own: with one way after the first surface, and blended
    /// (Heidrich, Lensch, Cohen, Seidel 1999).
    Stored,
}

/// What is seen behind reflectors and lenses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Background {
    /// The scene, drawn.
    #[default]
    Scene,
    /// What slabs show, where the eye is in their region: then nothing but the region's reflectors is drawn, whatever the
    /// scene's size (the paper's).
    Slabs,
}

/// How views are kept: in a baked file, and with the errors that this makes also where they are captured in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Compression {
    /// Radiance with a shared exponent, four bytes a pixel and all levels: mapped into memory as it is.
    #[default]
    None,
    /// Blocks of 4 x 4 pixels in 8 bytes, radiance up to 64 (the paper's).
    Bc1,
    /// Blocks of 4 x 4 pixels in 16 bytes, of any radiance.
    Bc6h,
    /// Blocks of 4 x 4 pixels in 16 bytes, radiance up to 64, with less error in each.
    Bc7,
}

/// Settings of the light field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightFieldSettings {
    /// Where the other settings start from.
    pub preset: Preset,
    /// Views a side of a slab.
    pub st: u32,
    /// Pixels a side of a view.
    pub uv: u32,
    /// Rays a pixel of a view when capturing, a square number.
    pub capture_samples: u32,
    /// How views are kept.
    pub compression: Compression,
    /// What the four views about a ray are taken to see by it.
    pub disparity: Disparity,
    /// How rays get from the eye out of a region.
    pub transfer: Transfer,
    /// Views a side of the light field of kept rays.
    pub transfer_st: u32,
    /// Pixels a side of each of those.
    pub transfer_uv: u32,
    /// What is seen behind reflectors and lenses.
    pub background: Background,
    /// The distance of the plane from a slab's st plane, in scene units; 0: by the captured depth, slab by slab.
    pub focal_distance: f32,
    /// The manifest of views that were made elsewhere (`catoptric bake views` writes it), in place of capturing them; none: empty.
    pub views: String,
    /// Regions that no one gives are larger than the reflectors in them by this share of their diagonal on each side.
    pub region_margin: f32,
}

impl LightFieldSettings {
    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let small = Self {
            preset,
            st: 16,
            uv: 64,
            capture_samples: 1,
            compression: Compression::None,
            disparity: Disparity::Depth,
            transfer: Transfer::Traced,
            transfer_st: 16,
            transfer_uv: 64,
            background: Background::Scene,
            focal_distance: 0.0,
            views: String::new(),
            region_margin: 0.0,
        };
        match preset {
            Preset::Small => small,
            Preset::Full => Self { st: 32, uv: 128, ..small },
            Preset::Faithful => {
                Self { st: 32, uv: 128, disparity: Disparity::Plane, transfer: Transfer::First, ..small }
            }
        }
    }
}

impl Default for LightFieldSettings {
    fn default() -> Self {
        Self::preset(Preset::default())
    }
}

impl Settings for LightFieldSettings {
    const METHOD: &'static str = "light_field";
    const HELP: &'static [(&'static str, &'static str)] = &[
        (
            "preset",
            "small: 16 x 16 views of 64 x 64; full: the paper's 32 x 32 of 128 x 128; faithful: its disparity, too",
        ),
        ("st", "views a side of a slab, 2 to 256"),
        ("uv", "pixels a side of a view, 4 to 1024"),
        ("capture_samples", "rays a pixel of a view when capturing: 1, 4, 9 or 16"),
        (
            "compression",
            "none: 4 bytes a pixel; bc1 (the paper's): 0.5, bc6h and bc7: 1; decompressed when they are loaded",
        ),
        ("disparity", "none: all is infinitely far; plane: one focal plane a slab (the paper's); depth: ray by ray"),
        (
            "transfer",
            "traced: through all of a region's reflectors and lenses; first: by one bounce (the paper's); stored: by a table of rays",
        ),
        ("transfer_st", "views a side of that table of rays (transfer = stored), 2 to 64"),
        ("transfer_uv", "pixels a side of each of its views, 4 to 256"),
        ("background", "scene: drawn; slabs: looked up like reflections, where the eye is in a region"),
        ("focal_distance", "distance of the focal plane from the views, in scene units; 0: by the captured depth"),
        ("views", "manifest of views made elsewhere, in place of capturing them (`catoptric bake views` writes one)"),
        ("region_margin", "room about reflectors where the scene gives no region, as a share of their size, 0 to 1"),
    ];

    fn from_table(table: &toml::Table) -> Result<Self, RenderError> {
        from_table_with_presets(table, |named: &Self| Self::preset(named.preset))
    }

    fn check(&self) -> Result<(), String> {
        if !(2..=256).contains(&self.st) {
            return Err(format!("st = {} is outside 2 to 256", self.st));
        }
        if !(4..=1024).contains(&self.uv) {
            return Err(format!("uv = {} is outside 4 to 1024", self.uv));
        }
        if ![1, 4, 9, 16].contains(&self.capture_samples) {
            return Err(format!("capture_samples = {} is none of 1, 4, 9, 16", self.capture_samples));
        }
        if !(2..=64).contains(&self.transfer_st) {
            return Err(format!("transfer_st = {} is outside 2 to 64", self.transfer_st));
        }
        if !(4..=256).contains(&self.transfer_uv) {
            return Err(format!("transfer_uv = {} is outside 4 to 256", self.transfer_uv));
        }
        if !(self.focal_distance.is_finite() && self.focal_distance >= 0.0) {
            return Err(format!("focal_distance = {} must be 0 or more", self.focal_distance));
        }
        within("region_margin", self.region_margin, 0.0, 1.0)
    }
}
