//! Sheen: light that fibres of cloth scatter, most of it at grazing angles (Estevez, Kulla 2017, Production friendly
//! microfacet sheen; KHR_materials_sheen).

use crate::math::portable::PortableMath;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

/// Cells of the table a side, less one.
const CELLS: usize = 16;

/// The least perceptual roughness: below, almost all light leaves along the surface.
const LEAST_ROUGHNESS: f32 = 0.07;

/// The share of light from all around that a white sheen sends to a viewer: rows by perceptual roughness, columns by
/// the cosine towards the viewer, both from 0 to 1.
static ALBEDO: LazyLock<[[f32; CELLS + 1]; CELLS + 1]> = LazyLock::new(|| {
    let at = |cell: usize| cell as f32 / CELLS as f32;
    std::array::from_fn(|row| std::array::from_fn(|column| integral(at(row), at(column).max(0.02))))
});

/// The sheen's distribution times its visibility, by the perceptual roughness and the cosines of half vector, light and
/// viewer to the normal.
pub(super) fn lobe(roughness: f32, n_h: f32, n_l: f32, n_v: f32) -> f32 {
    let alpha = roughness.max(LEAST_ROUGHNESS).powi(2);
    let sine2 = (1.0 - n_h * n_h).max(1e-6);
    let distribution = (2.0 + 1.0 / alpha) * sine2.power(0.5 / alpha) / TAU;
    let visibility = 1.0 / ((1.0 + shadowed(n_l, alpha) + shadowed(n_v, alpha)) * (4.0 * n_l * n_v).max(1e-4));
    distribution * visibility
}

/// Lambda of the height-correlated shadowing term: the fit of section 3 of the paper.
fn shadowed(cosine: f32, alpha: f32) -> f32 {
    let curve = |x: f32| {
        let share = (1.0 - alpha) * (1.0 - alpha);
        let of = |rough: f32, smooth: f32| rough + (smooth - rough) * share;
        let (a, b, c, d, e) = (
            of(21.5473, 25.3245),
            of(3.82987, 3.32435),
            of(0.19823, 0.16801),
            of(-1.97760, -1.27393),
            of(-4.32054, -4.85967),
        );
        a / (1.0 + b * x.power(c)) + d * x + e
    };
    let cosine = cosine.clamp(1e-3, 1.0);
    let value = if cosine < 0.5 { curve(cosine) } else { 2.0 * curve(0.5) - curve(1.0 - cosine) };
    value.exponential()
}

/// The directional albedo of a white sheen by the midpoint rule over the hemisphere of light.
fn integral(roughness: f32, n_v: f32) -> f32 {
    const RINGS: usize = 48;
    const SPOKES: usize = 48;
    let viewer = Vec3::new((1.0 - n_v * n_v).sqrt(), 0.0, n_v);
    let mut sum = 0.0;
    for ring in 0..RINGS {
        let n_l = (ring as f32 + 0.5) / RINGS as f32;
        let sine = (1.0 - n_l * n_l).sqrt();
        for spoke in 0..SPOKES {
            let angle = PI * (spoke as f32 + 0.5) / SPOKES as f32;
            let light = Vec3::new(sine * angle.cosine(), sine * angle.sine(), n_l);
            let half = (light + viewer).normalize();
            sum += lobe(roughness, half.z, n_l, n_v) * n_l;
        }
    }
    (sum * TAU / (RINGS * SPOKES) as f32).clamp(0.0, 1.0)
}

/// The share of light from all around that a white sheen of a perceptual roughness sends to a viewer at this cosine.
pub(super) fn albedo(roughness: f32, n_v: f32) -> f32 {
    let at = |value: f32| {
        let scaled = (value * CELLS as f32).clamp(0.0, CELLS as f32 - 1e-3);
        (scaled as usize, scaled - scaled.floor())
    };
    let ((row, down), (column, right)) = (at(roughness), at(n_v));
    let [upper, lower] =
        [&ALBEDO[row], &ALBEDO[row + 1]].map(|row| row[column] + (row[column + 1] - row[column]) * right);
    upper + (lower - upper) * down
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light is not made, and grazing views show more than steep ones.
    #[test]
    fn sheen_is_a_share_of_light_and_rises_towards_grazing_angles() {
        for roughness in [0.1, 0.3, 0.5, 0.8, 1.0] {
            let shares: Vec<f32> = (1..=10).map(|step| albedo(roughness, step as f32 / 10.0)).collect();
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{roughness}: {shares:?}");
            assert!(shares[0] > shares[9], "{roughness}: {shares:?}");
        }
        // Table 1 of the Khronos sample renderer's look-up texture: about a tenth, seen along the normal, at 0.5.
        assert!((0.02..0.3).contains(&albedo(0.5, 1.0)));
    }

    /// Helmholtz: light and viewer may be exchanged.
    #[test]
    fn the_lobe_is_reciprocal() {
        for (n_l, n_v) in [(0.2, 0.9), (0.5, 0.6), (0.05, 1.0)] {
            let [one, other] = [lobe(0.4, 0.7, n_l, n_v), lobe(0.4, 0.7, n_v, n_l)];
            assert!((one - other).abs() <= 1e-5 * one.abs());
        }
    }
}
