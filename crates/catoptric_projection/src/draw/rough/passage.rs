//! Rays that leave a smooth mirror, and their neighbours.

use catoptric_core::scene::{Ray, RayDifferential};
use glam::Vec3;

/// A ray that leaves a mirror through a cell of a grid, the differentials to its neighbours in the grid, and its
/// length: one line of the cache.
///
/// In the plane across the ray (axes: [`axes`]), at a distance along it, the ray of the next cell of the row is away by
/// the first pair of `start` plus the distance times that of `growth`; the second pairs are those of the next row.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Passage {
    pub(super) position: Vec3,
    pub(super) direction: Vec3,
    pub(super) start: [f32; 4],
    pub(super) growth: [f32; 4],
    /// The distance of the surface that the ray shows, at most `greatest` of [`Self::new`].
    pub(super) distance: f32,
    /// The mirror that it leaves.
    pub(super) object: u32,
}

impl Passage {
    /// The passage of a ray with its change from cell to cell, and the distance of the surface that it shows, at most
    /// `greatest`.
    pub(super) fn new(object: u32, ray: &Ray, change: &RayDifferential, distance: f32, greatest: f32) -> Self {
        let (across, along) = axes(ray.direction);
        let in_plane = |dx: Vec3, dy: Vec3| [dx.dot(across), dx.dot(along), dy.dot(across), dy.dot(along)];
        Self {
            position: ray.origin,
            direction: ray.direction,
            start: in_plane(change.origin_dx, change.origin_dy),
            growth: in_plane(change.direction_dx, change.direction_dy),
            distance: distance.min(greatest),
            object,
        }
    }

    /// The steps to neighbours in the plane across the ray at a distance.
    #[inline(always)] // for the instructions of its callers
    fn steps_at(&self, distance: f32) -> [f32; 4] {
        let (start, growth) = (self.start, self.growth);
        [
            start[0] + growth[0] * distance,
            start[1] + growth[1] * distance,
            start[2] + growth[2] * distance,
            start[3] + growth[3] * distance,
        ]
    }

    /// The solid angle, seen from where the ray starts, that a cell covers at a distance.
    #[inline(always)] // for the instructions of its callers
    pub(super) fn cell_extent(&self, distance: f32) -> f32 {
        let [xx, xy, yx, yy] = self.steps_at(distance);
        let area = (xx * yy - xy * yx).abs() / (distance * distance);
        // Distances may be infinite: this is not a number then.
        if area > 1e-18 { area } else { 1e-18 }
    }

    /// The number of cells to the right and down, from the ray to the neighbour that passes through a point; zero if
    /// neighbours do not spread over the plane.
    #[inline(always)] // for the instructions of its callers
    pub(super) fn cells_to(&self, point: Vec3) -> (f32, f32) {
        let (across, along) = axes(self.direction);
        let missing = point - self.position;
        let distance = missing.dot(self.direction);
        let distance = if distance > 0.0 { distance } else { 0.0 };
        let [xx, xy, yx, yy] = self.steps_at(distance);
        let (u, v) = (missing.dot(across), missing.dot(along));
        let determinant = xx * yy - xy * yx;
        let inverse = 1.0 / determinant;
        let (right, down) = ((yy * u - yx * v) * inverse, (xx * v - xy * u) * inverse);
        let spreads = determinant * determinant > 1e-12 * (xx * xx + xy * xy) * (yx * yx + yy * yy);
        // False if they are not numbers.
        let known = spreads & (right.abs() < 1e6) & (down.abs() < 1e6);
        (if known { right } else { 0.0 }, if known { down } else { 0.0 })
    }
}

/// Two axes of the plane across a unit vector (Duff et al. 2017), for loops over lanes.
#[inline(always)]
fn axes(axis: Vec3) -> (Vec3, Vec3) {
    let sign = if axis.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let across = Vec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    (across, Vec3::new(b, sign + axis.y * axis.y * a, -axis.y))
}
