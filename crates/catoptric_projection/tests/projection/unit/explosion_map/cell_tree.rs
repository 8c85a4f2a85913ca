//! Cells of a reflector's rays, and their order.

use catoptric_core::math::lanes::LANES;
use catoptric_core::math::random::Stream;
use catoptric_projection::parts::{CellLeaf, NEAR, gather};
use glam::Vec3;

#[test]
fn points_of_a_cell_are_found_in_it() {
    let mut random = Stream::new(12);
    let mut vector = |size: f32| Vec3::from([0; 3].map(|_| random.next_between(-size, size)));
    for _ in 0..500 {
        // A small triangle, about across its rays, which may cross.
        let directions = [(); 3].map(|()| (Vec3::Z + vector(0.1)).normalize());
        let positions = [Vec3::ZERO, Vec3::X * 0.1, Vec3::Y * 0.1].map(|corner| corner + vector(0.02));
        let mut leaf = CellLeaf::default();
        leaf.set(3, positions, directions);
        let shares = (vector(0.5) + 0.5) / (vector(0.5) + 0.5).element_sum().max(3.0);
        let (u, v) = (shares.x, shares.y);
        let mix = |of: [Vec3; 3]| of[0] + (of[1] - of[0]) * u + (of[2] - of[0]) * v;
        let distance = 0.3;
        let point = mix(positions) + mix(directions) * distance;
        let answer = leaf.answer(point);
        let found = [answer.weights[0][3], answer.weights[1][3]];
        let near = (found[0] - u).abs().max((found[1] - v).abs()) < 1e-2;
        assert!(near && answer.inside[3] > -1e-2, "{found:?}, not {u}, {v}");
        assert!(answer.inside[2] < -NEAR, "empty lanes hold nothing");
    }
}

#[test]
fn runs_lie_close_together() {
    // A square of 40 x 40 places in any order.
    let mut places: Vec<(Vec3, u32)> =
        (0..1600u32).map(|k| (Vec3::new((k * 7 % 40) as f32, (k / 40) as f32, 0.0), k)).collect();
    gather(&mut places);
    let mut found: Vec<u32> = places.iter().map(|(_, index)| *index).collect();
    let widest =
        |run: &[(Vec3, u32)]| run.iter().flat_map(|a| run.iter().map(|b| a.0.distance(b.0))).fold(0.0, f32::max);
    assert!(places.chunks(LANES).all(|run| widest(run) < 7.0));
    assert!(places.chunks(LANES * LANES).all(|run| widest(run) < 16.0));
    found.sort_unstable();
    assert!(found.into_iter().eq(0..1600), "none is lost");
}
