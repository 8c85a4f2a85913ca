//! Directions of a half-space on a square: half an octahedron, unfolded and turned by 45 degrees (Cigolle, Donow,
//! Evangelakos, Mara, McGuire, Meyer 2014, A survey of efficient representations for independent unit vectors).
//!
//! Directions are x and y across an axis and z along it, with z at least 0. The sum of the sizes of the components that
//! [`direction`] gives is 1, not its length: each of the four faces of the half octahedron is a plane, so that views in
//! it have straight lines where the scene has them.

use glam::{Vec2, Vec3};

/// The place from -1 to 1 of a direction of any length but 0; the middle is the axis.
#[inline(always)] // for the instructions of its caller
pub fn place(direction: Vec3) -> Vec2 {
    let Vec3 { x, y, z } = direction;
    let per_size = 1.0 / (x.abs() + y.abs() + z);
    Vec2::new(x + y, x - y) * per_size
}

/// The direction of a place: the sum of the sizes of its components is 1.
#[inline(always)] // for the instructions of its caller
pub fn direction(place: Vec2) -> Vec3 {
    let (x, y) = (0.5 * (place.x + place.y), 0.5 * (place.x - place.y));
    Vec3::new(x, y, (1.0 - x.abs() - y.abs()).max(0.0))
}
