//! The light over lobes, as rays have told.

use glam::Vec3;

/// Lobes of a surface that have rays of their own: of the coat, the reflection, and what passes thin walls.
pub const LOBES: usize = 3;

/// The light over a lobe, as rays tell.
#[derive(Clone, Copy, Debug, Default)]
pub struct LobeLight {
    /// The share of light from infinity that arrives, beside lamps.
    pub(crate) visible: Vec3,
    /// The mean of what hides the rest.
    pub(crate) found: Vec3,
    /// The share of lamps' light that arrives.
    pub(crate) visible_lamps: f32,
    /// All the light that the lobe shows.
    pub(super) shown: ShownLight,
}

/// All the light that a lobe shows, and as much of the lobe as that depends on: means over places, weighted by `share`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShownLight {
    /// The share of places that know it.
    pub(super) share: f32,
    pub(super) normal: Vec3,
    pub(super) alpha: f32,
    /// The factor of light by a facet along the normal.
    pub(super) weight: Vec3,
    pub(super) radiance: Vec3,
}

impl LobeLight {
    /// The sum with so much of another one.
    pub fn plus(&self, other: &Self, weight: f32) -> Self {
        Self {
            visible: self.visible + other.visible * weight,
            found: self.found + other.found * weight,
            visible_lamps: self.visible_lamps + other.visible_lamps * weight,
            shown: self.shown.plus(&other.shown, weight),
        }
    }

    /// The same, times a factor.
    pub fn scaled(&self, factor: f32) -> Self {
        Self::default().plus(self, factor)
    }
}

impl ShownLight {
    fn plus(&self, other: &Self, weight: f32) -> Self {
        Self {
            share: self.share + other.share * weight,
            normal: self.normal + other.normal * weight,
            alpha: self.alpha + other.alpha * weight,
            weight: self.weight + other.weight * weight,
            radiance: self.radiance + other.radiance * weight,
        }
    }
}
