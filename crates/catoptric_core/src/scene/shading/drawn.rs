//! Surfaces drawn by their triangles: exact places on them, and the lists to draw.

use super::super::{AlphaMode, Ray, RayDifferential, Scene};
use super::shade::{Barycentrics, SurfaceInteraction, SurfacePoint};
use crate::surface::SurfaceHit;
use glam::Vec3;

impl Scene {
    /// The point on a ray that a drawn triangle shows.
    ///
    /// On an analytic surface it is where the ray meets the surface itself; beside its silhouette, where the ray
    /// misses, the point of the tessellation.
    #[inline]
    pub fn drawn_point(&self, triangle: u32, at: &Barycentrics, ray: &Ray) -> SurfacePoint {
        match self.exact_hit(triangle, at, ray) {
            Some((object, hit)) => self.exact_encounter(object, &hit, ray, None).point,
            None => self.surface_point(triangle, at),
        }
    }

    /// Like [`Self::drawn_point`], with its changes a pixel.
    #[inline]
    pub fn drawn_encounter(
        &self,
        triangle: u32,
        at: &Barycentrics,
        ray: &Ray,
        change: &RayDifferential,
    ) -> SurfaceInteraction {
        match self.exact_hit(triangle, at, ray) {
            Some((object, hit)) => self.exact_encounter(object, &hit, ray, Some(change)),
            None => self.encounter(triangle, at),
        }
    }

    #[inline]
    fn exact_hit(&self, triangle: u32, at: &Barycentrics, ray: &Ray) -> Option<(u32, SurfaceHit)> {
        let object = self.triangle_objects[triangle as usize];
        let exact = self.objects[object as usize].surface.as_ref()?;
        // The tessellation was drawn at this place: the ray's hit of the surface nearest to it.
        let drawn = self.position_on(triangle, at.value);
        let distance = (drawn - ray.origin).dot(ray.direction);
        Some((object, exact.refine(ray.origin, ray.direction, distance)?))
    }

    /// Returns true if a drawn triangle is there at all, by its alpha.
    pub fn is_surface_present(&self, triangle: u32, at: &Barycentrics) -> bool {
        let point = self.surface_point(triangle, at);
        self.is_present(self.material_of(point.object), &point)
    }

    /// The number shared by all triangles of an analytic object, which is one smooth surface; unlike every number in
    /// [`Self::triangle_parts`]. `None` for meshes.
    pub fn patch_of_object(&self, object: u32) -> Option<u32> {
        self.objects[object as usize].surface.as_ref().map(|_| u32::MAX - object)
    }

    /// Returns true if an object of triangles is seen from its outer side alone.
    #[inline(always)]
    pub fn is_one_sided(&self, object: u32) -> bool {
        self.material_of(object).is_one_sided() && self.objects[object as usize].surface.is_none()
    }

    /// Returns true if a ray of this direction meets a triangle from behind: its outer side is that of its corners'
    /// normals.
    #[inline]
    pub fn is_met_from_behind(&self, triangle: u32, direction: Vec3) -> bool {
        let [a, b, c] = self.triangles[triangle as usize].map(|vertex| vertex as usize);
        let face = (self.positions[b] - self.positions[a]).cross(self.positions[c] - self.positions[a]);
        let outer = self.normals[a] + self.normals[b] + self.normals[c];
        face.dot(direction) * face.dot(outer) > 0.0
    }

    /// Returns true if an object's material may have holes, where its alpha is low.
    pub fn is_alpha_tested(&self, object: u32) -> bool {
        let material = self.material_of(object);
        if material.alpha_mode == AlphaMode::Opaque {
            return false;
        }
        let texture = material.base_texture.as_ref().and_then(|binding| self.textures.get(binding.texture as usize));
        let of_texture = texture.map_or(1.0, |texture| texture.least_alpha());
        // A little less, for filters round.
        let least = material.base_color.w * of_texture * (1.0 - 1e-4);
        let is_there = match material.alpha_mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => least >= cutoff,
            AlphaMode::Blend => least > 0.0,
        };
        !is_there || !self.colors.is_empty()
    }
}
