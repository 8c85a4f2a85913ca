//! How a small change of a ray and of the surface's normal changes the mirrored or refracted direction (Igehy 1999).

use glam::Vec3;

/// The change of the mirror direction (Igehy 1999, equation 14).
///
/// `incoming` and `normal` are unit vectors, the changes are per pixel; the sign of the normal does not matter if its
/// change has the same.
#[inline]
pub fn reflected_change(incoming: Vec3, incoming_change: Vec3, normal: Vec3, normal_change: Vec3) -> Vec3 {
    let cosine_change = incoming_change.dot(normal) + incoming.dot(normal_change);
    incoming_change - (normal_change * incoming.dot(normal) + normal * cosine_change) * 2.0
}

/// The change of the refracted direction (Igehy 1999, equations 15 to 18).
///
/// The normal is on the side the ray comes from, `eta` as in [`refract`](super::refract).
#[inline]
pub fn refracted_change(incoming: Vec3, incoming_change: Vec3, normal: Vec3, normal_change: Vec3, eta: f32) -> Vec3 {
    let cos_in = -incoming.dot(normal);
    // Near the critical angle the change grows without bound; footprints that large blur to the mean all the same.
    let cos_out = (1.0 - eta * eta * (1.0 - cos_in * cos_in)).max(1e-4).sqrt();
    let cos_change = -(incoming_change.dot(normal) + incoming.dot(normal_change));
    let along_change = (eta - eta * eta * cos_in / cos_out) * cos_change;
    incoming_change * eta + normal_change * (eta * cos_in - cos_out) + normal * along_change
}
