//! The perturbation method's settings.

use crate::methods::projection::ray_map::Approximation;
use crate::methods::{Settings, within};
use serde::{Deserialize, Serialize};

/// Which part of the Taylor expansion is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExpansionOrder {
    /// As much as the estimated remainder asks for.
    #[default]
    Auto,
    /// The nearest sample as it is.
    Nearest,
    /// The path Jacobian.
    Linear,
    /// The path Jacobian and Hessian.
    Quadratic,
}

impl ExpansionOrder {
    /// The order when it is forced.
    pub(super) fn forced(self) -> Option<Approximation> {
        match self {
            Self::Auto => None,
            Self::Nearest => Some(Approximation::Nearest),
            Self::Linear => Some(Approximation::Linear),
            Self::Quadratic => Some(Approximation::Quadratic),
        }
    }
}

/// Which sample rays are tried for a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Candidates {
    /// Of the rays whose expansions reach the point, those that lead to different places in the picture.
    #[default]
    InReach,
    /// The paper's: of the nearest rays, one for each group by direction and reflection point.
    Nearest,
}

/// Settings of the perturbation method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PathPerturbationSettings {
    /// A sample ray every so many pixels.
    pub spacing_px: f32,
    /// Where neighbouring rays disagree, they are sampled down to this spacing.
    pub finest_px: f32,
    /// Neighbouring rays disagree when they predict each other with a larger error than this.
    pub accuracy_px: f32,
    /// The most sample rays of a view.
    pub max_samples: u32,
    /// Which part of the expansion is used.
    pub expansion: ExpansionOrder,
    /// Which rays are tried.
    pub candidates: Candidates,
    /// How many nearest rays are grouped.
    pub nearest_count: u32,
    /// Nearest rays whose directions differ by more, in degrees, are different reflections.
    pub group_angle_deg: f32,
    /// Nearest rays whose reflection points lie further apart, as a share of the reflector's size, are too.
    pub group_distance: f32,
    /// Newton steps on the specular constraint after the expansion; 0 for the paper's method.
    pub polish: u32,
    /// Edges of virtual geometry are divided until they are this near to where they belong.
    pub edge_error_px: f32,
    /// Pieces that appear in part are divided down to this size.
    pub piece_px: f32,
}

impl Default for PathPerturbationSettings {
    fn default() -> Self {
        Self {
            spacing_px: 8.0,
            finest_px: 2.0,
            accuracy_px: 0.5,
            max_samples: 60_000,
            expansion: ExpansionOrder::Auto,
            candidates: Candidates::InReach,
            nearest_count: 5,
            group_angle_deg: 20.0,
            group_distance: 0.25,
            polish: 40,
            edge_error_px: 0.25,
            piece_px: 0.75,
        }
    }
}

impl Settings for PathPerturbationSettings {
    const METHOD: &'static str = "path_perturbation";
    const HELP: &'static [(&'static str, &'static str)] = &[
        ("spacing_px", "a sample ray every so many pixels, 1 to 256"),
        (
            "finest_px",
            "where neighbouring rays disagree they are sampled down to this spacing; spacing_px: a regular grid",
        ),
        ("accuracy_px", "neighbouring rays disagree when they predict each other with a larger error, in pixels"),
        ("max_samples", "the most sample rays of a view, 1 to 4000000"),
        (
            "expansion",
            "nearest (no derivatives), linear (path Jacobian), quadratic (and Hessian) or auto (by the remainder)",
        ),
        ("candidates", "in_reach (all rays whose expansions reach the point) or nearest (the paper's grouping)"),
        ("nearest_count", "how many nearest rays are grouped, 1 to 64 (candidates = nearest)"),
        (
            "group_angle_deg",
            "nearest rays whose directions differ by more are different reflections (candidates = nearest)",
        ),
        (
            "group_distance",
            "the same for their reflection points, as a share of the reflector's size (candidates = nearest)",
        ),
        ("polish", "steps on the specular constraint after the expansion, 0 to 100; 0 is the paper's method"),
        (
            "edge_error_px",
            "edges of virtual geometry are divided until they are this near to where they belong, 0.01 to 100",
        ),
        ("piece_px", "pieces that appear in part are divided down to this size, 0.1 to 100"),
    ];

    fn check(&self) -> Result<(), String> {
        within("spacing_px", self.spacing_px, 1.0, 256.0)?;
        within("finest_px", self.finest_px, 0.25, 256.0)?;
        within("accuracy_px", self.accuracy_px, 1e-3, 1e3)?;
        within("max_samples", self.max_samples as f32, 1.0, 4e6)?;
        within("nearest_count", self.nearest_count as f32, 1.0, 64.0)?;
        within("group_angle_deg", self.group_angle_deg, 0.0, 180.0)?;
        within("group_distance", self.group_distance, 0.0, 1e3)?;
        within("polish", self.polish as f32, 0.0, 100.0)?;
        within("edge_error_px", self.edge_error_px, 0.01, 100.0)?;
        within("piece_px", self.piece_px, 0.1, 100.0)?;
        if self.finest_px > self.spacing_px {
            return Err(format!("finest_px = {} is larger than spacing_px = {}", self.finest_px, self.spacing_px));
        }
        Ok(())
    }
}
