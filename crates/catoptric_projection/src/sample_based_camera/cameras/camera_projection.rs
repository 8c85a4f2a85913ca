//! Projection of a point by a leaf.

use glam::{DVec3, Vec3};

/// A point projected by a leaf.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct CameraProjection {
    /// The first bounce point.
    pub(in super::super) first: DVec3,
    /// The derivative of `first` with respect to the scene point: a step of the point changes it by
    /// `moves[0] (lateral[0] . step) + moves[1] (lateral[1] . step)`.
    pub(in super::super) moves: [Vec3; 2],
    pub(in super::super) lateral: [Vec3; 2],
    /// A normal of the first surface there, not of unit length, on the side from which the leaf's rays were seen.
    pub(in super::super) normal: Vec3,
    /// Focal points between the tail and the point.
    pub(in super::super) focal_index: u32,
    /// Optical length from the eye to the point, and the part from the tail on.
    pub(in super::super) length: f32,
    pub(in super::super) last_segment: f32,
    /// The expected distance between the point and the leaf's ray, across its mean direction.
    pub(in super::super) lateral_error: f32,
}
