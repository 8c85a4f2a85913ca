//! FLIP against numbers of its authors' program.

use catoptric_core::framebuffer::{Framebuffer, linear_from_srgb};
use catoptric_engine::metrics::{DEFAULT_PIXELS_PER_DEGREE, flip_map};

fn noise(x: u32, y: u32, channel: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ channel.wrapping_mul(0xC2B2_AE3D);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2C1B_3C6D);
    h ^= h >> 12;
    h = h.wrapping_mul(0x297A_2D39);
    h ^ (h >> 15)
}

/// A pixel of the reference and of the picture under test, 8-bit sRGB.
fn pixel(kind: &str, x: u32, y: u32, width: u32, height: u32) -> [[u8; 3]; 2] {
    let gradient = [(x * 255 / width) as u8, (y * 255 / height) as u8];
    match kind {
        "moved checkerboard" => {
            [x, x + 2].map(|x| if (x / 8 + y / 8).is_multiple_of(2) { [220, 60, 40] } else { [30, 90, 200] })
        }
        "noise" => {
            let clean = [gradient[0], gradient[1], ((x + y) * 255 / (width + height)) as u8];
            let noisy = |c: usize| (clean[c] as i32 + (noise(x, y, c as u32) % 61) as i32 - 30).clamp(0, 255) as u8;
            [clean, std::array::from_fn(noisy)]
        }
        "turned colours" => [[gradient[0], 128, gradient[1]], [128, gradient[1], gradient[0]]],
        "black and white" => [[0; 3], [255; 3]],
        "green and blue" => [[0, 255, 0], [0, 0, 255]],
        _ => unreachable!(),
    }
}

fn pair(kind: &str, width: u32, height: u32) -> [Framebuffer; 2] {
    [0, 1].map(|which| {
        let mut picture = Framebuffer::new(width, height);
        for y in 0..height {
            for x in 0..width {
                let [r, g, b] = pixel(kind, x, y, width, height)[which].map(|c| linear_from_srgb(f32::from(c) / 255.0));
                picture.pixels[(y * width + x) as usize] = [r, g, b, 1.0];
            }
        }
        picture
    })
}

/// Means and single pixels (first, middle, last) against the authors' own C++ program, as packaged in the crate
/// nv-flip 0.1.2, on pictures that this test draws again.
#[test]
fn agrees_with_the_authors_program() {
    for (kind, width, height, mean, pixels) in [
        ("moved checkerboard", 64, 48, 0.265_633_3, [0.154_528_2, 0.014_453, 0.943_781]),
        ("noise", 80, 50, 0.136_445, [0.045_747_9, 0.264_271_1, 0.293_190_7]),
        ("turned colours", 33, 47, 0.856_472_3, [0.953_715_3, 0.172_405_9, 0.973_252_8]),
        ("black and white", 16, 9, 0.967_385_5, [0.967_385_5; 3]),
        ("green and blue", 16, 9, 1.0, [1.0; 3]),
        ("noise", 5, 1, 0.182_556_3, [0.106_767_8, 0.232_185_3, 0.181_209_3]),
        ("noise", 1, 1, 0.057_724_4, [0.057_724_4; 3]),
    ] {
        let [reference, test] = pair(kind, width, height);
        let map = flip_map(&test, &reference, DEFAULT_PIXELS_PER_DEGREE).unwrap();
        let own = map.iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64;
        assert!((own - mean).abs() <= 1e-5 * mean, "{kind} {width}x{height}: mean {own}, theirs {mean}");
        for (index, theirs) in [0, map.len() / 2, map.len() - 1].into_iter().zip(pixels) {
            assert!((map[index] - theirs).abs() < 2e-5, "{kind}: pixel {index}: {}, theirs {theirs}", map[index]);
        }
    }
}

#[test]
fn is_symmetric_and_bounded() {
    let [a, b] = pair("noise", 31, 17);
    let map = flip_map(&a, &b, DEFAULT_PIXELS_PER_DEGREE).unwrap();
    assert_eq!(map, flip_map(&b, &a, DEFAULT_PIXELS_PER_DEGREE).unwrap());
    assert!(map.iter().all(|value| (0.0..=1.0).contains(value)));
}

#[test]
fn odd_viewing_conditions_and_values_give_finite_maps() {
    let [a, mut b] = pair("noise", 9, 3);
    b.pixels[4] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0];
    for pixels_per_degree in [0.0, 1.0, 5000.0, f32::NAN, f32::INFINITY] {
        let map = flip_map(&a, &b, pixels_per_degree).unwrap();
        assert!(map.iter().all(|value| (0.0..=1.0).contains(value)), "{pixels_per_degree}");
    }
}
