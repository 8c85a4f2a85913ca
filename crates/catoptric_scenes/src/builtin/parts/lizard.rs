//! A flat lizard of 61 vertices, as in the pictures of the sample-based camera paper.

use super::shapes::{self, Shape};
use catoptric_core::math::portable::PortableMath;
use glam::Vec2;

/// The right half of a lizard seen from above, nose upwards at (0, 1), tail downwards: x, y.
const HALF: [[f32; 2]; 30] = [
    // Head and neck.
    [0.05, 0.98],
    [0.125, 0.91],
    [0.145, 0.80],
    [0.10, 0.70],
    [0.095, 0.64],
    // Front leg with three toes.
    [0.22, 0.645],
    [0.325, 0.72],
    [0.30, 0.85],
    [0.365, 0.805],
    [0.405, 0.90],
    [0.42, 0.795],
    [0.49, 0.83],
    [0.41, 0.66],
    [0.26, 0.545],
    // Flank.
    [0.15, 0.48],
    [0.175, 0.32],
    [0.14, 0.12],
    // Hind leg with three toes.
    [0.26, 0.14],
    [0.39, 0.05],
    [0.49, -0.08],
    [0.405, -0.065],
    [0.40, -0.19],
    [0.34, -0.085],
    [0.27, -0.15],
    [0.285, 0.005],
    [0.105, -0.06],
    // Tail.
    [0.08, -0.25],
    [0.058, -0.5],
    [0.034, -0.75],
    [0.008, -1.0],
];

/// A flat lizard in the xy plane, nose upwards, facing +z, about `length` long.
pub(in super::super) fn lizard(length: f32) -> Shape {
    // Counter-clockwise: down the left side, up the right side.
    let left = HALF.iter().map(|[x, y]| Vec2::new(-x, *y));
    let right = HALF.iter().rev().map(|[x, y]| Vec2::new(*x, *y));
    let outline: Vec<Vec2> =
        std::iter::once(Vec2::Y).chain(left).chain(right).map(|p| walking(p) * (length * 0.5)).collect();
    shapes::polygon(&outline)
}

/// One pair of legs forward and the body in a wave, without letting the outline cross itself: two shears.
fn walking(p: Vec2) -> Vec2 {
    let y = p.y + 0.22 * p.x;
    let swing = 0.06 + 0.2 * (0.3 - y).max(0.0);
    Vec2::new(p.x + swing * (y * 3.6).sine(), y)
}
