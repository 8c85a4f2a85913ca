//! Texels as they are kept.

use block_compression::half::f16;
use catoptric_lookup::parts::{LayerTexel, TexelTaps};
use glam::Vec4;

#[test]
fn all_half_floats_are_what_they_are() {
    for bits in 0..=u16::MAX {
        let [low, high] = bits.to_le_bytes();
        let texel = LayerTexel::of_bytes([low, high, low, high, low, high, low, high]);
        let half = f16::from_bits(bits);
        if half.is_finite() {
            assert_eq!(texel.value(), Vec4::splat(half.to_f32()), "{bits:#x}");
            assert_eq!(LayerTexel::new(texel.value()).value(), texel.value());
        }
        assert!(texel.value().is_finite());
        assert_eq!(LayerTexel::of_bytes(texel.to_bytes()), texel);
    }
    let bytes = LayerTexel::new(Vec4::new(1.0, -2.0, 0.5, 0.0)).to_bytes();
    assert_eq!(bytes, [0x00, 0x3C, 0x00, 0xC0, 0x00, 0x38, 0x00, 0x00]);
    assert_eq!(LayerTexel::new(Vec4::NAN).value(), Vec4::ZERO);
    let largest = f16::MAX.to_f32();
    let held = LayerTexel::new(Vec4::new(1e9, -1e9, f32::INFINITY, 1e-9)).value();
    assert_eq!(held, Vec4::new(largest, -largest, largest, 0.0));
    let texels = [1.0, 2.0, 4.0, 8.0].map(|value| LayerTexel::new(Vec4::splat(value)));
    let taps = TexelTaps { texels: [0, 1, 2, 3], weights: [0.5, 0.25, 0.125, 0.125] };
    assert_eq!(taps.sum(&texels), Vec4::splat(2.5));
}
