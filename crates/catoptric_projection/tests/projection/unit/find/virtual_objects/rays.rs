//! Virtual points and focal points of rays.

use catoptric_core::math::random::Stream;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_projection::parts::{ReflectionPoint, VertexRays, focal_points, outer, seen_through};
use glam::{Mat3, Vec2, Vec3};

fn vector(random: &mut Stream) -> Vec3 {
    Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)))
}

#[test]
fn points_behind_a_plane_of_glass_appear_where_snells_law_says() {
    let mut random = Stream::new(31);
    let mut tested = 0;
    for _ in 0..2000 {
        let eta = random.next_between(0.5, 2.0);
        let (normal, position) = (vector(&mut random).normalize(), vector(&mut random));
        let incoming = (vector(&mut random) - normal).normalize();
        let (before, after) = (random.next_between(0.5, 3.0), random.next_between(0.5, 3.0));
        let Some(outgoing) = catoptric_engine::optics::refract(incoming, normal, eta) else { continue };
        if -incoming.dot(normal) < 0.1 || -outgoing.dot(normal) < 0.1 {
            continue;
        }
        // The plane is given by another of its points.
        let other = position + normal.cross(vector(&mut random));
        let seen = seen_through(position - incoming * before, position + outgoing * after, other, normal, eta);
        let expected = position + incoming * after;
        assert!(seen.unwrap().distance(expected) < 2e-4, "{seen:?}, not {expected}");
        tested += 1;
    }
    assert!(tested > 1000);
}

#[test]
fn changes_of_virtual_points_are_those_of_differences() {
    let mut random = Stream::new(32);
    let mut tested = 0;
    for case in 0..400 {
        let kind = if case % 2 == 0 { BounceKind::Reflect } else { BounceKind::Transmit };
        let eta = if case % 2 == 0 { 1.0 } else { random.next_between(0.6, 1.6) };
        let normal = vector(&mut random).normalize();
        let matrix = |random: &mut Stream| Mat3::from_cols(vector(random), vector(random), vector(random)) * 0.3;
        let (position_change, bend) = (matrix(&mut random), matrix(&mut random));
        let reflection_point = ReflectionPoint {
            position: vector(&mut random),
            normal,
            position_change,
            // The derivative of a unit normal is across it.
            normal_change: bend - outer(normal, bend.transpose() * normal),
            origin: normal * 3.0 + vector(&mut random),
            triangle: 0,
            weights: Vec2::ZERO,
            beyond: false,
            blended_image: None,
        };
        let point = reflection_point.position + if eta == 1.0 { normal } else { -normal } * 2.0 + vector(&mut random);
        let rays = VertexRays {
            kind,
            side: 1.0,
            eta,
            inside_after: false,
            index_after: 1.0,
            origins: Vec::new(),
            incoming: Vec::new(),
            cosines: Vec::new(),
            outgoing: Vec::new(),
            states: Vec::new(),
        };
        let Some((_, change)) = reflection_point.virtual_point(&rays, point) else { continue };
        let step = 5e-3;
        for axis in 0..3 {
            let at = |sign: f32| {
                let by = Vec3::AXES[axis] * (step * sign);
                let moved = ReflectionPoint {
                    position: reflection_point.position + reflection_point.position_change * by,
                    normal: (reflection_point.normal + reflection_point.normal_change * by).normalize(),
                    ..reflection_point
                };
                moved.virtual_point(&rays, point + by).unwrap().0
            };
            let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
            let error = difference.distance(change.col(axis));
            assert!(error < 0.02 * (1.0 + difference.length()), "{kind:?}: {difference}, not {}", change.col(axis));
        }
        tested += 1;
    }
    assert!(tested > 300);
}

#[test]
fn focal_points_are_counted_on_the_way() {
    let counts = |areas| [0.5, 2.0, 4.0].map(|distance| focal_points(areas, distance));
    assert_eq!(counts([3.0, -4.0, 1.0]), [0, 1, 2], "(t - 1)(t - 3)");
    assert_eq!(counts([-3.0, 4.0, -1.0]), [0, 1, 2], "the same, turned about");
    assert_eq!(counts([1.0, -1.0, 0.0]), [0, 1, 1], "one");
    assert_eq!(counts([1.0, 1.0, 1.0]), [0, 0, 0], "none");
    assert_eq!(counts([3.0, 2.0, -1.0]), [0, 0, 1], "a saddle: -(t + 1)(t - 3)");
    assert_eq!(counts([1.01, -2.0, 1.0]), [0, 2, 2], "both at the same place, but for rounding");
    assert_eq!(focal_points([f32::NAN, 1.0, 1.0], 1.0), 0);
}
