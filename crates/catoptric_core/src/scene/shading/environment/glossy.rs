//! An environment seen in rough surfaces: maps of its radiance averaged over highlights.

use super::map::{EquirectangularMap, direction, positions};
use super::picture::Picture;
use crate::math::lanes::{MANY_LANES, Vec3Lanes};
use crate::math::portable::PortableMath;
use crate::math::random;
use crate::parallel;
use crate::scene::shading::microfacets;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Maps are for alpha 1, 1/2, 1/4, ...; between two of them radiance is blended linearly.
const LEVELS: usize = 7;

/// Directions that a texel averages, of the sharpest and of the roughest highlight.
const FEWEST_DIRECTIONS: u32 = 32;
const MOST_DIRECTIONS: u32 = 512;

/// Radiance averaged over highlights, roughest first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GlossyMaps {
    levels: Vec<EquirectangularMap>,
}

impl GlossyMaps {
    pub(super) fn new(picture: &Picture) -> Self {
        Self { levels: (0..LEVELS).map(|level| map(picture, level)).collect() }
    }

    pub(super) fn levels(&self) -> &[EquirectangularMap] {
        &self.levels
    }

    /// The mean radiance over a highlight around a direction, by its position in the picture.
    #[inline(always)]
    pub(super) fn radiance(&self, picture: &Picture, position: Vec2, alpha: f32) -> Vec3 {
        let sharpest = alpha_of(LEVELS - 1);
        if alpha < sharpest {
            let sharp = picture.at_whole_level(position, 0);
            return sharp + (self.levels[LEVELS - 1].at(position) - sharp) * (alpha / sharpest).max(0.0);
        }
        // The logarithm's whole part and, nearly linear between powers of two, the rest: the shares of both maps.
        let bits = alpha.min(1.0).to_bits();
        let whole = 127 - (bits >> 23) as i32;
        let mantissa = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
        // Alpha is the mantissa, 1 to 2, over 2 to the power of `whole`.
        let level = (whole as usize).clamp(1, LEVELS - 1);
        let share = if whole < 1 { 1.0 } else { mantissa - 1.0 };
        let sharp = self.levels[level].at(position);
        sharp + (self.levels[level - 1].at(position) - sharp) * share
    }
}

fn alpha_of(level: usize) -> f32 {
    1.0 / (1u32 << level) as f32
}

/// The map of one roughness: some texels across a highlight.
fn map(picture: &Picture, level: usize) -> EquirectangularMap {
    let height = (2usize << level).max(16);
    let width = 2 * height;
    let count = ((8 * MOST_DIRECTIONS) >> level).clamp(FEWEST_DIRECTIONS, MOST_DIRECTIONS);
    let steps = steps(picture, alpha_of(level), count);
    let radiance = parallel::map_collect(width * height, |texel| {
        let (x, y) = (texel % width, texel / width);
        let middle = direction((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        mean(picture, middle, &steps).extend(0.0).to_array()
    });
    EquirectangularMap::new(width, height, &radiance)
}

/// The mean over a highlight around a direction.
#[cfg_attr(not(debug_assertions), multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt")))]
fn mean(picture: &Picture, middle: Vec3, steps: &[(Vec3, f32, usize)]) -> Vec3 {
    let (across, along) = middle.any_orthonormal_pair();
    let mut sum = Vec3::ZERO;
    for steps in steps.chunks(MANY_LANES) {
        let mut directions = Vec3Lanes::<MANY_LANES>::ZERO;
        for (lane, (step, ..)) in steps.iter().enumerate() {
            directions.set(lane, across * step.x + along * step.y + middle * step.z);
        }
        let [u, v] = positions(&directions);
        for (lane, &(_, weight, reduction)) in steps.iter().enumerate() {
            sum += picture.at_whole_level(Vec2::new(u[lane], v[lane]), reduction) * weight;
        }
    }
    sum
}

/// Directions of light in a frame around a highlight's middle, each with its weight and the reduction of the picture
/// at which a texel has the extent that it stands for (Křivánek, Colbert 2008).
fn steps(picture: &Picture, alpha: f32, count: u32) -> Vec<(Vec3, f32, usize)> {
    let texel = 4.0 * PI / (picture.width as f32 * picture.height as f32);
    let mut steps = Vec::with_capacity(count as usize);
    for place in 0..count {
        let facet = microfacets::visible_facet(alpha, Vec3::Z, random::hammersley(place, count));
        let direction = facet * (2.0 * facet.z) - Vec3::Z;
        if direction.z <= 0.0 {
            continue;
        }
        let extent = microfacets::extent_of_sample(alpha, facet.z, 1.0, count);
        let reduction = (0.5 * (extent / texel).logarithm2()).clamp(0.0, picture.reduced.len() as f32) as usize;
        steps.push((direction, microfacets::unshadowed_share(alpha, direction.z, 1.0), reduction));
    }
    let sum: f32 = steps.iter().map(|(_, weight, _)| weight).sum();
    steps.iter_mut().for_each(|(_, weight, _)| *weight /= sum);
    steps
}
