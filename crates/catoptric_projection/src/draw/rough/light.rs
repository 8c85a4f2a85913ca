//! The light of a place of a rough mirror.

use glam::Vec3;

/// Distances beyond are none.
const FAR: f32 = 1e12;

/// The light that a place of a rough mirror reflects, before tint and Fresnel's share.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct RoughLight {
    /// The mean radiance over the lobe, times its weight.
    pub(in super::super) radiance: Vec3,
    /// The mean over the lobe of refracted light, at a lens.
    pub(in super::super) refracted: Vec3,
    /// The weight of the mean against the sharp ray's light: 0 where the lobe covers no more than a pixel.
    pub(in super::super) weight: f32,
    /// The radiance along the sharp ray of the place.
    pub(in super::super) sharp: Vec3,
    /// The share of light that facets neither mask nor shadow.
    pub(in super::super) share: f32,
    /// The distance of the surface in the sharp reflection.
    pub(in super::super) distance: f32,
    /// The width of the lobe's bright part, in pixels of the sharp reflection.
    pub(in super::super) width_px: f32,
}

impl RoughLight {
    /// The sum with so much of another one.
    #[inline]
    pub(super) fn plus(&self, other: &Self, weight: f32) -> Self {
        Self {
            radiance: self.radiance + other.radiance * weight,
            refracted: self.refracted + other.refracted * weight,
            weight: self.weight + other.weight * weight,
            sharp: self.sharp + other.sharp * weight,
            share: self.share + other.share * weight,
            distance: self.distance + other.distance.min(FAR) * weight,
            width_px: self.width_px + other.width_px * weight,
        }
    }
}
