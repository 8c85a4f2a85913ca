//! Numbers in lanes.

use catoptric_core::math::lanes::bits_of;

#[test]
fn bits_are_those_of_lanes() {
    for bits in 0..=u8::MAX {
        assert_eq!(bits_of([0, 1, 2, 3, 4, 5, 6, 7].map(|lane| bits >> lane & 1 != 0)), bits);
    }
}
