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

/// By what things share a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clustering {
    /// By the shapes that stand in for them: the walls of a room belong together, whatever their distances.
    #[default]
    Shape,
    /// By their distances from the group (the paper's).
    Distance,
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

/// What is seen in the smallest triangles of the adaptive mesh, where their corners' paths take different ways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Edges {
    /// Each fragment's own path, traced: there samples of a pixel that show several triangles of the mesh are several fragments.
    #[default]
    Traced,
    /// Each pixel's own path, traced once.
    Once,
    /// The nearest corner's path.
    Nearest,
}

/// Where the textures of layers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Textures {
    /// They are what is seen from the middle of the shells.
    #[default]
    Projected,
    /// They are those with which pictures from viewpoints come out best (the paper's).
    Inferred,
}

/// Where textures are inferred for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Viewpoints {
    /// For a circle about the group, at the height of the scene's first camera (the paper's).
    #[default]
    Circle,
    /// For a line across the view of the scene's first camera.
    Line,
    /// For circles at several heights.
    Grid,
}

/// What says how parts of layers look that no picture of a viewpoint shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direct {
    /// Nothing: they are empty.
    None,
    /// What is seen from the middle of the shells.
    #[default]
    Center,
    /// What is seen from the viewpoint, past the reflectors and lenses, behind these.
    Viewpoint,
    /// What is seen from the viewpoint, and else from the middle of the shells.
    Both,
}

impl Direct {
    /// Whether the middle of the shells is looked from.
    pub(super) fn is_from_center(self) -> bool {
        matches!(self, Self::Center | Self::Both)
    }

    /// Whether the viewpoint is looked from.
    pub(super) fn is_from_viewpoint(self) -> bool {
        matches!(self, Self::Viewpoint | Self::Both)
    }
}

/// Settings of layered environment maps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayeredEnvironmentMapSettings {
    /// The most layers about a group of reflectors and lenses.
    pub layers: u32,
    /// By what things share a layer.
    pub clustering: Clustering,
    /// What stands in for the things of a layer.
    pub shells: Shells,
    /// Texels a side of a layer's texture, or of each face of its cube.
    pub size: u32,
    /// Rays a texel (a pixel, when inferring) when capturing, a square number.
    pub capture_samples: u32,
    /// Whether texels know how far away what they show is.
    pub depth: bool,
    /// Whether all groups of reflectors and lenses share one farthest layer.
    pub share_far: bool,
    /// Whether layers hold what other layers hide.
    pub continued: bool,
    /// Where the textures come from.
    pub textures: Textures,
    /// Where they are inferred for.
    pub viewpoints: Viewpoints,
    /// How many viewpoints a circle or line has.
    pub viewpoint_count: u32,
    /// How many circles a grid has, as far apart as the viewpoints on them.
    pub viewpoint_rows: u32,
    /// The length of a line of viewpoints; 0: the distance of the scene's first camera from the group.
    pub line_length: f32,
    /// Pixels a side of the pictures that textures are inferred from.
    pub picture_size: u32,
    /// Pictures on either side of a viewpoint, up to half way to the next one, that are inferred from too.
    pub neighbours: u32,
    /// What says how parts of layers look that no picture shows.
    pub direct: Direct,
    /// How rays get from the eye out of a group.
    pub transfer: Transfer,
    /// What is seen where paths of neighbours take different ways.
    pub edges: Edges,
    /// Edges of the adaptive mesh that are no longer than this in the picture, in pixels, are not divided.
    pub tau: f32,
    /// Rays that leave in directions no further apart than this are not divided, in degrees. The paper has 3, for look-ups at vertices; rays that
    /// are interpolated in every fragment come out as well with 6.
    pub angle_deg: f32,
    /// Whether tests of triangles are counted.
    pub count_tests: bool,
}

impl Default for LayeredEnvironmentMapSettings {
    fn default() -> Self {
        Self {
            layers: 3,
            clustering: Clustering::Shape,
            shells: Shells::Auto,
            size: 256,
            capture_samples: 4,
            depth: true,
            share_far: false,
            continued: true,
            textures: Textures::Projected,
            viewpoints: Viewpoints::Circle,
            viewpoint_count: 45,
            viewpoint_rows: 3,
            line_length: 0.0,
            picture_size: 384,
            neighbours: 1,
            direct: Direct::Center,
            transfer: Transfer::Adaptive,
            edges: Edges::Traced,
            tau: 3.0,
            angle_deg: 6.0,
            count_tests: false,
        }
    }
}

impl Settings for LayeredEnvironmentMapSettings {
    const METHOD: &'static str = "layered_environment_map";
    const HELP: &'static [(&'static str, &'static str)] = &[
        ("layers", "the most layers about a group of reflectors and lenses, 1 to 16"),
        ("clustering", "shape: things with a common shell share a layer; distance: things as far away (the paper's)"),
        ("shells", "what stands in for a layer: sphere, box, cylinder, quad; auto: the one that fits best"),
        ("size", "texels a side of a layer's texture or of each face of its cube, a power of two from 8 to 1024"),
        ("capture_samples", "rays a texel, or a pixel of the pictures that are inferred from: 1, 4, 9 or 16"),
        ("depth", "true: each texel knows how far away what it shows is; false: all is on its shell (the paper's)"),
        ("share_far", "true: what is farthest from all groups of reflectors is on one layer that they share"),
        ("continued", "true: layers hold what nearer ones hide; false: what is hit first alone"),
        (
            "textures",
            "projected: as seen from the middle of the shells; inferred: those that make pictures come out best",
        ),
        ("viewpoints", "where textures are inferred for: circle or line through the first camera, or grid of circles"),
        ("viewpoint_count", "viewpoints on a circle or line, 1 to 360; 45 on a circle are 8 degrees apart"),
        ("viewpoint_rows", "circles of a grid, 2 to 16"),
        ("line_length", "length of a line of viewpoints in scene units; 0: the first camera's distance"),
        ("picture_size", "pixels a side of the pictures that textures are inferred from, 16 to 2048"),
        ("neighbours", "pictures on either side of a viewpoint that it is inferred from too, 0 to 4"),
        (
            "direct",
            "what no picture shows is as seen from the middle of the shells (center), past the lenses (viewpoint), both; none: empty",
        ),
        ("transfer", "adaptive: paths are traced at the vertices of a refined mesh; exact: for every fragment"),
        (
            "edges",
            "where paths of neighbours take different ways, traced: each part of a pixel is traced; once: each pixel; nearest: none",
        ),
        ("tau", "edges of the refined mesh are divided down to this length in the picture, in pixels, 0.5 to 100"),
        ("angle_deg", "rays that leave further apart than this are divided, in degrees, 0.1 to 90"),
        ("count_tests", "true: reports a frame's tests of rays against triangles and surfaces, which makes it slower"),
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
        if !(1..=360).contains(&self.viewpoint_count) {
            return Err(format!("viewpoint_count = {} is outside 1 to 360", self.viewpoint_count));
        }
        if !(2..=16).contains(&self.viewpoint_rows) {
            return Err(format!("viewpoint_rows = {} is outside 2 to 16", self.viewpoint_rows));
        }
        if !(self.line_length.is_finite() && self.line_length >= 0.0) {
            return Err(format!("line_length = {} must be 0 or more", self.line_length));
        }
        if !(16..=2048).contains(&self.picture_size) {
            return Err(format!("picture_size = {} is outside 16 to 2048", self.picture_size));
        }
        if self.neighbours > 4 {
            return Err(format!("neighbours = {} is outside 0 to 4", self.neighbours));
        }
        within("tau", self.tau, 0.5, 100.0)?;
        within("angle_deg", self.angle_deg, 0.1, 90.0)
    }
}
