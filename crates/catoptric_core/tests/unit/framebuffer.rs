//! Encoding of pictures.

use catoptric_core::framebuffer::{Framebuffer, linear_from_srgb, srgb_from_linear};

/// The least value of each code but the first: codes rise with values, whose bits rise with them.
fn least_of_codes(code: impl Fn(f32) -> u8) -> Vec<f32> {
    let least = |wanted: u8| {
        let (mut below, mut above) = (0, 1f32.to_bits());
        while above - below > 1 {
            let middle = below + (above - below) / 2;
            if code(f32::from_bits(middle)) >= wanted { above = middle } else { below = middle }
        }
        f32::from_bits(above)
    };
    (1..=255).map(least).collect()
}

#[test]
fn srgb_round_trip() {
    for step in 0..=255u32 {
        let value = step as f32 / 255.0;
        assert!((srgb_from_linear(linear_from_srgb(value)) - value).abs() < 1e-5, "{value}");
    }
    assert_eq!(srgb_from_linear(f32::NAN), 0.0);
    let code = |linear: f32| (srgb_from_linear(linear) * 255.0 + 0.5) as u8;
    let around = |value: f32| [value.next_down(), value, value.next_up()];
    let even = (0..1 << 20).map(|step| step as f32 / (1 << 20) as f32);
    let odd =
        least_of_codes(code).into_iter().flat_map(around).chain([-1.0, -0.0, 1e-30, 2.0, f32::INFINITY, f32::NAN]);
    let values: Vec<f32> = even.chain(odd).collect();
    let pixels = values.iter().map(|value| [*value, *value, *value, 1.0]).collect();
    let encoded = Framebuffer::of_pixels(values.len() as u32, 1, pixels).to_srgb8();
    for (value, found) in values.iter().zip(encoded.as_chunks::<3>().0) {
        assert_eq!(*found, [code(*value); 3], "{value}");
    }
    assert_eq!(srgb_from_linear(7.0), srgb_from_linear(1.0));
}
