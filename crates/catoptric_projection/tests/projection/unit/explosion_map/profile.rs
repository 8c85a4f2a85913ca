//! Segments of profiles.

use catoptric_core::math::random::Stream;
use catoptric_projection::parts::SegmentBlock;
use glam::Vec2;

#[test]
fn rays_that_leave_a_segment_are_found_from_points_on_them() {
    let mut random = Stream::new(8);
    let mut vector = || Vec2::new(random.next_between(-1.0, 1.0), random.next_between(-1.0, 1.0));
    let mut tested = 0;
    for _ in 0..2000 {
        let (from, edge, directions) = (vector(), vector(), [vector().normalize(), vector().normalize()]);
        let mut block = SegmentBlock::default();
        block.set(5, from, edge, directions, [0.0, 1.0]);
        let share = 0.5 + 0.49 * vector().x;
        let (reflection_point, direction) = (from + edge * share, directions[0].lerp(directions[1], share));
        let distance = 1.5 + vector().x;
        let place = reflection_point + direction * distance;
        // Rounding moves the reflection point near a focal point, or along the segment.
        let slope = (edge + (directions[1] - directions[0]) * distance).perp_dot(direction);
        if slope.abs() < 0.05 * edge.length() {
            continue;
        }
        assert!(block.hold(place)[5], "{place}");
        let found = block.reflection_points(5, place);
        assert!(
            found.iter().flatten().any(|found| found.distance(reflection_point) < 1e-3),
            "{found:?}, not {reflection_point}"
        );
        for other in found.into_iter().flatten() {
            let share = (other - from).dot(edge) / edge.length_squared();
            let direction = directions[0].lerp(directions[1], share);
            assert!((place - other).perp_dot(direction).abs() < 1e-3, "{other}");
        }
        tested += 1;
    }
    assert!(tested > 1500);
}
