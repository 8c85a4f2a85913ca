//! Pieces of triangles.

use catoptric_projection::parts::{CORNERS, in_front, interpolated, weights_of};
use glam::{Vec2, Vec3};

#[test]
fn what_is_left_in_front_of_a_plane_has_the_area_it_should() {
    let area = |[a, b, c]: [Vec2; 3]| 0.5 * (b - a).perp_dot(c - a);
    let left = |level: f32| {
        let (mut sum, mut count) = (0.0, 0);
        in_front(
            CORNERS,
            |corner| corner.y - level,
            |a, b, share| a.lerp(*b, share),
            |piece| {
                assert!(piece.iter().all(|corner| corner.y >= level - 1e-6));
                sum += area(piece);
                count += 1;
            },
        );
        (sum, count)
    };
    assert_eq!(left(-1.0), (0.5, 1));
    assert_eq!(left(2.0), (0.0, 0));
    // The part of the unit triangle above y = 1/4 is a triangle, and that below y = 1/4 is the rest.
    assert!((left(0.25).0 - 0.5 * 0.75 * 0.75).abs() < 1e-6);
    let (below, count) = {
        let (mut sum, mut count) = (0.0, 0);
        in_front(
            CORNERS,
            |corner| 0.25 - corner.y,
            |a, b, share| a.lerp(*b, share),
            |piece| {
                sum += area(piece);
                count += 1;
            },
        );
        (sum, count)
    };
    assert!((below - 0.5 * (1.0 - 0.75 * 0.75)).abs() < 1e-6 && count == 2);
    let mut any = false;
    in_front([Vec2::NAN; 3], |corner| corner.y, |a, b, share| a.lerp(*b, share), |_| any = true);
    assert!(!any);
}

#[test]
fn weights_say_where_a_place_is() {
    let corners = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 2.5, 3.0), Vec3::new(1.0, 3.0, 5.0)];
    for weights in [Vec2::ZERO, Vec2::X, Vec2::new(0.2, 0.7), Vec2::new(-1.0, 3.0)] {
        let place = interpolated(&corners, [0, 1, 2], weights);
        assert!(weights_of(corners, place).distance(weights) < 1e-5);
    }
    assert_eq!(weights_of([Vec3::ONE; 3], Vec3::ZERO), Vec2::splat(1.0 / 3.0));
}
