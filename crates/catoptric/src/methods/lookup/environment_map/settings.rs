//! The environment map's settings.

use crate::methods::Settings;
use serde::{Deserialize, Serialize};

/// How the reflected ray becomes a direction of the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parallax {
    /// The ray's direction: the surround is taken to be infinitely far.
    #[default]
    None,
    /// The surround is taken to lie on a box.
    Box,
    /// The surround is taken to lie on a sphere about the reflector.
    Sphere,
}

/// Where the map comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Captured from the scene at each reflector's centre.
    #[default]
    Capture,
    /// The scene's own environment; nearer things are not reflected.
    Environment,
}

/// Settings of the environment map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentMapSettings {
    /// How the reflected ray becomes a direction of the map.
    pub parallax: Parallax,
    /// Where the map comes from.
    pub source: Source,
    /// Texels a side of a cube face.
    pub size: u32,
    /// Samples a texel when capturing.
    pub capture_samples: u32,
    /// The smallest corner of the parallax box; with an empty box that of everything diffuse.
    pub box_min: [f32; 3],
    /// The largest corner of the parallax box.
    pub box_max: [f32; 3],
    /// The radius of the parallax sphere; 0: half the mean side of the box around everything diffuse.
    pub radius: f32,
}

impl Default for EnvironmentMapSettings {
    fn default() -> Self {
        Self {
            parallax: Parallax::None,
            source: Source::Capture,
            size: 512,
            capture_samples: 4,
            box_min: [0.0; 3],
            box_max: [0.0; 3],
            radius: 0.0,
        }
    }
}

impl Settings for EnvironmentMapSettings {
    const METHOD: &'static str = "environment_map";
    const HELP: &'static [(&'static str, &'static str)] = &[
        ("parallax", "none: at infinity; box, sphere: corrected for a surround of that shape"),
        ("source", "capture: from the scene at each reflector's centre; environment: the scene's environment alone"),
        ("size", "texels a side of a cube face, 4 to 4096"),
        ("capture_samples", "samples a texel when capturing: 1, 2, 4, 8 or 16"),
        ("box_min", "smallest corner [x, y, z] of the parallax box; an empty box: around everything diffuse"),
        ("box_max", "largest corner [x, y, z] of the parallax box"),
        ("radius", "radius of the parallax sphere; 0: half the mean side of the box around everything diffuse"),
    ];

    fn check(&self) -> Result<(), String> {
        if !(4..=4096).contains(&self.size) {
            return Err(format!("size = {} is outside 4 to 4096", self.size));
        }
        if ![1, 2, 4, 8, 16].contains(&self.capture_samples) {
            return Err(format!("capture_samples = {} is none of 1, 2, 4, 8, 16", self.capture_samples));
        }
        if !(self.radius.is_finite() && self.radius >= 0.0) {
            return Err(format!("radius = {} must be 0 or more", self.radius));
        }
        if !self.box_min.iter().chain(&self.box_max).all(|value| value.is_finite()) {
            return Err("box_min and box_max must be finite".into());
        }
        Ok(())
    }
}
