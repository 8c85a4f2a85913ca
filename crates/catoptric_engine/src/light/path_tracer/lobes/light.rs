//! The light over lobes, where it is known around them.

use super::super::lobe_light::{LobeLight, ShownLight};
use super::lobe::Lobe;
use glam::Vec3;

/// The least share of the places around that must know all of a lobe's light.
const LEAST_KNOWN: f32 = 0.999;

/// A lobe shows what others around it show if its normal is turned by no more than this share of the facets' width, and
/// its own width differs by no more than that share. Chosen far below what can be seen, not measured.
const LARGEST_TURN: f32 = 0.05;
const LARGEST_CHANGE: f32 = 0.02;

/// The same for its reflectance, as a factor of each colour: by more, dark metals say too little of bright ones beside
/// them. Chosen, not measured.
const LARGEST_TINT: f32 = 2.0;

impl LobeLight {
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
}
