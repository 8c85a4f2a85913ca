//! Colours of diffuse surfaces, and of reflectors that look light up.

use super::reflector::ReflectorLook;
use crate::raster::{Fragment, Look, LookShader};
use crate::scene::{Scene, ViewRays};
use glam::Vec3;

/// Colours a view of the scene.
pub(super) struct LookupShader<'a, L> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// What reflectors and lenses look like.
    pub(super) reflectors: &'a L,
}

impl<L: ReflectorLook> LookShader for LookupShader<'_, L> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline]
    fn look(&self, fragment: &Fragment<'_>) -> Look {
        let at = fragment.position;
        let Some(surface) = fragment.chain.first() else {
            return Look::Color(self.scene.background(self.rays.ray(at.x, at.y).direction));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        let material = self.scene.material_of(object);
        if !material.role.is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return Look::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        let encounter = self.scene.drawn_encounter(surface, &ray, &change);
        Look::Color(self.reflectors.radiance(self.scene, &encounter, &ray, &change))
    }
}
