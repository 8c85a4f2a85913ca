//! Textures.

use catoptric_core::scene::{Sampler, Texture, UvFootprint, Wrap};
use glam::Vec2;

fn checker(sampler: Sampler) -> Texture {
    let texels: Vec<[u8; 4]> =
        (0..64).map(|i| if (i % 8 + i / 8) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }).collect();
    Texture::from_srgb8("checker", 8, 8, &texels, sampler)
}

#[test]
fn nearest_and_wraps() {
    let nearest = Sampler { magnify_linear: false, ..Sampler::default() };
    let still = UvFootprint::default();
    let texture = checker(nearest);
    assert_eq!(texture.sample(Vec2::new(0.05, 0.05), &still).x, 1.0);
    assert_eq!(texture.sample(Vec2::new(0.15, 0.05), &still).x, 0.0);
    assert_eq!(texture.sample(Vec2::new(-0.05, 0.05), &still).x, 0.0); // repeat: the eighth texel
    let mirrored = checker(Sampler { wrap_u: Wrap::MirroredRepeat, ..nearest });
    assert_eq!(mirrored.sample(Vec2::new(-0.05, 0.05), &still).x, 1.0);
    let clamped = checker(Sampler { wrap_u: Wrap::ClampToEdge, ..nearest });
    assert_eq!(clamped.sample(Vec2::new(7.3, 0.05), &still).x, 0.0);
    assert!(clamped.sample(Vec2::new(f32::NAN, f32::INFINITY), &still).is_finite());
}

#[test]
fn minification_averages() {
    let texture = checker(Sampler::default());
    let wide = UvFootprint { dx: Vec2::new(1.0, 0.0), dy: Vec2::new(0.0, 1.0), samples: 1 };
    let value = texture.sample(Vec2::new(0.3, 0.7), &wide);
    assert!((value.x - 0.5).abs() < 1e-3, "{value}");
}

#[test]
fn anisotropic_footprints_blur_along_their_axis_only() {
    // Columns of alternating pairs: blurring down the columns must not blur across them.
    let texels: Vec<[u8; 4]> = (0..64 * 64).map(|i| if (i % 64) / 8 % 2 == 0 { [255; 4] } else { [0; 4] }).collect();
    let texture = Texture::from_srgb8("columns", 64, 64, &texels, Sampler::default());
    let tall = UvFootprint { dx: Vec2::new(1.0 / 64.0, 0.0), dy: Vec2::new(0.0, 8.0 / 64.0), samples: 1 };
    assert!(texture.sample(Vec2::new(4.0 / 64.0, 0.5), &tall).x > 0.99);
    assert!(texture.sample(Vec2::new(12.0 / 64.0, 0.5), &tall).x < 0.01);
}
