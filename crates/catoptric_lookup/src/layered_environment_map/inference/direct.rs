//! Texels that pictures of reflectors and lenses miss, traced directly from the viewpoint (Hakura, Snyder 2001,
//! section 4.3).

use super::observations::Observations;
use crate::layered_environment_map::textures::maps::Layer;
use catoptric_core::math::portable::PortableMath;
use glam::Vec3;

/// The distance from everything that pictures read, in degrees at the centre, from which on texels count in full.
/// Chosen, not measured.
const SURELY_MISSING_DEG: f32 = 5.0;

/// The number of a missing texel.
const NONE: u32 = u32::MAX;

/// The texels of a layer's finest level that pictures read, or nearly read.
pub struct Missing<'a> {
    layer: &'a Layer,
    /// For every texel one that is read and about the nearest; [`NONE`] if no picture reads any.
    nearest: Vec<u32>,
}

impl<'a> Missing<'a> {
    /// Finds the texels that pictures read.
    pub fn from<'b>(layer: &'a Layer, pictures: impl IntoIterator<Item = &'b Observations>) -> Self {
        let layout = &layer.texture.layout;
        let mut missing = Self { layer, nearest: vec![NONE; layout.finest_count()] };
        let mut reached = Vec::new();
        for ray in pictures.into_iter().flat_map(|picture| &picture.list).map(|observation| observation.ray) {
            if let Some(texel) = layer.texel_at(&ray).filter(|texel| missing.nearest[*texel as usize] == NONE) {
                missing.nearest[texel as usize] = texel;
                reached.push(texel);
            }
        }
        // The search goes from texel to texel, away from those that are read.
        while !reached.is_empty() {
            let mut next = Vec::new();
            for texel in reached {
                let nearest = missing.nearest[texel as usize];
                for beside in layout.beside(texel) {
                    if missing.nearest[beside as usize] == NONE && missing.angle(beside, nearest) < SURELY_MISSING_DEG {
                        missing.nearest[beside as usize] = nearest;
                        next.push(beside);
                    }
                }
            }
            reached = next;
        }
        missing
    }

    /// The likelihood that pictures miss a texel: 0 where they read it, to 1 where they read nothing near it.
    pub fn likelihood(&self, texel: u32) -> f32 {
        match self.nearest.get(texel as usize) {
            Some(&NONE) => 1.0,
            Some(nearest) => (self.angle(texel, *nearest) / SURELY_MISSING_DEG).powi(2).min(1.0),
            None => 0.0,
        }
    }

    /// The angle between texels at the centre, in degrees.
    fn angle(&self, a: u32, b: u32) -> f32 {
        let Layer { shell, texture, .. } = self.layer;
        let towards = |texel: u32| shell.towards(texture.layout.middle_of(texel)).normalize_or(Vec3::X);
        // The chord is exact for small angles, where the cosine is not.
        (2.0 * (0.5 * towards(a).distance(towards(b))).min(1.0).arc_sine()).to_degrees()
    }
}
