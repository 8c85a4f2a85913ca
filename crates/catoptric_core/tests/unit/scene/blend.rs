//! Weights of reflections.

use catoptric_core::scene::{Attenuation, Blend};

#[test]
fn weights_at_their_ends_and_between() {
    let attenuation = Attenuation { distance: 2.0, specularity: [0.2, 0.9] };
    for (distance, expected) in [(0.0, 0.9), (1.0, 0.9 - 0.7 * 0.25), (2.0, 0.2), (3.0, 0.2), (f32::INFINITY, 0.2)] {
        assert!((attenuation.weight(distance) - expected).abs() < 1e-6, "{distance}");
    }
    let ramp = Blend { fresnel: Some([0.1, 0.7]), ..Blend::default() };
    for (cosine, expected) in [(0.0, 0.1), (0.5, 0.1 + 0.6 * 0.25), (1.0, 0.7), (1.000_001, 0.7)] {
        assert!((ramp.weight_at(cosine) - expected).abs() < 1e-6, "{cosine}");
    }
    assert_eq!(Blend::default().weight_at(0.3), 1.0);
}
