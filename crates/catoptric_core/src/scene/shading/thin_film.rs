//! Thin films whose two sides interfere (Belcour, Barla 2017, A practical extension to microfacet theory for the
//! modeling of varying iridescence; KHR_materials_iridescence).

use super::microfacets::grazing_share;
use crate::math::portable::PortableMath;
use glam::{Mat3, Vec3};
use std::f32::consts::{PI, TAU};

/// Cells of the table over the cosine.
const CELLS: usize = 24;

/// Orders of interference that are summed.
const ORDERS: u32 = 2;

/// A film at a point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct FilmAt {
    /// The share of the surface that it covers.
    pub share: f32,
    /// The film's index of refraction.
    pub ior: f32,
    /// The film's thickness in nanometres.
    pub thickness_nm: f32,
}

/// The reflectance of a surface under a film, by the cosine of the angle of incidence.
#[derive(Clone, Debug)]
pub struct FilmReflectance {
    share: f32,
    by_cosine: [Vec3; CELLS + 1],
}

impl FilmReflectance {
    /// The reflectance of a film over a surface that reflects so much at normal incidence.
    pub fn new(film: &FilmAt, base: Vec3) -> Self {
        let by_cosine = std::array::from_fn(|cell| film.reflectance(cell as f32 / CELLS as f32, base));
        Self { share: film.share, by_cosine }
    }

    /// The reflectance, if the surface without a film reflects so much there.
    pub fn over(&self, base: Vec3, cosine: f32) -> Vec3 {
        let at = cosine.clamp(0.0, 1.0) * CELLS as f32;
        let cell = (at as usize).min(CELLS - 1);
        let filmed = self.by_cosine[cell].lerp(self.by_cosine[cell + 1], at - cell as f32);
        base.lerp(filmed, self.share)
    }
}

impl FilmAt {
    /// The reflectance of what is covered, over a surface that reflects so much at normal incidence.
    pub fn reflectance(&self, cosine: f32, base: Vec3) -> Vec3 {
        // Without thickness there is no film.
        let there = (self.thickness_nm / 0.03).clamp(0.0, 1.0);
        let ior = 1.0 + (self.ior - 1.0) * there * there * (3.0 - 2.0 * there);
        let sine2 = (1.0 - cosine * cosine) / (ior * ior);
        if sine2 >= 1.0 {
            return Vec3::ONE;
        }
        let cosine_within = (1.0 - sine2).sqrt();
        let at_normal = |from: f32, to: f32| ((to - from) / (to + from)).powi(2);
        let schlick = |at_normal: f32, cosine: f32| at_normal + (1.0 - at_normal) * grazing_share(cosine);
        let outer = schlick(at_normal(1.0, ior), cosine);
        let passing = (1.0 - outer) * (1.0 - outer);
        let outer_turn = if ior < 1.0 { PI } else { 0.0 };
        let base_ior = base.clamp(Vec3::ZERO, Vec3::splat(0.9998)).map(|base| {
            let root = (base + 1e-4).sqrt();
            (1.0 + root) / (1.0 - root)
        });
        let inner = base_ior.map(|base_ior| schlick(at_normal(ior, base_ior), cosine_within));
        let turn = base_ior.map(|base_ior| PI - outer_turn + if base_ior < ior { PI } else { 0.0 });
        let path_nm = 2.0 * ior * self.thickness_nm * cosine_within;
        let both = (inner * outer).min(Vec3::splat(0.9999));
        let once = passing * inner / (Vec3::ONE - both);
        let mut sum = outer + once;
        let mut strength = once - passing;
        for order in 1..=ORDERS {
            strength *= both.map(f32::sqrt);
            sum += strength * 2.0 * sensitivity(order as f32 * path_nm, turn * order as f32);
        }
        sum.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// The linear colour that eyes see of a cosine of the phase: the transform of their sensitivities, fitted by Gaussians
/// (section 4 and the supplement of the paper).
fn sensitivity(path_nm: f32, turn: Vec3) -> Vec3 {
    let phase = TAU * path_nm * 1e-9;
    let gaussian = |value: f32, position: f32, variance: f32, turn: f32| {
        value * (TAU * variance).sqrt() * (position * phase + turn).cosine() * (-phase * phase * variance).exponential()
    };
    let xyz = Vec3::new(
        gaussian(5.4856e-13, 1.6810e6, 4.3278e9, turn.x) + gaussian(9.7470e-14, 2.2399e6, 4.5282e9, turn.x),
        gaussian(4.4201e-13, 1.7953e6, 9.3046e9, turn.y),
        gaussian(5.2481e-13, 2.2084e6, 6.6121e9, turn.z),
    ) / 1.0685e-7;
    // From XYZ to linear sRGB.
    Mat3::from_cols(
        Vec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
        Vec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
        Vec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
    ) * xyz
}
