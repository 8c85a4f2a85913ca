//! The settings of explosion maps.

use crate::error::RenderError;
use crate::methods::{Settings, from_table_with_presets, within};
use serde::{Deserialize, Serialize};

/// How a point's place on the reflector is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variant {
    /// The paper's approximation: from the id buffers of spheres.
    Map,
    /// The paper's exact one: the cell of reflected rays that holds the point, found by walking from where the map says.
    #[default]
    Subdivision,
}

/// Where the picture of a point is put.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VirtualVertex {
    /// Where the reflector shows it: the foot after one step of Newton's method with the curvature of the mesh.
    #[default]
    Corrected,
    /// The paper's: its mirror image in the tangent plane at the foot.
    Mirrored,
}

/// Settings that go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// The reflection subdivision.
    #[default]
    Balanced,
    /// Maps of four spheres, corrected.
    Fast,
    /// As in the paper: maps of two spheres, virtual vertices mirrored in the tangent plane.
    Faithful,
    /// As balanced, and every vertex made exact by the solver.
    Exact,
}

/// Settings of explosion maps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExplosionMapSettings {
    /// Where the other settings start from.
    pub preset: Preset,
    /// How a point's place on the reflector is found.
    pub variant: Variant,
    /// Where the picture of a point is put.
    pub virtual_vertex: VirtualVertex,
    /// Texels a side of the id buffers.
    pub map_size: u32,
    /// Spheres about a reflector.
    pub spheres: u32,
    /// Edges of reflectors longer than this share of their radius are halved.
    pub longest_edge: f32,
    /// Whether reflectors that are drawn along one axis are looked up in their profile instead of maps.
    pub extrusions: bool,
    /// Steps of the solver that makes appearances exact; 0 leaves them as the maps have them.
    pub polish: u32,
    /// Edges of virtual geometry are divided until they are this near to where they belong.
    pub edge_error_px: f32,
    /// Pieces that appear in part are divided down to this size.
    pub piece_px: f32,
}

impl ExplosionMapSettings {
    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let balanced = Self {
            preset,
            variant: Variant::Subdivision,
            virtual_vertex: VirtualVertex::Corrected,
            map_size: 200,
            spheres: 4,
            longest_edge: 0.125,
            extrusions: true,
            polish: 0,
            edge_error_px: 0.25,
            piece_px: 1.0,
        };
        match preset {
            Preset::Balanced => balanced,
            Preset::Fast => Self { variant: Variant::Map, edge_error_px: 1.0, piece_px: 3.0, ..balanced },
            Preset::Faithful => Self {
                variant: Variant::Map,
                virtual_vertex: VirtualVertex::Mirrored,
                spheres: 2,
                edge_error_px: 1.0,
                piece_px: 3.0,
                ..balanced
            },
            Preset::Exact => Self { polish: 8, ..balanced },
        }
    }
}

impl Default for ExplosionMapSettings {
    fn default() -> Self {
        Self::preset(Preset::default())
    }
}

impl Settings for ExplosionMapSettings {
    const METHOD: &'static str = "explosion_map";
    const HELP: &'static [(&'static str, &'static str)] = &[
        (
            "variant",
            "map: the paper's id buffers; subdivision: the exact cells of reflected rays, walked to from there",
        ),
        (
            "virtual_vertex",
            "corrected: on the view ray through the foot, after one step towards the mirror law; mirrored: the paper's, in the tangent plane",
        ),
        ("map_size", "texels a side of the id buffers, 4 to 4096"),
        (
            "spheres",
            "spheres about a reflector, 2 (the paper's) to 16: points between two of them blend what both say; with more than two the reflector itself is one more",
        ),
        ("longest_edge", "edges of reflectors longer than this share of their radius are halved, 0.01 to 10"),
        (
            "extrusions",
            "whether reflectors that are drawn along one axis are looked up in their profile instead of maps",
        ),
        ("polish", "steps of the solver that makes every appearance exact, 0 (none) to 100"),
        (
            "edge_error_px",
            "edges of virtual geometry are divided until they are this near to where they belong, 0.01 to 100",
        ),
        ("piece_px", "pieces that appear in part are divided down to this size, 0.1 to 100"),
    ];

    fn check(&self) -> Result<(), String> {
        within("map_size", self.map_size as f32, 4.0, 4096.0)?;
        within("spheres", self.spheres as f32, 2.0, 16.0)?;
        within("longest_edge", self.longest_edge, 0.01, 10.0)?;
        within("polish", self.polish as f32, 0.0, 100.0)?;
        within("edge_error_px", self.edge_error_px, 0.01, 100.0)?;
        within("piece_px", self.piece_px, 0.1, 100.0)
    }

    fn from_table(table: &toml::Table) -> Result<Self, RenderError> {
        from_table_with_presets(table, |given: &Self| Self::preset(given.preset))
    }
}
