//! Shapes that stand for surroundings.

use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::Vec3Lanes;
use catoptric_core::math::random::Stream;
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use glam::{Vec2, Vec3};

#[test]
fn rays_meet_the_shape() {
    let bounds = Aabb { min: Vec3::new(-1.0, -2.0, -3.0), max: Vec3::new(1.0, 2.0, 3.0) };
    let center = Vec3::new(0.1, 0.2, 0.3);
    let position = Vec3::new(0.5, 0.0, 0.0);
    let hit = ParallaxProxy::Box(bounds).direction(center, position, Vec3::X) + center;
    assert!((hit - Vec3::new(1.0, 0.0, 0.0)).length() < 1e-6);
    assert_eq!(ParallaxProxy::Box(bounds).distance(center, position, Vec3::X), 0.5);
    assert_eq!(ParallaxProxy::Infinite.distance(center, position, Vec3::X), f32::INFINITY);
    let slanted = Vec3::new(0.0, -0.6, 0.8);
    let hit = ParallaxProxy::Box(bounds).direction(center, position, slanted) + center;
    assert!((hit - Vec3::new(0.5, -2.0, 2.0 / 0.6 * 0.8)).length() < 1e-5, "{hit}");
    let hit = ParallaxProxy::Sphere(2.0).direction(center, position, slanted) + center;
    assert!(((hit - center).length() - 2.0).abs() < 1e-5);
    assert!((hit - position).cross(slanted).length() < 1e-5 && (hit - position).dot(slanted) > 0.0);
}

#[test]
fn rays_meet_the_side_and_the_ends_of_a_cylinder() {
    let cylinder = ParallaxProxy::Cylinder { radius: 2.0, bottom: -1.0, top: 3.0 };
    let center = Vec3::new(5.0, 0.0, 1.0);
    let position = center + Vec3::new(0.5, 0.5, 0.0);
    let distance = |direction: Vec3| cylinder.distance(center, position, direction.normalize());
    assert!((distance(Vec3::X) - 1.5).abs() < 1e-6);
    assert!((distance(Vec3::Y) - 2.5).abs() < 1e-6 && (distance(Vec3::NEG_Y) - 1.5).abs() < 1e-6);
    let found = cylinder.direction(center, position, Vec3::new(-0.6, 0.1, 0.8).normalize());
    assert!((Vec2::new(found.x, found.z).length() - 2.0).abs() < 1e-5, "{found}");
    let found = cylinder.direction(center, position, Vec3::new(0.1, -0.9, 0.0).normalize());
    assert!((found.y + 1.0).abs() < 1e-5, "{found}");
}

#[test]
fn shares_are_distances_by_those_of_the_shape() {
    let bounds = Aabb { min: Vec3::new(-1.0, 0.0, -3.0), max: Vec3::new(1.5, 2.0, 3.0) };
    let cylinder = ParallaxProxy::Cylinder { radius: 2.0, bottom: -1.0, top: 3.0 };
    let mut random = Stream::new(3);
    for shape in [ParallaxProxy::Box(bounds), ParallaxProxy::Sphere(1.7), cylinder] {
        for _ in 0..200 {
            // Above the bottom of the box, which is at the origin.
            let place = Vec3::from([-4.0, 0.0, -4.0].map(|low| random.next_between(low, 4.0)));
            let [share] = shape.shares(&Vec3Lanes::one(place)).0;
            let expected = place.length() / shape.distance(Vec3::ZERO, Vec3::ZERO, place.normalize());
            assert!((share - expected).abs() < 1e-5 * expected, "{shape:?} {place}: {share}, {expected}");
        }
        assert_eq!(shape.shares(&Vec3Lanes::one(Vec3::ZERO)).0, [0.0]);
    }
}

#[test]
fn positions_outside_the_shape_give_a_direction() {
    let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
    let cylinder = ParallaxProxy::Cylinder { radius: 1.0, bottom: -1.0, top: 1.0 };
    for shape in [ParallaxProxy::Box(bounds), ParallaxProxy::Sphere(1.0), cylinder] {
        for direction in [Vec3::X, Vec3::NEG_X, Vec3::ZERO] {
            let found = shape.direction(Vec3::ZERO, Vec3::new(5.0, 0.0, 0.0), direction);
            assert!(found.is_finite());
        }
    }
}
