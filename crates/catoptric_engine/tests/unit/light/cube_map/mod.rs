//! Places on cubes.

mod filtered;

use catoptric_core::math::random::Stream;
use catoptric_engine::light::cube_map::{FACES, direction_of, locate};
use glam::{Vec2, Vec3};

#[test]
fn places_of_faces_are_found_again() {
    let mut random = Stream::new(3);
    for number in 0..600 {
        let (face, at) = (number % 6, Vec2::from([0; 2].map(|_| random.next_between(-0.999, 0.999))));
        let direction = direction_of(face, at) * random.next_between(0.1, 10.0);
        let (found, place, secant2) = locate(direction);
        let cosine = -direction.normalize().dot(FACES[face][2].into());
        assert!(found == face && place.distance(at) < 1e-5, "{face} {at}: {found} {place}");
        assert!((secant2 * cosine * cosine - 1.0).abs() < 1e-5);
    }
    for nowhere in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 1.0)] {
        let (face, at, secant2) = locate(nowhere);
        assert!(face < 6 && at.abs().max_element() <= 1.0 && secant2 >= 1.0, "{nowhere}: {face} {at}");
    }
}
