//! Shapes of shells.

use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::Vec3Lanes;
use catoptric_core::math::random::Stream;
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use catoptric_lookup::layered_environment_map::Shells;
use catoptric_lookup::parts::{RayLanes, Shell};
use glam::Vec3;

/// Points where rays from the middle meet a shape.
fn points(surround: &ParallaxProxy) -> Vec<Vec3> {
    let mut random = Stream::new(9);
    let mut number = || random.next_between(-1.0, 1.0);
    let directions = (0..3000).map(|_| Vec3::new(number(), number(), number()).normalize());
    directions.map(|direction| direction * surround.distance(Vec3::ZERO, Vec3::ZERO, direction)).collect()
}

#[test]
fn shapes_are_found_again() {
    let room = ParallaxProxy::Box(Aabb { min: Vec3::new(-3.0, -1.0, -4.0), max: Vec3::new(2.0, 2.0, 5.0) });
    let shapes = [ParallaxProxy::Sphere(2.5), room, ParallaxProxy::Cylinder { radius: 2.0, bottom: -1.0, top: 3.0 }];
    for shape in shapes {
        let points = points(&shape);
        let found = Shell::fit(Shells::Auto, &points);
        assert_eq!(found.name(), Shell::Around(shape).name());
        assert!(found.relative_error(&points) < 0.01, "{found:?} for {shape:?}");
        let wrong = if matches!(shape, ParallaxProxy::Sphere(_)) { Shells::Box } else { Shells::Sphere };
        assert!(Shell::fit(wrong, &points).relative_error(&points) > 0.1);
    }
}

#[test]
fn what_stands_on_one_side_becomes_a_quad() {
    let mut random = Stream::new(2);
    let mut number = || random.next_between(-1.0, 1.0);
    let points: Vec<Vec3> = (0..500).map(|_| Vec3::new(3.0, 0.5 + number(), 0.3 * number())).collect();
    let found = Shell::fit(Shells::Auto, &points);
    assert_eq!(found.name(), "quads");
    let rays = |direction: Vec3| RayLanes::sharp(Vec3Lanes::ZERO, Vec3Lanes::one(direction));
    let place_of = |direction: Vec3| found.places(&rays(direction)).vector(0);
    for point in &points {
        let place = place_of(point.normalize());
        assert!(place.abs().max_element() <= 1.0, "{place}");
        // The way there and back.
        assert!(found.towards(place).normalize().distance(point.normalize()) < 1e-5);
    }
    assert!(place_of(Vec3::NEG_X).is_finite());
    assert!(place_of(Vec3::new(-0.1, 1.0, 0.0).normalize()).abs().max_element() > 1.0, "is not met");
}
