//! The settings of sample-based cameras.

use super::hybrid::patterns;
use crate::error::RenderError;
use crate::methods::{Settings, from_table_with_presets, within};
use serde::{Deserialize, Serialize};

/// What a leaf is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraKind {
    /// Ours: polynomials over surface coordinates, in blocks of the ray map.
    #[default]
    RayBundle,
    /// The paper's: pinholes with a quadratic map, in a tree of splitting planes.
    Pinhole,
}

/// Settings that go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// A quarter of the resolution, one pixel: for previews.
    Fast,
    /// Half the resolution, a tenth of a pixel.
    #[default]
    Balanced,
    /// As balanced, and every vertex made exact by the solver.
    Exact,
    /// As in the paper: pinholes, half the resolution, one pixel.
    Faithful,
}

/// Settings of sample-based cameras.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SampleBasedCameraSettings {
    /// Where the other settings start from.
    pub preset: Preset,
    /// What leaves are.
    pub camera: CameraKind,
    /// Leaves see the points of their rays at most this far from where they belong, in pixels.
    pub accuracy_px: f32,
    /// A ray every so many pixels.
    pub downsampling: u32,
    /// Where no camera is accurate, rays between those of the map are traced, but none nearer to each other than this.
    pub finest_ray_px: f32,
    /// Steps of the solver that makes appearances exact; 0 leaves them as the cameras have them.
    pub polish: u32,
    /// Edges of virtual geometry are divided until they are this near to where they belong.
    pub edge_error_px: f32,
    /// Pieces that appear in part are divided down to this size.
    pub piece_px: f32,
    /// Reflectors and lenses with these names show environment maps: patterns, separated by commas.
    pub environment: String,
    /// So do those that appear no larger than this, in pixels, in either direction.
    pub environment_below_px: f32,
    /// Texels a side of a face of these maps.
    pub environment_size: u32,
}

impl SampleBasedCameraSettings {
    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let balanced = Self {
            preset,
            camera: CameraKind::RayBundle,
            accuracy_px: 0.1,
            downsampling: 2,
            finest_ray_px: 0.12,
            polish: 0,
            edge_error_px: 0.15,
            piece_px: 0.75,
            environment: String::new(),
            environment_below_px: 0.0,
            environment_size: 256,
        };
        match preset {
            Preset::Fast => Self {
                accuracy_px: 1.0,
                downsampling: 4,
                finest_ray_px: 1.0,
                edge_error_px: 0.5,
                piece_px: 3.0,
                ..balanced
            },
            Preset::Balanced => balanced,
            Preset::Exact => Self { polish: 8, ..balanced },
            Preset::Faithful => Self { camera: CameraKind::Pinhole, accuracy_px: 1.0, edge_error_px: 0.5, ..balanced },
        }
    }
}

impl Default for SampleBasedCameraSettings {
    fn default() -> Self {
        Self::preset(Preset::default())
    }
}

impl Settings for SampleBasedCameraSettings {
    const METHOD: &'static str = "sample_based_camera";
    const HELP: &'static [(&'static str, &'static str)] = &[
        ("preset", "what the other settings start from: fast, balanced, exact or faithful (to the paper)"),
        ("camera", "ray_bundle: polynomials over surface coordinates; pinhole: the paper's, with splitting planes"),
        ("accuracy_px", "leaves see the points of their rays at most this far from where they belong, 0.01 to 100"),
        ("downsampling", "a ray every so many pixels, 1 to 64"),
        ("finest_ray_px", "where no camera is accurate, rays this near to each other are traced, 0.03 to 1000 (none)"),
        ("polish", "steps of the solver that makes every appearance exact, 0 (none) to 100"),
        (
            "edge_error_px",
            "edges of virtual geometry are divided until they are this near to where they belong, 0.01 to 100",
        ),
        ("piece_px", "pieces that appear in part are divided down to this size, 0.1 to 100"),
        ("environment", "names of reflectors that show environment maps: patterns with * and ?, separated by commas"),
        ("environment_below_px", "reflectors that appear smaller than this show environment maps, 0 (none) to 100000"),
        ("environment_size", "texels a side of a face of these maps, 4 to 4096"),
    ];

    fn check(&self) -> Result<(), String> {
        within("accuracy_px", self.accuracy_px, 0.01, 100.0)?;
        within("downsampling", self.downsampling as f32, 1.0, 64.0)?;
        within("finest_ray_px", self.finest_ray_px, 0.03, 1000.0)?;
        within("polish", self.polish as f32, 0.0, 100.0)?;
        within("edge_error_px", self.edge_error_px, 0.01, 100.0)?;
        within("piece_px", self.piece_px, 0.1, 100.0)?;
        within("environment_below_px", self.environment_below_px, 0.0, 1e5)?;
        within("environment_size", self.environment_size as f32, 4.0, 4096.0)?;
        patterns(&self.environment).map(|_| ())
    }

    fn from_table(table: &toml::Table) -> Result<Self, RenderError> {
        from_table_with_presets(table, |given: &Self| Self::preset(given.preset))
    }
}
