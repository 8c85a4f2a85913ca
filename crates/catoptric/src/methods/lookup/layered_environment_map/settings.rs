//! Settings of layered environment maps.

use crate::methods::{Settings, within};
use serde::{Deserialize, Serialize};

/// What stands in for the things of a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shells {
    /// Of the others the one that fits best, layer by layer.
    #[default]
    Auto,
    /// A sphere.
    Sphere,
    /// A box along the axes.
    Box,
    /// An upright cylinder with a top and a bottom.
    Cylinder,
    /// A rectangle where a layer's things are on one side, else a sphere.
    Quad,
}

/// How rays get from the eye out of a group of reflectors and lenses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transfer {
    /// By paths that are traced at the vertices of a mesh that is refined in every frame (the paper's).
    #[default]
    Adaptive,
    /// By paths that are traced for every fragment: for comparison.
    Exact,
}

/// Settings of layered environment maps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayeredEnvironmentMapSettings {
    /// The most layers about a group of reflectors and lenses.
    pub layers: u32,
    /// What stands in for the things of a layer.
    pub shells: Shells,
    /// Texels a side of a layer's texture, or of each face of its cube.
    pub size: u32,
    /// Rays a texel when capturing, a square number.
    pub capture_samples: u32,
    /// How rays get from the eye out of a group.
    pub transfer: Transfer,
    /// Edges of the adaptive mesh that are no longer than this in the picture, in pixels, are not divided.
    pub tau: f32,
    /// Rays that leave in directions no further apart than this are not divided, in degrees.
    pub angle_deg: f32,
}

impl Default for LayeredEnvironmentMapSettings {
    fn default() -> Self {
        Self {
            layers: 3,
            shells: Shells::Auto,
            size: 256,
            capture_samples: 4,
            transfer: Transfer::Adaptive,
            tau: 3.0,
            angle_deg: 3.0,
        }
    }
}

impl Settings for LayeredEnvironmentMapSettings {
    const METHOD: &'static str = "layered_environment_map";
    const HELP: &'static [(&'static str, &'static str)] = &[
        ("layers", "the most layers about a group of reflectors and lenses, 1 to 16"),
        ("shells", "what stands in for a layer: sphere, box, cylinder, quad; auto: the one that fits best"),
        ("size", "texels a side of a layer's texture or of each face of its cube, a power of two from 8 to 1024"),
        ("capture_samples", "rays a texel when capturing: 1, 4, 9 or 16"),
        ("transfer", "adaptive: paths are traced at the vertices of a refined mesh; exact: for every fragment"),
        ("tau", "edges of the refined mesh are divided down to this length in the picture, in pixels, 0.5 to 100"),
        ("angle_deg", "rays that leave further apart than this are divided, in degrees, 0.1 to 90"),
    ];

    fn check(&self) -> Result<(), String> {
        if !(1..=16).contains(&self.layers) {
            return Err(format!("layers = {} is outside 1 to 16", self.layers));
        }
        if !(self.size.is_power_of_two() && (8..=1024).contains(&self.size)) {
            return Err(format!("size = {} is no power of two from 8 to 1024", self.size));
        }
        if ![1, 4, 9, 16].contains(&self.capture_samples) {
            return Err(format!("capture_samples = {} is none of 1, 4, 9, 16", self.capture_samples));
        }
        within("tau", self.tau, 0.5, 100.0)?;
        within("angle_deg", self.angle_deg, 0.1, 90.0)
    }
}
