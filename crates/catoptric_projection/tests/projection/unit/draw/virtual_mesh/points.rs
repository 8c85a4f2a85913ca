//! The order in which points of virtual meshes are projected.

use catoptric_projection::parts::spread_order;

#[test]
fn orders_hold_every_number_and_begin_everywhere() {
    for count in [0, 1, 2, 3, 31, 32, 33, 500, 512] {
        let order = spread_order(count);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..count as u16), "{count}");
    }
    let mut begun = spread_order(512)[..32].to_vec();
    begun.sort_unstable();
    assert!(begun.windows(2).all(|pair| pair[1] - pair[0] == 16));
}
