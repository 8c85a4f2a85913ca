//! Layers about a group, looked up.

use super::shell::Shell;
use super::texels::Texture;
use crate::scene::{Ray, RayDifferential, Scene};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// One layer: a shell with its texture.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    pub(super) shell: Shell,
    pub(super) texture: Texture,
}

/// The layers about a group, the nearest first.
#[derive(Clone, Debug, Default)]
pub(super) struct LayeredMap {
    /// Of all shells.
    pub(super) center: Vec3,
    pub(super) layers: Vec<Layer>,
}

/// What is behind layers that hide less than this share is not worth a look.
const OPAQUE: f32 = 1.0 / 1024.0;

impl Layer {
    /// What a ray (from the centre) sees of it: radiance times opacity, and opacity.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn seen(&self, ray: &Ray, change: &RayDifferential) -> Vec4 {
        let (place, changes) = self.shell.footprint(ray, change);
        self.texture.fetch(place, changes)
    }
}

/// The layers of several viewpoints, with their shares.
pub(super) type Blended<'a> = [(&'a LayeredMap, f32)];

/// What arrives along a ray, blended over viewpoints.
#[inline(always)] // for the instructions of its caller
pub(super) fn radiance(maps: &Blended<'_>, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
    let sum: Vec3 = maps.iter().map(|(map, share)| map.radiance(scene, ray, change) * *share).sum();
    // Inferred textures may swing below zero beside what is bright.
    sum.max(Vec3::ZERO)
}

/// How far away what a ray meets is taken to be.
pub(super) fn distance(maps: &Blended<'_>, ray: &Ray) -> f32 {
    maps.first().map_or(f32::INFINITY, |(map, _)| map.distance(ray))
}

impl LayeredMap {
    /// What arrives along a ray: layer over layer, before the scene's background.
    #[inline(always)] // for the instructions of its caller
    fn radiance(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let from_center = Ray { origin: ray.origin - self.center, ..*ray };
        let (mut sum, mut passes) = (Vec3::ZERO, 1.0);
        for layer in &self.layers {
            let seen = layer.seen(&from_center, change);
            sum += seen.xyz() * passes;
            passes *= 1.0 - seen.w.clamp(0.0, 1.0);
            if passes < OPAQUE {
                return sum;
            }
        }
        sum + scene.background(ray.direction) * passes
    }

    /// How far away what a ray meets is taken to be: the shell of the first layer that hides more than half.
    fn distance(&self, ray: &Ray) -> f32 {
        let from_center = Ray { origin: ray.origin - self.center, ..*ray };
        let hides = |layer: &&Layer| layer.seen(&from_center, &RayDifferential::default()).w > 0.5;
        let layer = self.layers.iter().find(hides);
        layer.map_or(f32::INFINITY, |layer| layer.shell.distance(from_center.origin, ray.direction))
    }

    /// Memory of all textures.
    pub(super) fn byte_count(&self) -> u64 {
        self.layers.iter().map(|layer| size_of_val(layer.texture.texels.as_slice()) as u64).sum()
    }
}
