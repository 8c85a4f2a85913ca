//! Layers that become one.

use catoptric_core::math::random::Stream;
use catoptric_lookup::layered_environment_map::Shells;
use catoptric_lookup::parts::merged_by_shape;
use glam::Vec3;

#[test]
fn the_sides_of_a_room_belong_together_whatever_their_distances() {
    let mut random = Stream::new(6);
    let mut number = || random.next_between(-1.0, 1.0);
    let mut things: Vec<Vec<Vec3>> = Vec::new();
    // Six sides of a flat room, and in it a ring of three things as far away as its floor.
    for (axis, at) in [(0, 8.0), (0, -8.0), (1, 4.0), (1, -1.5), (2, 7.0), (2, -7.0)] {
        let half = Vec3::new(8.0, 1.5, 7.0);
        let point = |_| {
            let mut point = half * Vec3::new(number(), number(), number());
            point[axis] = at;
            point
        };
        things.push((0..300).map(point).collect());
    }
    for turn in 0..3 {
        let middle = glam::Quat::from_rotation_y(turn as f32 * 2.1) * Vec3::new(3.0, 0.0, 0.0);
        things.push((0..100).map(|_| middle + 0.2 * Vec3::new(number(), number(), number())).collect());
    }
    let found = merged_by_shape(&things, 2, Shells::Auto);
    assert!(found[..6].iter().all(|cluster| *cluster == found[0]), "{found:?}");
    assert!(found[6..].iter().all(|cluster| *cluster == found[6] && *cluster != found[0]), "{found:?}");
    let one = merged_by_shape(&things, 1, Shells::Auto);
    assert!(one.iter().all(|cluster| *cluster == 0));
    let own = merged_by_shape(&things, 20, Shells::Auto);
    assert_eq!(own.iter().collect::<std::collections::HashSet<_>>().len(), 9);
    assert!(merged_by_shape(&[], 3, Shells::Auto).is_empty());
}
