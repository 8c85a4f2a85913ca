//! Colours of heat maps.

use catoptric_engine::metrics::{heat_color, heat_map_rgb8};

#[test]
fn the_scale_grows_lighter_from_end_to_end() {
    let lightness = |error: f32| {
        let [r, g, b] = heat_color(error).map(f32::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    for step in 0..100 {
        let (a, b) = (step as f32 / 100.0, (step + 1) as f32 / 100.0);
        assert!(lightness(b) >= lightness(a), "{a}");
    }
    assert_eq!(heat_color(f32::NAN), heat_color(0.0));
    assert_eq!(heat_color(9.0), heat_color(1.0));
    assert_ne!(heat_color(0.0), heat_color(1.0));
    assert_eq!(heat_map_rgb8(&[0.0, 1.0]).len(), 6);
}
