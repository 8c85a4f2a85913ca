//! Views on the sides of a box.

use catoptric_core::math::Aabb;
use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::{BoxLayout, across, along};
use glam::Vec3;

fn vector(random: &mut Stream) -> Vec3 {
    Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)))
}

/// Every ray of a box that is no cube leaves by a view of one side, and comes back from there.
#[test]
fn every_ray_that_leaves_the_region_is_kept_and_found_again() {
    let region = Aabb { min: Vec3::new(-1.0, 0.5, -0.2), max: Vec3::new(0.5, 1.0, 2.0) };
    let layout = BoxLayout::new(region, 9, 16);
    let mut random = Stream::new(17);
    let count = if cfg!(debug_assertions) { 200_000 } else { 5_000_000 };
    for _ in 0..count {
        let point = region.center() + region.size() * 0.5 * vector(&mut random);
        let direction = vector(&mut random);
        let Some(ray) = layout.locate(point, direction) else { panic!("{point} {direction} is not kept") };
        let side = &layout.sides[ray.side];
        assert!(ray.direction.z >= 0.0 && ray.ahead >= 0.0);
        let exit = along(side.axis, side.plane, side.low + side.spacing * ray.st);
        let long = point + direction.normalize() * ray.ahead;
        assert!(exit.distance(long) < 1e-4, "{exit} {long}");
        // The direction passes through the view's pixels.
        let back = side.in_world(layout.direction_of(layout.pixel_of(ray.direction)));
        assert!(back.angle_between(direction) < 1e-3, "{direction} became {back}");
        // And again, from where it leaves.
        let again = layout.locate(exit - back * 1e-3, back).map(|again| (again.side, again.st));
        let (found, st) = again.unwrap_or_else(|| panic!("{exit} {back} is not kept"));
        assert!(found != ray.side || st.distance(ray.st) < 1e-2, "{st} {}", ray.st);
    }
}

#[test]
fn views_are_spread_evenly_and_are_no_more_than_those_of_slabs() {
    for size in [Vec3::ONE, Vec3::new(1.0, 2.0, 0.02), Vec3::new(1e-3, 5.0, 1e-3), Vec3::new(1e4, 1e4, 1.0)] {
        for st in [2, 3, 16, 64, 256] {
            let layout = BoxLayout::new(Aabb { min: Vec3::ZERO, max: size }, st, 8);
            let views: u32 = layout.sides.iter().map(|side| side.counts[0] * side.counts[1]).sum();
            assert!(views <= 6 * st * st, "{size} {st}: {views}");
            assert!(views * 2 > 6 * st * st || st < 4, "{size} {st}: {views}");
            for side in &layout.sides {
                assert!(side.counts.iter().all(|count| *count >= 2));
                let last = side.eye(side.counts[0] - 1, side.counts[1] - 1);
                let far = across(side.axis, last - layout.region.max).abs().max_element();
                assert!(far <= 1e-4 * size.max_element(), "the last view is in the corner");
            }
        }
    }
    let cube = BoxLayout::new(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 16, 8);
    assert!(cube.sides.iter().all(|side| side.counts == [16; 2]));
}

#[test]
fn rays_that_miss_the_region_or_mean_nothing_are_not_kept() {
    let layout = BoxLayout::new(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 5, 8);
    for (point, direction) in [
        (Vec3::new(0.5, 0.5, 3.0), Vec3::new(1.0, 0.0, 0.1)),
        (Vec3::new(0.5, 0.5, 3.0), Vec3::Z),
        (Vec3::new(0.5, 0.5, 3.0), Vec3::X),
        (Vec3::NAN, Vec3::X),
        (Vec3::new(0.5, f32::NAN, 0.5), Vec3::X),
        (Vec3::splat(0.5), Vec3::ZERO),
        (Vec3::splat(0.5), Vec3::new(1.0, f32::NAN, 0.0)),
        (Vec3::splat(0.5), Vec3::INFINITY),
    ] {
        assert_eq!(layout.locate(point, direction), None, "{point} {direction}");
    }
    // Along an axis, and from a corner.
    assert!(layout.locate(Vec3::splat(0.5), Vec3::NEG_Y).is_some_and(|ray| ray.side == 3));
    assert!(layout.locate(Vec3::ONE, Vec3::ONE).is_some());
    assert!(layout.locate(Vec3::ZERO, Vec3::X).is_some_and(|ray| ray.side == 0));
}
