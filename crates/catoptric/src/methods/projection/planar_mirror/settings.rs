//! The planar mirror's settings.

use crate::methods::Settings;
use serde::{Deserialize, Serialize};

/// Settings of planar mirrors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlanarMirrorSettings {
    /// The most copies of the scene that are drawn in a frame; what lies beyond is counted, and not seen.
    pub max_lists: u32,
}

impl Default for PlanarMirrorSettings {
    fn default() -> Self {
        Self { max_lists: 512 }
    }
}

impl Settings for PlanarMirrorSettings {
    const METHOD: &'static str = "planar_mirror";
    const HELP: &'static [(&'static str, &'static str)] =
        &[("max_lists", "the most copies of the scene that are drawn in a frame, 1 to 65536; the rest is not seen")];

    fn check(&self) -> Result<(), String> {
        if !(1..=65536).contains(&self.max_lists) {
            return Err(format!("max_lists = {} is outside 1 to 65536", self.max_lists));
        }
        Ok(())
    }
}
