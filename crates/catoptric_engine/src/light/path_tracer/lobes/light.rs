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
}

impl LobeLight {
    /// The sum with so much of another one.
    pub fn plus(&self, other: &Self, weight: f32) -> Self {
        Self {
            visible: self.visible + other.visible * weight,
            found: self.found + other.found * weight,
            visible_lamps: self.visible_lamps + other.visible_lamps * weight,
        }
    }

    /// The same, times a factor.
    pub fn scaled(&self, factor: f32) -> Self {
        Self::default().plus(self, factor)
    }
}
