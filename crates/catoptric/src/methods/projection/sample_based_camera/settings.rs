//! The settings of sample-based cameras.

use crate::methods::{Settings, within};
use serde::{Deserialize, Serialize};

/// Settings of sample-based cameras.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SampleBasedCameraSettings {
    /// Leaves see the points of their rays at most this far from where they belong, in pixels.
    pub accuracy_px: f32,
    /// A ray every so many pixels.
    pub downsampling: u32,
    /// Edges of virtual geometry are divided until they are this near to where they belong.
    pub edge_error_px: f32,
    /// Pieces that appear in part are divided down to this size.
    pub piece_px: f32,
}

impl Default for SampleBasedCameraSettings {
    fn default() -> Self {
        Self { accuracy_px: 0.1, downsampling: 2, edge_error_px: 0.15, piece_px: 0.75 }
    }
}

impl Settings for SampleBasedCameraSettings {
    const METHOD: &'static str = "sample_based_camera";
    const HELP: &'static [(&'static str, &'static str)] = &[
        ("accuracy_px", "leaves see the points of their rays at most this far from where they belong, 0.01 to 100"),
        ("downsampling", "a ray every so many pixels, 1 to 64"),
        (
            "edge_error_px",
            "edges of virtual geometry are divided until they are this near to where they belong, 0.01 to 100",
        ),
        ("piece_px", "pieces that appear in part are divided down to this size, 0.1 to 100"),
    ];

    fn check(&self) -> Result<(), String> {
        within("accuracy_px", self.accuracy_px, 0.01, 100.0)?;
        within("downsampling", self.downsampling as f32, 1.0, 64.0)?;
        within("edge_error_px", self.edge_error_px, 0.01, 100.0)?;
        within("piece_px", self.piece_px, 0.1, 100.0)
    }
}
