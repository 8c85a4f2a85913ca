//! An environment seen in rough surfaces: maps of its radiance averaged over highlights.

use super::{Environment, EquirectangularMap, bilinear};
use crate::parallel;
use crate::scene::shading::microfacets;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Maps are for alpha 1, 1/2, 1/4, ... Between them radiance is blended by the logarithm of alpha.
const LEVELS: usize = 7;

/// Directions that a texel averages, of the sharpest and of the roughest highlight.
const FEWEST_DIRECTIONS: u32 = 32;
const MOST_DIRECTIONS: u32 = 2048;

/// Radiance averaged over highlights, roughest first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GlossyMaps {
    levels: Vec<EquirectangularMap>,
}

impl GlossyMaps {
    pub(super) fn new(environment: &Environment) -> Self {
        Self { levels: (0..LEVELS).map(|level| map(environment, level)).collect() }
    }

    /// The mean radiance over a highlight around a direction.
    #[inline]
    pub(super) fn radiance(&self, environment: &Environment, direction: Vec3, alpha: f32) -> Vec3 {
        let position = Environment::position(direction);
        let of = |level: usize| {
            let map = &self.levels[level];
            bilinear(&map.radiance, map.width, map.height, position)
        };
        let sharpest = alpha_of(LEVELS - 1);
        if alpha < sharpest {
            let sharp = environment.at_level(position, 0.0);
            return sharp + (of(LEVELS - 1) - sharp) * (alpha / sharpest).max(0.0);
        }
        let level = -alpha.min(1.0).log2();
        let whole = (level as usize).min(LEVELS - 2);
        let (rough, share) = (of(whole), level - whole as f32);
        rough + (of(whole + 1) - rough) * share
    }
}

fn alpha_of(level: usize) -> f32 {
    1.0 / (1u32 << level) as f32
}

/// The map of one roughness: some texels across a highlight.
fn map(environment: &Environment, level: usize) -> EquirectangularMap {
    let height = (4usize << level).max(16);
    let width = 2 * height;
    let count = (MOST_DIRECTIONS >> level).max(FEWEST_DIRECTIONS);
    let steps = steps(environment, alpha_of(level), count);
    let radiance = parallel::map_collect(width * height, |texel| {
        let (x, y) = (texel % width, texel / width);
        let middle = Environment::direction((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let (across, along) = middle.any_orthonormal_pair();
        let mut sum = Vec3::ZERO;
        for &(step, weight, reduction) in &steps {
            let direction = across * step.x + along * step.y + middle * step.z;
            sum += environment.at_level(Environment::position(direction), reduction) * weight;
        }
        sum.to_array()
    });
    EquirectangularMap { width, height, radiance }
}

/// Directions of light in a frame around a highlight's middle, each with its weight and the reduction of the picture
/// at which a texel has the extent that it stands for (Křivánek, Colbert 2008).
fn steps(environment: &Environment, alpha: f32, count: u32) -> Vec<(Vec3, f32, f32)> {
    let texel = 4.0 * PI / (environment.width as f32 * environment.height as f32);
    let mut steps = Vec::with_capacity(count as usize);
    for place in 0..count {
        let number = Vec2::new((place as f32 + 0.5) / count as f32, place.reverse_bits() as f32 / 4_294_967_296.0);
        let facet = microfacets::visible_facet(alpha, Vec3::Z, number);
        let direction = facet * (2.0 * facet.z) - Vec3::Z;
        if direction.z <= 0.0 {
            continue;
        }
        // The density of facets that a viewer along the normal sees is the distribution times the cosine; a mirror
        // spreads it over four times the solid angle.
        let spread = 1.0 - facet.z * facet.z * (1.0 - alpha * alpha);
        let density = alpha * alpha / (PI * spread * spread) / 4.0;
        let extent = 1.0 / (count as f32 * density.max(1e-9));
        let reduction = (0.5 * (extent / texel).log2()).clamp(0.0, environment.reduced.len() as f32);
        steps.push((direction, microfacets::unshadowed_share(alpha, direction.z, 1.0), reduction));
    }
    let sum: f32 = steps.iter().map(|(_, weight, _)| weight).sum();
    steps.iter_mut().for_each(|(_, weight, _)| *weight /= sum);
    steps
}
