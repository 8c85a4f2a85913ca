//! Numbers of nodes.

use catoptric_core::math::Aabb;
use catoptric_projection::parts::{NodeGrid, NodeKey, NodeTable};
use glam::{UVec3, Vec3};

#[test]
fn every_node_has_its_number() {
    let bounds = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
    let counts = UVec3::new(3, 4, 5);
    let grid = NodeGrid::around(&bounds, counts, 1.0);
    let table = NodeTable { grids: vec![(2, bounds, grid), (7, bounds, grid)], order: 2, counts };
    assert_eq!(table.count(), 120);
    for number in 0..120 {
        let (key, place, is_used) = table.node(number).unwrap();
        assert_eq!((table.number(key), key.reflector), (Some(number), if number < 60 { 2 } else { 7 }));
        assert_eq!((place, is_used), (grid.place(key.node), !bounds.contains(place)));
    }
    assert!(table.node(120).is_none());
    let key = |reflector: u32, node: UVec3, order: u32| NodeKey { reflector, node, order };
    for other in [key(3, UVec3::ZERO, 2), key(2, UVec3::ZERO, 1), key(2, UVec3::new(3, 0, 0), 2)] {
        assert_eq!(table.number(other), None);
    }
}
