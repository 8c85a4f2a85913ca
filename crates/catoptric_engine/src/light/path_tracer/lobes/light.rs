//! The light over lobes, as rays have told.

use super::lobe::Lobe;
use glam::Vec3;

/// Lobes of a surface that have rays of their own: of the coat, the reflection, and what passes thin walls.
pub const LOBES: usize = 3;

/// The least share of the places around that must know all of a lobe's light.
const LEAST_KNOWN: f32 = 0.999;

/// A lobe shows what others around it show if its normal is turned by no more than this share of the facets' width, and
/// its own width differs by no more than that share. Chosen far below what can be seen, not measured.
const LARGEST_TURN: f32 = 0.05;
const LARGEST_CHANGE: f32 = 0.02;

/// The same for its reflectance, as a factor of each colour: by more, dark metals say too little of bright ones beside
/// them. Chosen, not measured.
const LARGEST_TINT: f32 = 2.0;

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

    /// All the light that a lobe shows, if it is much like those whose light is known around it.
    pub(super) fn of_lobe_like(&self, lobe: &Lobe<'_>, incoming: Vec3) -> Option<Vec3> {
        let ShownLight { share, normal, alpha, weight, radiance } = self.shown;
        let own = lobe.facing.normal;
        let turn = own.distance_squared(normal.normalize_or_zero());
        let is_like = share > LEAST_KNOWN
            && turn <= (LARGEST_TURN * alpha).powi(2)
            && (lobe.alpha - alpha).abs() <= LARGEST_CHANGE * alpha;
        let tint = lobe.weight(-incoming.dot(own)) / weight;
        // Not a number: no.
        let least = tint.cmpge(Vec3::splat(1.0 / LARGEST_TINT));
        let is_tinted_alike = (least & tint.cmple(Vec3::splat(LARGEST_TINT))).all();
        (is_like && is_tinted_alike && lobe.is_plain()).then(|| radiance * tint)
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
