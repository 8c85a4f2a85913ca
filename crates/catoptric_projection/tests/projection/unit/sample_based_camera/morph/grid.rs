//! Grids of nodes, and the weights of those around a place.

use catoptric_core::math::Aabb;
use catoptric_core::math::random::Stream;
use catoptric_projection::parts::{NodeGrid, Tetrahedron, node_counts};
use glam::{UVec3, Vec3};

#[test]
fn counts_are_three_numbers() {
    assert_eq!(node_counts("17x16x8"), Ok(UVec3::new(17, 8, 16)));
    for wrong in ["", "17", "17x17", "1x17x8", "17x17x8x2", "17x17x300", "axbxc", "-2x3x4"] {
        assert!(node_counts(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn a_place_is_the_mean_of_its_nodes_and_weights_change_without_a_jump() {
    let bounds = Aabb { min: Vec3::new(1.0, 2.0, 3.0), max: Vec3::new(2.0, 4.0, 3.5) };
    let grid = NodeGrid::around(&bounds, UVec3::new(9, 5, 7), 1.5);
    let ends = [grid.place(UVec3::ZERO), grid.place(UVec3::new(8, 4, 6))];
    assert!((ends[1].x - ends[0].x - 4.0 * bounds.diagonal()).abs() < 1e-4);
    assert!(((ends[0] + ends[1]) * 0.5).distance(bounds.center()) < 1e-5);
    let mut random = Stream::new(3);
    let any =
        |random: &mut Stream| ends[0] + (ends[1] - ends[0]) * Vec3::from([0; 3].map(|_| random.next_between(0.0, 1.0)));
    let weight = |corners: &Tetrahedron, node: UVec3| {
        corners.iter().find(|(other, _)| *other == node).map_or(0.0, |(_, weight)| *weight)
    };
    for _ in 0..2000 {
        let place = any(&mut random);
        let corners = grid.tetrahedron(place).unwrap();
        let mean: Vec3 = corners.iter().map(|(node, weight)| grid.place(*node) * *weight).sum();
        let sum: f32 = corners.iter().map(|(_, weight)| weight).sum();
        assert!(mean.distance(place) < 1e-4 && (sum - 1.0).abs() < 1e-5, "{corners:?}");
        // A thousandth of a cell farther no weight has changed by more than some thousandths.
        let Some(moved) = grid.tetrahedron(place + Vec3::new(1.0, -1.0, 1.0) * 1e-3 * grid.spacing) else {
            continue;
        };
        for (node, _) in corners.iter().chain(&moved) {
            let change = weight(&corners, *node) - weight(&moved, *node);
            assert!(change.abs() < 4e-3, "{change} at {node}");
        }
    }
    // A node counts alone at its own place, but for rounding.
    let corners = grid.tetrahedron(ends[0] + Vec3::splat(2.0 * grid.spacing)).unwrap();
    assert!(weight(&corners, UVec3::splat(2)) > 1.0 - 1e-5, "{corners:?}");
    assert_eq!(grid.tetrahedron(ends[0] - Vec3::X * 1e-3), None);
    assert_eq!(grid.tetrahedron(Vec3::NAN), None);
}
