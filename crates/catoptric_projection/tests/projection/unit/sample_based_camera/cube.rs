//! Faces of a cube of pictures, and which of them show a direction or a box.

use catoptric_core::math::Aabb;
use catoptric_core::math::random::Stream;
use catoptric_core::scene::View;
use catoptric_projection::parts::cube::{FACES, beyond, owner, shows, view};
use glam::Vec3;

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
    // A direction on a seam, too, belongs to one face.
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
