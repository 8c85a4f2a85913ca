//! The library call behind `catoptric project`: all specular paths between an eye and scene points.

use super::projector::{MAX_BOUNCES, SpecularPath};
use glam::{DMat3, DVec3};

/// One specular path from the eye to a scene point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoundPath {
    /// Index of its sequence of bounces in [`PathSearch::paths`].
    pub path: u32,
    /// How many bounces it has.
    pub bounce_count: usize,
    /// The bounce points, from the eye; those beyond `bounce_count` are zero.
    pub bounce_points: [DVec3; MAX_BOUNCES],
    /// Focal points passed, summed over the path.
    pub focal_index: u32,
    /// Optical length from eye to point: inside a lens a segment counts its index of refraction times.
    pub optical_length: f64,
    /// The largest norm over the bounces of the specular constraint.
    pub residual: f64,
    /// The change of the first bounce point with the scene point (rows: components of the bounce point).
    pub jacobian: DMat3,
}

/// What a search for one point came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SearchOutcome {
    /// How many paths were appended.
    pub found: usize,
    /// The point has infinitely many paths of some sequence of bounces; those are left out.
    pub infinite: bool,
}

/// Finds all specular paths between one eye and scene points.
pub trait PathSearch: Sync {
    /// All sequences of bounces that found paths refer to.
    fn paths(&self) -> &[SpecularPath];

    /// Appends all paths to `point` to `found`, the shortest (optically) first. Never panics; points that are not
    /// finite have none.
    fn search(&self, point: DVec3, found: &mut Vec<FoundPath>) -> SearchOutcome;
}
