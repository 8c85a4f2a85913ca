//! Slabs about a region.

use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::{Lanes, Vec3Lanes};
use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::{Slab, SlabLayout, along};
use glam::{Vec2, Vec3};

fn vector(random: &mut Stream) -> Vec3 {
    Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)))
}

/// A ray's slab, its place on the plane of views, and its slope.
fn located(layout: &SlabLayout, point: Vec3, direction: Vec3) -> Option<(Slab, Vec2, Vec2)> {
    let ray = layout.locate(&Vec3Lanes::one(point), &Vec3Lanes::one(direction));
    let pair = |of: [Lanes<1>; 2]| Vec2::new(of[0][0], of[1][0]);
    (ray.held[0] > 0.0).then(|| (layout.slabs[ray.slab[0] as usize], pair(ray.st), pair(ray.slope)))
}

/// Tests rays of a box that is no cube, in ten million tries in release.
#[test]
fn every_ray_through_the_region_is_in_a_slab() {
    let region = Aabb { min: Vec3::new(-1.0, 0.5, -0.2), max: Vec3::new(0.5, 1.0, 2.0) };
    let layout = SlabLayout::new(region, 9, 16);
    let mut random = Stream::new(17);
    let count = if cfg!(debug_assertions) { 200_000 } else { 10_000_000 };
    for _ in 0..count {
        let point = region.center() + region.size() * 0.5 * vector(&mut random);
        let direction = vector(&mut random);
        let found = located(&layout, point, direction);
        let (slab, st, slope) = found.unwrap_or_else(|| panic!("{point} {direction} is not held"));
        assert!(slope.abs().max_element() <= 1.0 + 1e-6);
        // The ray found is that ray: the point lies on the line through the place of the plane with that slope.
        let on_plane = along(slab.axis, slab.plane, slab.low + slab.spacing * st);
        let back = slab.direction(slope);
        let to_point = point - on_plane;
        let off = to_point - back * (to_point.dot(back) / back.length_squared());
        assert!(off.length() < 1e-4 && back.dot(direction) > 0.0, "{point} {direction}: {off}");
    }
}

#[test]
fn a_cube_has_views_over_three_times_its_side() {
    let layout = SlabLayout::new(Aabb { min: Vec3::ZERO, max: Vec3::splat(2.0) }, 4, 8);
    for slab in &layout.slabs {
        assert_eq!(slab.spacing * 3.0, Vec2::splat(6.0));
    }
}

#[test]
fn rays_leave_the_region_and_are_nearest_to_its_middle() {
    let region = Aabb { min: Vec3::new(-1.0, -0.5, -0.25), max: Vec3::new(1.0, 0.5, 0.25) };
    let layout = SlabLayout::new(region, 5, 8);
    let mut random = Stream::new(5);
    for _ in 0..2000 {
        let point = region.center() + region.size() * 0.5 * vector(&mut random);
        let direction = vector(&mut random).normalize();
        let Some((slab, st, slope)) = located(&layout, point, direction) else { panic!("{point} {direction}") };
        let eye = along(slab.axis, slab.plane, slab.low + slab.spacing * st);
        let start = eye - slab.direction(slope) * slab.exit(&region, eye, slope);
        // The start lies on the region's surface, and not before the point.
        let outside = |place: Vec3| (region.min - place).max(place - region.max).max_element();
        assert!(outside(start).abs() < 1e-4, "{start} is {} outside", outside(start));
        assert!((start - point).dot(direction) > -1e-4);
        let start = eye - slab.direction(slope) * slab.nearest(&region, eye, slope);
        assert!(outside(start) < 1e-4, "{start} is outside");
        // Nowhere in the region is the ray nearer to the middle.
        let nearer = region.center().distance(point) < region.center().distance(start) - 1e-4;
        assert!(!nearer, "{point} is nearer than {start}");
    }
}

#[test]
fn rays_that_miss_the_region_or_mean_nothing_are_not_held() {
    let layout = SlabLayout::new(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 5, 8);
    for (point, direction) in [
        (Vec3::new(0.5, 0.5, 3.0), Vec3::new(1.0, 0.0, 0.1)),
        (Vec3::NAN, Vec3::X),
        (Vec3::new(0.5, f32::NAN, 0.5), Vec3::X),
        (Vec3::new(0.5, 0.5, f32::NAN), Vec3::X),
        (Vec3::splat(0.5), Vec3::ZERO),
        (Vec3::splat(0.5), Vec3::new(1.0, f32::NAN, 0.0)),
        (Vec3::splat(0.5), Vec3::new(1.0, 0.0, f32::NAN)),
        (Vec3::splat(0.5), Vec3::INFINITY),
    ] {
        assert_eq!(located(&layout, point, direction), None, "{point} {direction}");
    }
}
