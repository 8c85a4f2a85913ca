//! What a leaf says about a point.

use glam::{DVec3, Vec3};

/// Where a point is seen through a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    /// The first bounce point.
    pub(super) first: DVec3,
    /// Its change with the scene point: a step of the point changes it by
    /// `moves[0] (lateral[0] . step) + moves[1] (lateral[1] . step)`.
    pub(super) moves: [Vec3; 2],
    pub(super) lateral: [Vec3; 2],
    /// A normal of the first surface there, not of unit length, on the side from which the leaf's rays were seen.
    pub(super) normal: Vec3,
    /// Focal points between the tail and the point.
    pub(super) focal_index: u32,
    /// Optical length from the eye to the point, and the part from the tail on.
    pub(super) length: f32,
    pub(super) last_segment: f32,
    /// How far from the point the leaf's ray is expected to pass, across its mean direction.
    pub(super) lateral_error: f32,
}
