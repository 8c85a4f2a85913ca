//! Colours of what is seen directly and in mirrors.

use super::paths::MirrorPath;
use super::planes::Mirrors;
use crate::optics::{fresnel_dielectric, fresnel_schlick};
use crate::raster::{Fragment, Look, LookShader};
use crate::scene::{Ray, Role, Scene, ViewRays};
use glam::{DAffine3, Vec2, Vec3, Vec4Swizzles};
use std::collections::HashMap;

/// Colours chains of mirrors and what is seen in the last one.
pub(super) struct MirrorShader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) mirrors: &'a Mirrors,
    pub(super) rays: ViewRays,
    pub(super) paths: &'a [MirrorPath],
    /// The path that goes on from a path at a mirror.
    pub(super) children: HashMap<(u32, u32), u32>,
}

impl MirrorShader<'_> {
    /// The view ray through a picture position, where it is in the scene after a path's mirrors.
    fn ray(&self, path: u32, position: Vec2) -> Ray {
        let ray = self.rays.ray(position.x, position.y);
        let scene_from_world: &DAffine3 = &self.paths[path as usize].scene_from_world;
        if path == 0 {
            return ray;
        }
        Ray {
            origin: scene_from_world.transform_point3(ray.origin.as_dvec3()).as_vec3(),
            direction: scene_from_world.transform_vector3(ray.direction.as_dvec3()).as_vec3(),
        }
    }
}

impl LookShader for MirrorShader<'_> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline]
    fn look(&self, fragment: &Fragment<'_>) -> Look {
        let mut sum = Vec3::ZERO;
        let mut throughput = Vec3::ONE;
        let mut path = 0u32;
        for surface in fragment.chain {
            // The list is the path: one list is drawn for each.
            debug_assert_eq!(surface.list, path);
            let ray = self.ray(path, fragment.position);
            let material = self.scene.material_of(self.scene.triangle_objects[surface.source as usize]);
            match material.role {
                Role::Diffuse => return Look::of_diffuse(self.scene, surface, &ray, throughput, sum),
                Role::Lens => return Look::Color(sum),
                Role::Reflector | Role::Coated => {}
            }
            let point = self.scene.drawn_point(surface, &ray);
            let cosine = ray.direction.dot(point.normal).abs();
            let base = self.scene.base_color(material, &point).xyz();
            let tint = if material.role == Role::Coated {
                let reflectance = material.coat * fresnel_dielectric(cosine, 1.0 / material.ior);
                sum += throughput * (1.0 - reflectance) * self.scene.radiance(&point, -ray.direction);
                Vec3::splat(reflectance)
            } else if material.schlick {
                fresnel_schlick(base, cosine)
            } else {
                base
            };
            throughput *= tint;
            let mirror = self.mirrors.mirror_of_triangle[surface.source as usize];
            match self.children.get(&(path, mirror)) {
                Some(child) => path = *child,
                // The last order, a curved reflector or a blind side.
                None => return Look::Color(sum),
            }
        }
        // Nothing is drawn in the last mirror of the chain, or no mirror is seen at all: light from infinity.
        Look::Color(sum + throughput * self.scene.background(self.ray(path, fragment.position).direction))
    }
}
