//! Compressed depths.

use catoptric_core::math::random::Stream;
use catoptric_lookup::parts::depth_blocks::{at, byte_count, compress};

fn restored(side: u32, view: &[i16]) -> Vec<i16> {
    let mut bytes = Vec::new();
    compress(side, view, &mut bytes);
    assert_eq!(bytes.len(), byte_count(side));
    (0..side * side).map(|pixel| at(side, &bytes, pixel % side, pixel / side)).collect()
}

#[test]
fn two_surfaces_keep_their_parallaxes() {
    for side in [1, 3, 4, 9, 16] {
        let edge = |pixel: u32| if (pixel % side) * 2 > pixel / side { -20_000 } else { 31_000 };
        let view: Vec<i16> = (0..side * side).map(edge).collect();
        assert_eq!(restored(side, &view), view, "{side}");
    }
}

/// The error is at most a sixth of a block's range, and the rounding.
#[test]
fn smooth_surfaces_are_off_by_a_sixth_of_a_block_at_most() {
    let mut random = Stream::new(9);
    for _ in 0..200 {
        let [base, across, down] = [0; 3].map(|_| random.next_between(-2000.0, 2000.0));
        let plane = |pixel: u32| (base + across * (pixel % 8) as f32 + down * (pixel / 8) as f32) as i16;
        let view: Vec<i16> = (0..64).map(plane).collect();
        let range = 3.0 * (across.abs() + down.abs());
        for (found, wanted) in restored(8, &view).iter().zip(&view) {
            let off = f32::from(*found) - f32::from(*wanted);
            // Fits are nearer in the mean, and may be further at one pixel.
            assert!(off.abs() <= range / 5.0 + 2.0, "{off} of {range}");
        }
    }
}

#[test]
fn extremes_and_missing_blocks_are_numbers() {
    let view: Vec<i16> = (0..16).map(|pixel| if pixel % 2 == 0 { i16::MIN } else { i16::MAX }).collect();
    assert_eq!(restored(4, &view), view);
    assert_eq!(at(8, &[], 3, 3), 0);
}
