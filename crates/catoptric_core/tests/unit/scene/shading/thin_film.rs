//! Thin films.

use catoptric_core::scene::FilmAt;
use glam::Vec3;

/// Two interfaces and what goes to and fro between them, for one wavelength at normal incidence.
fn airy(ior: f64, base_ior: f64, thickness_nm: f64, wavelength_nm: f64) -> f64 {
    let (outer, inner) = ((1.0 - ior) / (1.0 + ior), (ior - base_ior) / (ior + base_ior));
    let phase = 4.0 * std::f64::consts::PI * ior * thickness_nm / wavelength_nm;
    let both = outer * inner;
    (outer * outer + inner * inner + 2.0 * both * phase.cos()) / (1.0 + both * both + 2.0 * both * phase.cos())
}

#[test]
fn thin_films_reflect_what_airys_sum_says() {
    // Films thinner than a wavelength: the sum hardly changes over a primary's band.
    for (ior, base_ior) in [(1.3, 1.5), (1.33, 2.0), (1.8, 1.5)] {
        for thickness_nm in [60.0, 100.0, 140.0] {
            let base = Vec3::splat(((base_ior - 1.0f32) / (base_ior + 1.0)).powi(2));
            let found = FilmAt { share: 1.0, ior, thickness_nm }.reflectance(1.0, base);
            let green = airy(ior.into(), base_ior.into(), thickness_nm.into(), 545.0) as f32;
            assert!((found.y - green).abs() < 0.012, "{ior} {base_ior} {thickness_nm}: {found}, {green}");
        }
    }
}

#[test]
fn no_film_is_the_surface_alone_and_all_is_finite() {
    for base in [0.0, 0.04, 0.5, 1.0] {
        let film = FilmAt { share: 1.0, ior: 1.6, thickness_nm: 0.0 };
        assert!((film.reflectance(1.0, Vec3::splat(base)).x - base).abs() < 3e-3, "{base}");
        for ior in [1.0, 1.3, 5.0] {
            for thickness_nm in [0.0, 400.0, 1e5] {
                for cosine in [0.0, 0.3, 1.0] {
                    let found = FilmAt { share: 1.0, ior, thickness_nm }.reflectance(cosine, Vec3::splat(base));
                    assert!(found.is_finite() && found.min_element() >= 0.0 && found.max_element() <= 1.0);
                }
            }
        }
    }
}
