//! Sheen.

use catoptric_core::scene::{SheenLobe, sheen_albedo as albedo};
use glam::Vec3;
use std::f32::consts::TAU;

fn viewer(n_v: f32) -> Vec3 {
    Vec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v)
}

/// Values of the paper's table (Zeltner, Burley, Chiang 2022, supplementary code), to the error of its fits.
#[test]
fn sheen_is_a_share_of_light_and_rises_towards_grazing_angles() {
    for roughness in [0.0, 0.1, 0.3, 0.5, 0.8, 1.0] {
        let shares: Vec<f32> = (1..=10).map(|step| albedo(roughness, step as f32 / 10.0)).collect();
        assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{roughness}: {shares:?}");
        assert!(shares[0] >= shares[9], "{roughness}: {shares:?}");
    }
    for (roughness, n_v, of_table) in
        [(3, 9, 0.0001), (8, 9, 0.0732), (15, 9, 0.3109), (15, 15, 0.15), (22, 25, 0.1705), (31, 31, 0.3419)]
    {
        let [roughness, n_v] = [roughness, n_v].map(|index| index as f32 / 31.0);
        assert!((albedo(roughness, n_v) - of_table).abs() < 0.01, "{roughness}, {n_v}");
    }
}

/// The lobe's integral over the hemisphere is its albedo, by the midpoint rule, and what is gathered of a light
/// that is the same from everywhere.
#[test]
fn the_lobe_sends_what_its_albedo_says() {
    const RINGS: usize = 400;
    for (roughness, n_v) in [(0.3, 0.4), (0.5, 0.1), (0.5, 0.7), (0.8, 0.9), (1.0, 1.0)] {
        let lobe = SheenLobe::new(roughness, Vec3::Z, viewer(n_v));
        let mut sum = 0.0;
        for ring in 0..RINGS {
            let z = (ring as f32 + 0.5) / RINGS as f32;
            let sine = (1.0 - z * z).sqrt();
            for spoke in 0..RINGS {
                let (y, x) = (TAU * spoke as f32 / RINGS as f32).sin_cos();
                sum += lobe.of(Vec3::new(sine * x, sine * y, z)) * TAU / (RINGS * RINGS) as f32;
            }
        }
        let albedo = albedo(roughness, n_v);
        assert!((sum - albedo).abs() < 0.01 * albedo, "{roughness}, {n_v}: {sum}, {albedo}");
        let gathered = lobe.gather(|_, _| Vec3::ONE).x;
        assert!((gathered - albedo).abs() < 1e-5, "{gathered}, {albedo}");
    }
}
