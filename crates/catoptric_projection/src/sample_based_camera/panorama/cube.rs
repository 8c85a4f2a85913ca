//! The six faces of a cube around an eye: pictures of 90 degrees along the axes, and which of them a direction is in.

use catoptric_core::math::Aabb;
use catoptric_core::scene::{Projection, View};
use catoptric_engine::light::cube_map::place_on_face;
use glam::{Affine3A, Mat3A, Vec3};
use std::f32::consts::FRAC_PI_2;

/// The faces of a cube.
pub const FACES: usize = 6;

/// Boxes are so much larger, as a share of their size: bounds are rounded. Chosen well above rounding, not measured.
const WIDER: f32 = 1e-4;

/// Direction of a face: along x, y, z, each forwards and backwards.
fn axis(face: usize) -> Vec3 {
    let axis = Vec3::AXES[face / 2];
    if face & 1 == 0 { axis } else { -axis }
}

/// The view of a face.
pub fn view(face: usize, eye: Vec3, size_px: u32, near: f32) -> View {
    let forward = axis(face);
    let up = if face / 2 == 1 { Vec3::Z } else { Vec3::Y };
    let matrix3 = Mat3A::from_cols(forward.cross(up).into(), up.into(), (-forward).into());
    View {
        world_from_view: Affine3A { matrix3, translation: eye.into() },
        projection: Projection::Perspective { fov_y: FRAC_PI_2 },
        width: size_px,
        height: size_px,
        near,
    }
}

/// The face that a direction of any length belongs to: that of its largest component, and of the first of these where
/// several are as large.
pub fn owner(direction: Vec3) -> usize {
    place_on_face(direction.to_array()).0 as usize
}

/// Distance of a direction beyond the border of a face, in half faces on its picture; negative within, infinite behind.
pub fn beyond(face: usize, direction: Vec3) -> f32 {
    let along = direction.dot(axis(face));
    let mut across = direction.abs();
    across[face / 2] = 0.0;
    if along > 0.0 { across.max_element() / along - 1.0 } else { f32::INFINITY }
}

/// True if some of a box may appear in a face that is seen with a margin of so many half faces on every side.
pub fn shows(face: usize, margin: f32, eye: Vec3, bounds: &Aabb) -> bool {
    let wider = bounds.diagonal() * WIDER;
    let (low, high) = (bounds.min - eye - wider, bounds.max - eye + wider);
    let axis = face / 2;
    let farthest = if face & 1 == 0 { high[axis] } else { -low[axis] };
    // The pyramid of the face widens with the distance: at the far end of the box it covers everything nearer,
    // projected.
    let half = (1.0 + margin) * farthest;
    farthest > 0.0 && (0..3).filter(|&other| other != axis).all(|other| low[other] <= half && high[other] >= -half)
}
