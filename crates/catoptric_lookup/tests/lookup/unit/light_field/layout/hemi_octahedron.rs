//! Directions of a half space as places.

use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::hemi_octahedron::{direction, place};
use glam::{Vec2, Vec3};

#[test]
fn directions_have_places_and_places_directions() {
    let mut random = Stream::new(3);
    for _ in 0..100_000 {
        let [x, y, z] = [0; 3].map(|_| random.next_between(-1.0, 1.0));
        let there = Vec3::new(x, y, z.abs());
        let at = place(there);
        assert!(at.abs().max_element() <= 1.0 + 1e-6, "{there} is at {at}");
        let back = direction(at);
        assert!((back.abs().element_sum() - 1.0).abs() < 1e-6, "{back}");
        assert!(back.angle_between(there) < 1e-3, "{there} became {back}");
        assert!(place(direction(Vec2::new(x, y))).distance(Vec2::new(x, y)) < 1e-6);
    }
}

#[test]
fn the_border_is_the_horizon() {
    for along in [-1.0, -0.4, 0.0, 0.7, 1.0] {
        for at in [Vec2::new(1.0, along), Vec2::new(-1.0, along), Vec2::new(along, 1.0), Vec2::new(along, -1.0)] {
            assert!(direction(at).z.abs() < 1e-6);
        }
    }
    assert_eq!(direction(Vec2::ZERO), Vec3::Z);
}
