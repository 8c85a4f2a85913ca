//! Directions of a half-space on a square: half an octahedron, unfolded and turned by 45 degrees (Cigolle, Donow,
//! Evangelakos, Mara, McGuire, Meyer 2014, A survey of efficient representations for independent unit vectors).
//!
//! Directions are x and y across an axis and z along it, with z at least 0. The sum of the sizes of what [`direction`]
//! gives is 1, not its length: each of the four faces of the half octahedron is a plane, so that views in it have
//! straight lines where the scene has them.

use glam::{Vec2, Vec3};

/// The place from -1 to 1 of a direction of any length but 0; the middle is the axis.
#[inline(always)] // for the instructions of its caller
pub(crate) fn place(direction: Vec3) -> Vec2 {
    let Vec3 { x, y, z } = direction;
    let per_size = 1.0 / (x.abs() + y.abs() + z);
    Vec2::new(x + y, x - y) * per_size
}

/// The direction of a place: the sum of the sizes of its components is 1.
#[inline(always)] // for the instructions of its caller
pub(crate) fn direction(place: Vec2) -> Vec3 {
    let (x, y) = (0.5 * (place.x + place.y), 0.5 * (place.x - place.y));
    Vec3::new(x, y, (1.0 - x.abs() - y.abs()).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_core::math::random::Stream;

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
}
