//! Points that are looked for once.

use catoptric_projection::parts::{PointCache, work};
use glam::Vec3;
use std::sync::Arc;

#[test]
fn a_point_is_looked_for_once_and_counts_as_the_same_work() {
    let cache = PointCache::default();
    let mut looked = 0;
    let mut ask = |path: u32, point: Vec3| {
        let before = work::done();
        let found = cache.get(path, point, || {
            looked += 1;
            work::add(7);
            Arc::from([path])
        });
        assert_eq!((found[0], work::since(before)), (path, 7));
    };
    for _ in 0..3 {
        ask(0, Vec3::ONE);
        ask(1, Vec3::ONE);
        ask(0, Vec3::X);
    }
    assert_eq!((looked, cache.count()), (3, 3));
}
