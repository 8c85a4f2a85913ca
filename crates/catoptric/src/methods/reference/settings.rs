//! The reference's settings.

use crate::methods::Settings;
use serde::{Deserialize, Serialize};

/// Which paths are followed at refracting surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathModel {
    /// Both children at every surface.
    #[default]
    Tree,
    /// Both children at the first, then the one with the larger Fresnel coefficient (Hakura, Snyder 2001, section 3).
    TwoPath,
}

/// Where the samples of a pixel lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SamplePlacement {
    /// Where the rasteriser has them, for the counts that it knows; else as `Random`.
    #[default]
    Pattern,
    /// Jittered in the cells of a grid, differently in every pixel.
    Random,
}

/// Settings of the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReferenceSettings {
    /// Which paths are followed at refracting surfaces.
    pub paths: PathModel,
    /// Where the samples of a pixel lie.
    pub samples: SamplePlacement,
    /// Seed of the jitter.
    pub seed: u64,
    /// Whether tests of triangles are counted.
    pub count_tests: bool,
}

impl Settings for ReferenceSettings {
    const METHOD: &'static str = "reference";
    const HELP: &'static [(&'static str, &'static str)] = &[
        ("paths", "tree: both children at every surface; two_path: the greedy model of the hybrid paper"),
        ("samples", "pattern: where the rasteriser has them (1, 2, 4, 8, 16 samples); random: jittered a pixel"),
        ("seed", "seed of the jitter, a whole number"),
        ("count_tests", "true: reports the tests of rays against triangles and surfaces, which makes it slower"),
    ];
}
