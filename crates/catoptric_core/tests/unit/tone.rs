//! Exposure and tone curves.

use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::tone::{Display, ToneCurve, automatic_exposure};
use glam::Vec3;

#[test]
fn curves_keep_grey_grey_and_rise() {
    for curve in [ToneCurve::None, ToneCurve::Neutral, ToneCurve::Agx, ToneCurve::Aces] {
        let mut last = -1.0;
        for step in 0..400 {
            let value = 1e-4 * 1.04f32.powi(step);
            let shown = curve.of(Vec3::splat(value));
            assert!(shown.max_element() - shown.min_element() < 2e-3 * shown.x.max(1.0), "{curve:?} {value}: {shown}");
            assert!(shown.x >= last - 1e-4, "{curve:?} {value}");
            assert!(curve == ToneCurve::None || shown.x <= 1.0 + 1e-4, "{curve:?} {value}: {shown}");
            last = shown.x;
        }
    }
}

/// A pixel half before a light and half before nothing is half as bright as white, however bright the light is.
#[test]
fn samples_are_limited_before_they_are_averaged() {
    let mut picture = Framebuffer::of_pixels(2, 1, vec![[500.0, 500.0, 500.0, 1.0]; 2]);
    picture.edges.add(1, &[Vec3::ZERO, Vec3::splat(1000.0)]);
    picture.edges.add(0, &[Vec3::splat(500.0), Vec3::splat(501.0)]);
    for (curve, white) in [(ToneCurve::None, 1.0), (ToneCurve::Aces, 1.0), (ToneCurve::Agx, 0.99)] {
        let shown = Display { exposure_stops: 1.0, curve }.of(&picture);
        assert!((shown.pixels[1][0] - 0.5 * white).abs() < 0.01, "{curve:?}: {:?}", shown.pixels);
        assert!(shown.pixels[0][0] >= white, "{curve:?}: {:?}", shown.pixels);
    }
}

/// The published code, by hand: 0.5 grey less 0.04, and white of 2 compressed towards 1.
#[test]
fn neutral_has_its_published_values() {
    let grey = ToneCurve::Neutral.of(Vec3::splat(0.5));
    assert!((grey.x - 0.46).abs() < 1e-6);
    let white = ToneCurve::Neutral.of(Vec3::splat(2.0));
    assert!((white.x - (1.0 - 0.24 * 0.24 / (1.96 + 0.24 - 0.76))).abs() < 1e-6);
}

#[test]
fn exposure_brings_the_mean_to_middle_grey() {
    let automatic = |values: &[(f32, usize)]| {
        let (picture, is_surface) = surfaces_before(values, 0.7);
        automatic_exposure(&picture, &is_surface)
    };
    assert!((automatic(&[(0.045, 10)]) - 2.0).abs() < 1e-4);
    assert_eq!(automatic(&[(1e9, 10)]), -8.0);
    assert_eq!(automatic(&[]), 0.0);
}

/// A picture of surfaces, by values and how many pixels have each, before a background of 50 pixels; and which pixels
/// show surfaces.
fn surfaces_before(values: &[(f32, usize)], background: f32) -> (Framebuffer, Vec<bool>) {
    let surfaces = values.iter().flat_map(|(value, count)| std::iter::repeat_n(*value, *count));
    let all: Vec<(f32, bool)> =
        surfaces.map(|value| (value, true)).chain(std::iter::repeat_n((background, false), 50)).collect();
    let pixels: Vec<[f32; 4]> = all.iter().map(|(value, _)| [*value, *value, *value, 1.0]).collect();
    let picture = Framebuffer::of_pixels(pixels.len() as u32, 1, pixels);
    (picture, all.into_iter().map(|(_, is_surface)| is_surface).collect())
}

/// Values of surfaces and how many pixels have each; the value of the background; the stops that fit.
type Fit = (&'static [(f32, usize)], f32, f32);

/// Bright pixels become white, not middle grey, and dark ones no brighter than white.
#[test]
fn displays_change_as_little_as_a_screen_needs() {
    let fitting = |values: &[(f32, usize)], background: f32| {
        let (picture, is_surface) = surfaces_before(values, background);
        Display::fitting(&picture, &is_surface)
    };
    assert_eq!(fitting(&[(0.3, 100)], 9.0), Display::default());
    assert_eq!(fitting(&[(0.18 / 16.0, 100)], 4.0), Display::default());
    assert_eq!(fitting(&[], 0.5), Display::default());
    let fits: [Fit; 7] = [
        (&[(4.0, 100)], 0.0, -2.0),
        (&[(4.0, 11), (0.5, 89)], 9.0, -2.0),
        (&[(400.0, 4), (4.0, 11), (0.5, 85)], 0.0, -2.0),
        (&[(0.18 / 16.0, 100)], 0.0, 4.0),
        (&[(0.18 / 16.0, 100)], 0.25, 2.0),
        (&[(1e-9, 94), (0.25, 6)], 0.0, 2.0),
        (&[(1e9, 100)], 0.0, -16.0),
    ];
    for (values, background, stops) in fits {
        let display = fitting(values, background);
        assert_eq!(display.curve, ToneCurve::Neutral);
        assert!((display.exposure_stops - stops).abs() < 1e-4, "{values:?}: {display:?}");
    }
}
