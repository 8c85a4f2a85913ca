//! The six faces of a cube around an eye: pictures of 90 degrees along the axes, and which of them a direction is in.

use catoptric_core::math::Aabb;
use catoptric_core::scene::{Projection, View};
use catoptric_engine::light::cube_map::place_on_face;
use glam::{Affine3A, Mat3A, Vec3};
use std::f32::consts::FRAC_PI_2;

/// The faces of a cube.
pub(super) const FACES: usize = 6;

/// Boxes are so much larger, as a share of their size: bounds are rounded. Chosen well above rounding, not measured.
const WIDER: f32 = 1e-4;

/// Direction of a face: along x, y, z, each forwards and backwards.
fn axis(face: usize) -> Vec3 {
    let axis = Vec3::AXES[face / 2];
    if face & 1 == 0 { axis } else { -axis }
}

/// The view of a face.
pub(super) fn view(face: usize, eye: Vec3, size_px: u32, near: f32) -> View {
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
pub(super) fn owner(direction: Vec3) -> usize {
    place_on_face(direction.to_array()).0 as usize
}

/// Distance of a direction beyond the border of a face, in half faces on its picture; negative within, infinite behind.
pub(super) fn beyond(face: usize, direction: Vec3) -> f32 {
    let along = direction.dot(axis(face));
    let mut across = direction.abs();
    across[face / 2] = 0.0;
    if along > 0.0 { across.max_element() / along - 1.0 } else { f32::INFINITY }
}

/// True if some of a box may appear in a face that is seen with a margin of so many half faces on every side.
pub(super) fn shows(face: usize, margin: f32, eye: Vec3, bounds: &Aabb) -> bool {
    let wider = bounds.diagonal() * WIDER;
    let (low, high) = (bounds.min - eye - wider, bounds.max - eye + wider);
    let axis = face / 2;
    let farthest = if face & 1 == 0 { high[axis] } else { -low[axis] };
    // What is seen widens with the distance: where the box ends it is all that is seen nearer, projected.
    let half = (1.0 + margin) * farthest;
    farthest > 0.0 && (0..3).filter(|&other| other != axis).all(|other| low[other] <= half && high[other] >= -half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_core::math::random::Stream;

    fn any_direction(random: &mut Stream) -> Vec3 {
        Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)))
    }

    #[test]
    fn every_direction_is_in_the_picture_of_its_face_alone() {
        let eye = Vec3::new(0.5, -2.0, 3.0);
        let views: [View; FACES] = std::array::from_fn(|face| view(face, eye, 64, 1e-6));
        let mut random = Stream::new(5);
        for _ in 0..10_000 {
            let direction = any_direction(&mut random);
            let own = owner(direction);
            for (face, view) in views.iter().enumerate() {
                let inside = view.pixel_of(eye + direction).map(|px| 1.0 - (px / 32.0 - 1.0).abs().max_element());
                let beyond = beyond(face, direction);
                match inside {
                    Some(inside) if inside > -1.0 => assert!((inside + beyond).abs() < 1e-3, "{direction} in {face}"),
                    _ => assert!(beyond > 0.99, "{direction} in {face}"),
                }
                assert!((face == own) == (beyond <= 0.0), "{direction} in {face}");
            }
        }
        // On the seams, too, a direction belongs to one face.
        for direction in [Vec3::ONE, -Vec3::ONE, Vec3::new(0.0, 2.0, -2.0), Vec3::new(-1.0, 1.0, 0.0)] {
            assert_eq!(beyond(owner(direction), direction), 0.0);
        }
        assert_eq!([Vec3::ONE, Vec3::new(0.0, 2.0, -2.0), Vec3::NEG_Z].map(owner), [0, 2, 5]);
    }

    #[test]
    fn faces_in_which_a_box_appears_are_those_that_its_points_are_in() {
        let mut random = Stream::new(6);
        let mut left_out = 0;
        for _ in 0..300 {
            let (eye, center) = (any_direction(&mut random), any_direction(&mut random) * 3.0);
            let half = any_direction(&mut random).abs() * 0.5;
            let bounds = Aabb { min: center - half, max: center + half };
            let mut seen = [false; FACES];
            for _ in 0..2000 {
                let point = center + half * any_direction(&mut random);
                seen[owner(point - eye)] = true;
            }
            for (face, seen) in seen.into_iter().enumerate() {
                let shown = shows(face, 0.0, eye, &bounds);
                assert!(shown || !seen, "{bounds:?} from {eye} in {face}");
                left_out += usize::from(!shown);
            }
        }
        assert!(left_out > 300 * 3, "{left_out} faces are left out");
    }
}
