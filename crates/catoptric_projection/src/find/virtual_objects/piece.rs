//! Places of a triangle by the weights of its second and third corner, and its part in front of a plane.

use glam::{Vec2, Vec3};

/// The corners of a triangle, in its own weights.
pub const CORNERS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// A value of the vertices at a place of a triangle.
#[inline]
pub fn interpolated(values: &[Vec3], triangle: [u32; 3], weights: Vec2) -> Vec3 {
    let [right, down] = steps(values, triangle);
    values[triangle[0] as usize] + right * weights.x + down * weights.y
}

/// The steps from a triangle's first corner to the others.
#[inline]
pub(super) fn steps(values: &[Vec3], triangle: [u32; 3]) -> [Vec3; 2] {
    let [a, b, c] = triangle.map(|vertex| values[vertex as usize]);
    [b - a, c - a]
}

/// The weights of the point of a triangle's plane nearest to a place; of its middle where it has no area.
#[inline]
pub fn weights_of([a, b, c]: [Vec3; 3], place: Vec3) -> Vec2 {
    let (e1, e2, from) = (b - a, c - a, place - a);
    let (g11, g12, g22) = (e1.length_squared(), e1.dot(e2), e2.length_squared());
    let inverse = 1.0 / (g11 * g22 - g12 * g12);
    let (r1, r2) = (e1.dot(from), e2.dot(from));
    let weights = Vec2::new(g22 * r1 - g12 * r2, g11 * r2 - g12 * r1) * inverse;
    if weights.is_finite() { weights } else { Vec2::splat(1.0 / 3.0) }
}

/// Cuts off the part of a triangle whose corners have a height below 0; hands over no triangle, one or two. `mix` makes
/// the corner at a share of the way between two.
pub fn in_front<C: Copy>(
    corners: [C; 3],
    height: impl Fn(&C) -> f32,
    mix: impl Fn(&C, &C, f32) -> C,
    mut emit: impl FnMut([C; 3]),
) {
    let mut polygon = [corners[0]; 4];
    let mut count = 0;
    for k in 0..3 {
        let (here, next) = (corners[k], corners[(k + 1) % 3]);
        let (before, after) = (height(&here), height(&next));
        if before >= 0.0 {
            polygon[count] = here;
            count += 1;
        }
        if (before >= 0.0) != (after >= 0.0) {
            polygon[count] = mix(&here, &next, before / (before - after));
            count += 1;
        }
    }
    for last in 2..count {
        emit([polygon[0], polygon[last - 1], polygon[last]]);
    }
}
