//! How light is reflected and refracted at a surface: directions, Fresnel factors, attenuation.

pub mod all_roots;
pub mod bundle;
mod differential;
mod interface;
pub mod path_derivatives;
pub mod specular_solver;

pub use differential::{reflected_change, refracted_change};
pub(crate) use interface::mirror_tint;
pub use interface::{Deferred, Facing, Interface};

use glam::Vec3;

/// The mirror direction of `incoming` about `normal` (both unit length; the sign of the normal does not matter).
pub fn reflect(incoming: Vec3, normal: Vec3) -> Vec3 {
    incoming - normal * (2.0 * incoming.dot(normal))
}

/// The refracted direction by Snell's law, or none on total internal reflection.
///
/// `incoming` and `normal` are unit vectors, the normal on the side the ray comes from (`incoming . normal < 0`);
/// `eta` is the index of refraction of the side the ray comes from over that of the side it goes to.
pub fn refract(incoming: Vec3, normal: Vec3, eta: f32) -> Option<Vec3> {
    let cos_in = -incoming.dot(normal);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in).max(0.0);
    if sin2_out >= 1.0 {
        return None;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    Some((incoming * eta + normal * (eta * cos_in - cos_out)).normalize())
}

/// The share of unpolarised light that a smooth dielectric interface reflects (Fresnel's equations, exact).
///
/// `cos_in` is the cosine of the angle of incidence (0 to 1), `eta` as in [`refract`]. Total internal reflection gives 1.
pub fn fresnel_dielectric(cos_in: f32, eta: f32) -> f32 {
    let cos_in = cos_in.clamp(0.0, 1.0);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return 1.0;
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    let parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    let perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    if !(parallel.is_finite() && perpendicular.is_finite()) {
        return 1.0; // grazing incidence between equal media: the limit of the formula
    }
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).clamp(0.0, 1.0)
}

/// Schlick's approximation of a conductor's reflectance from its colour at normal incidence (Schlick 1994).
pub fn fresnel_schlick(normal_reflectance: Vec3, cos_in: f32) -> Vec3 {
    let m = (1.0 - cos_in).clamp(0.0, 1.0);
    let m2 = m * m;
    normal_reflectance + (Vec3::ONE - normal_reflectance) * (m2 * m2 * m)
}

/// Beer-Lambert: what is left of light after `distance` in a medium of this absorption a unit of length.
pub fn transmittance(absorption: Vec3, distance: f32) -> Vec3 {
    if absorption == Vec3::ZERO {
        return Vec3::ONE;
    }
    let exponent = absorption * -distance.max(0.0);
    Vec3::new(exponent.x.exp(), exponent.y.exp(), exponent.z.exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snell_and_reversibility() {
        for degrees in [0.0f32, 10.0, 35.0, 60.0, 85.0] {
            let angle = degrees.to_radians();
            let incoming = Vec3::new(angle.sin(), -angle.cos(), 0.0);
            let inside = refract(incoming, Vec3::Y, 1.0 / 1.5).unwrap();
            assert!((inside.x * 1.5 - angle.sin()).abs() < 1e-6);
            let back = refract(-inside, -Vec3::Y, 1.5).unwrap();
            assert!((back + incoming).length() < 1e-4, "{degrees}: {back} against {incoming}");
        }
    }

    #[test]
    fn total_internal_reflection_starts_at_the_critical_angle() {
        let critical = (1.0f32 / 1.5).asin();
        for (offset, reflected) in [(-1e-3, false), (1e-3, true)] {
            let angle = critical + offset;
            let incoming = Vec3::new(angle.sin(), -angle.cos(), 0.0);
            assert_eq!(refract(incoming, Vec3::Y, 1.5).is_none(), reflected);
            assert_eq!(fresnel_dielectric(angle.cos(), 1.5) == 1.0, reflected);
        }
    }

    #[test]
    fn fresnel_at_normal_incidence_and_brewster() {
        assert!((fresnel_dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        let brewster = 1.5f32.atan();
        // At Brewster's angle only the perpendicular part is reflected: ((n^2-1)/(n^2+1))^2 / 2.
        let expected = 0.5 * ((1.5f32 * 1.5 - 1.0) / (1.5 * 1.5 + 1.0)).powi(2);
        assert!((fresnel_dielectric(brewster.cos(), 1.0 / 1.5) - expected).abs() < 1e-6);
        assert_eq!(fresnel_dielectric(0.0, 1.0), 1.0);
        assert_eq!(fresnel_dielectric(0.5, 1.0), 0.0);
    }

    #[test]
    fn attenuation_multiplies_over_distance() {
        let absorption = Vec3::new(0.1, 1.0, 3.0);
        let once = transmittance(absorption, 2.0);
        let twice = transmittance(absorption, 1.0) * transmittance(absorption, 1.0);
        assert!((once - twice).abs().max_element() < 1e-6);
    }
}
