//! The settings of the search in pictures of reflectors.

use crate::methods::{Settings, within};
use serde::{Deserialize, Serialize};

/// Which pictures of a reflector are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Images {
    /// The paper's: one from the eye, made anew for every view.
    #[default]
    Eye,
    /// Cube maps around the reflector, made once.
    Cube,
}

/// What is done with a place that is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Refine {
    /// It is corrected by one step of Newton's method with the curvature of the mesh.
    #[default]
    Corrected,
    /// The paper's: the point is mirrored in the tangent plane there.
    Texel,
}

/// Settings of the search in pictures of reflectors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReflectorSearchSettings {
    /// Which pictures of a reflector are searched.
    pub images: Images,
    /// What is done with a place that is found.
    pub refine: Refine,
    /// Texels along the longer side of a picture.
    pub map_size: u32,
    /// Steps of the solver that makes appearances exact; 0 leaves them as they are found.
    pub polish: u32,
    /// Edges of virtual geometry are divided until they are this near to where they belong.
    pub edge_error_px: f32,
    /// Pieces that appear in part are divided down to this size.
    pub piece_px: f32,
}

impl Default for ReflectorSearchSettings {
    fn default() -> Self {
        Self {
            images: Images::Eye,
            refine: Refine::Corrected,
            map_size: 400,
            polish: 0,
            edge_error_px: 0.5,
            piece_px: 3.0,
        }
    }
}

impl Settings for ReflectorSearchSettings {
    const METHOD: &'static str = "reflector_search";
    const HELP: &'static [(&'static str, &'static str)] = &[
        (
            "images",
            "eye: the paper's pictures from the eye (after the first bounce cube maps); cube: cube maps around each reflector, made once",
        ),
        (
            "refine",
            "corrected: on the view ray through the found place, after one step towards the mirror law; texel: the paper's, mirrored in the tangent plane of the found place",
        ),
        ("map_size", "texels along the longer side of a picture, half as many a side of a cube map, 16 to 4096"),
        ("polish", "steps of the solver that makes every appearance exact, 0 (none) to 100"),
        (
            "edge_error_px",
            "edges of virtual geometry are divided until they are this near to where they belong, 0.01 to 100",
        ),
        ("piece_px", "pieces that appear in part are divided down to this size, 0.1 to 100"),
    ];

    fn check(&self) -> Result<(), String> {
        within("map_size", self.map_size as f32, 16.0, 4096.0)?;
        within("polish", self.polish as f32, 0.0, 100.0)?;
        within("edge_error_px", self.edge_error_px, 0.01, 100.0)?;
        within("piece_px", self.piece_px, 0.1, 100.0)
    }
}
