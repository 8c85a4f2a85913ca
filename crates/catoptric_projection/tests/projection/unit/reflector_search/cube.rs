//! Cube maps of a reflector.

use catoptric_core::math::random::Stream;
use catoptric_projection::parts::{CubeFaces, ImagePlace};
use glam::{Vec2, Vec3};

#[test]
fn places_and_directions_belong_together() {
    let cube = CubeFaces::new(Vec3::ZERO, 20);
    let mut random = Stream::new(3);
    for _ in 0..1000 {
        let direction = Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0))).normalize();
        let place = cube.place(direction);
        assert!(cube.direction(&place).normalize().distance(direction) < 1e-5);
        assert_eq!(cube.settled(place), place);
        // Over an edge of the face, the direction stays.
        let beside = ImagePlace { at: place.at + Vec2::new(random.next_between(-9.0, 9.0), 0.0), ..place };
        let settled = cube.settled(beside);
        let [there, here] = [settled, beside].map(|place| cube.direction(&place).normalize());
        assert!(there.distance(here) < 1e-5, "{settled:?} is not {beside:?}");
    }
}
