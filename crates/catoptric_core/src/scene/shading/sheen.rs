//! Sheen: light that fibres of cloth scatter, most of it at grazing angles (KHR_materials_sheen). The specification
//! leaves the fibres' distribution open; this is the one that was fitted to simulated light within layers of fibres
//! (Zeltner, Burley, Chiang 2022, Practical multiple-scattering sheen using linearly transformed cosines), as in
//! OpenPBR 1.1 and in Cycles.

use crate::math::portable::PortableMath;
use crate::math::random;
use crate::scene::microfacets::disc_point;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::LazyLock;

/// The least perceptual roughness that the fits are made for, in effect: below, almost nothing is seen.
const LEAST_ROUGHNESS: f32 = 0.02;

/// Directions that stand for the lobe where the light of all directions is gathered.
const DIRECTIONS: u32 = 16;

/// The part of each of them is taken wider by this factor, so that no light falls between them.
const OVERLAP: f32 = 1.8;

/// The share of light from all around that a white sheen of a perceptual roughness sends to a viewer at this cosine.
/// The fit of the paper's table by a Gaussian over the cosine (Hill, in MaterialX 1.39).
pub(super) fn albedo(roughness: f32, n_v: f32) -> f32 {
    let (x, y) = (n_v.clamp(0.0, 1.0), roughness.clamp(LEAST_ROUGHNESS, 1.0));
    let deviation = y * (0.020_660_7 + 1.584_91 * y) / (0.037_942_4 + y * (1.322_27 + y));
    let mean = y * (-0.193_854 + y * (-1.148_85 + y * (1.793_2 - 0.959_43 * y * y))) / (0.046_391 + y);
    let least = y * (0.000_654_023 + (-0.020_781_8 + 0.119_681 * y) * y) / (1.262_64 + y * (-1.920_21 + y));
    let from_mean = (x - mean) / deviation;
    ((-0.5 * from_mean * from_mean).exponential() / (deviation * TAU.sqrt()) + least).clamp(0.0, 1.0)
}

/// How a sheen distributes light over directions: a clamped cosine that a matrix has transformed.
pub(super) struct SheenLobe {
    /// Towards the viewer along the surface, to its side, along the normal.
    axes: [Vec3; 3],
    /// The inverse of the matrix is [[a, 0, b], [0, a, 0], [0, 0, 1]].
    a: f32,
    b: f32,
    albedo: f32,
}

impl SheenLobe {
    /// Of a perceptual roughness about a normal on the viewer's side, both directions of unit length.
    pub(super) fn new(roughness: f32, normal: Vec3, towards_viewer: Vec3) -> Self {
        let (x, y) = (normal.dot(towards_viewer).clamp(0.0, 1.0), roughness.clamp(LEAST_ROUGHNESS, 1.0));
        let along = towards_viewer.reject_from_normalized(normal).try_normalize();
        let along = along.unwrap_or_else(|| normal.any_orthonormal_vector());
        // Fits of the paper's table by ratios of polynomials (Hill, in MaterialX 1.39).
        let a = (2.581_26 * x + 0.813_703 * y) * y / (1.0 + 0.310_327 * x * x + 2.609_94 * x * y);
        let below = 0.000_025_405_3 + 1.712_28 * x - 1.715_06 * x * y + 1.341_74 * y * y;
        let b = (1.0 - x).sqrt() * (y - 1.0) * y.powi(3) / below;
        Self { axes: [along, normal.cross(along), normal], a, b, albedo: albedo(roughness, x) }
    }

    /// The share of light from this direction that goes to the viewer, a solid angle, with the cosine of its
    /// incidence.
    pub(super) fn of(&self, towards_light: Vec3) -> f32 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(towards_light));
        if z <= 0.0 {
            return 0.0;
        }
        let before = Vec3::new(self.a * x + self.b * z, self.a * y, z);
        let stretch = self.a / before.length_squared();
        self.albedo * FRAC_1_PI * z * stretch * stretch
    }

    /// The light that goes to the viewer, of radiance by direction and the angle across the part of the lobe about it.
    pub(super) fn gather(&self, radiance: impl Fn(Vec3, f32) -> Vec3) -> Vec3 {
        static COSINES: LazyLock<[Vec3; DIRECTIONS as usize]> = LazyLock::new(|| {
            std::array::from_fn(|index| {
                let disc = disc_point(random::hammersley(index as u32, DIRECTIONS));
                disc.extend((1.0 - disc.length_squared()).max(0.0).sqrt())
            })
        });
        let share = 1.0 / DIRECTIONS as f32;
        let mut sum = Vec3::ZERO;
        for before in &*COSINES {
            let [x, y, z] = [before.x - before.z * self.b, before.y, before.z * self.a];
            let Some(towards) = (self.axes[0] * x + self.axes[1] * y + self.axes[2] * z).try_normalize() else {
                continue;
            };
            let solid_angle = share * self.albedo / self.of(towards).max(f32::MIN_POSITIVE);
            sum += radiance(towards, OVERLAP * solid_angle.sqrt());
        }
        sum * (share * self.albedo)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
