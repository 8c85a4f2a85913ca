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
pub fn albedo(roughness: f32, n_v: f32) -> f32 {
    let (x, y) = (n_v.clamp(0.0, 1.0), roughness.clamp(LEAST_ROUGHNESS, 1.0));
    let deviation = y * (0.020_660_7 + 1.584_91 * y) / (0.037_942_4 + y * (1.322_27 + y));
    let mean = y * (-0.193_854 + y * (-1.148_85 + y * (1.793_2 - 0.959_43 * y * y))) / (0.046_391 + y);
    let least = y * (0.000_654_023 + (-0.020_781_8 + 0.119_681 * y) * y) / (1.262_64 + y * (-1.920_21 + y));
    let from_mean = (x - mean) / deviation;
    ((-0.5 * from_mean * from_mean).exponential() / (deviation * TAU.sqrt()) + least).clamp(0.0, 1.0)
}

/// How a sheen distributes light over directions: a clamped cosine that a matrix has transformed.
#[derive(Clone, Copy, Debug)]
pub struct SheenLobe {
    /// Towards the viewer along the surface, to its side, along the normal.
    axes: [Vec3; 3],
    /// The inverse of the matrix is [[a, 0, b], [0, a, 0], [0, 0, 1]].
    a: f32,
    b: f32,
    albedo: f32,
}

impl SheenLobe {
    /// The lobe of a perceptual roughness about a normal on the viewer's side, both directions of unit length.
    pub fn new(roughness: f32, normal: Vec3, towards_viewer: Vec3) -> Self {
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
    pub fn of(&self, towards_light: Vec3) -> f32 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(towards_light));
        if z <= 0.0 {
            return 0.0;
        }
        let before = Vec3::new(self.a * x + self.b * z, self.a * y, z);
        let stretch = self.a / before.length_squared();
        self.albedo * FRAC_1_PI * z * stretch * stretch
    }

    /// The light that goes to the viewer, of radiance by direction and the angle across the part of the lobe about it.
    pub fn gather(&self, radiance: impl Fn(Vec3, f32) -> Vec3) -> Vec3 {
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
