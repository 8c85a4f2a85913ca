//! What a picture shows: the adaptive mesh before the scene.

use super::maps::{self, Blended};
use super::mesh::AdaptiveMesh;
use super::settings::Edges;
use crate::methods::lookup::greedy::{First, GreedyPaths};
use crate::optics::{Interface, transmittance};
use crate::raster::{Fragment, LayerSurface, Look, LookShader};
use crate::scene::{Ray, RayDifferential, Role, Scene, ViewRays};
use glam::Vec3;
use std::sync::atomic::{AtomicU64, Ordering};

/// Colours a view of the scene.
pub(super) struct LensShader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// Of every object the paths among its group, and the layers about that.
    pub(super) lenses: &'a (dyn Fn(u32) -> Option<(GreedyPaths<'a>, &'a Blended<'a>)> + Sync),
    pub(super) mesh: &'a AdaptiveMesh,
    /// What is seen where the mesh's paths take different ways.
    pub(super) edges: Edges,
    /// Rays that were traced for fragments.
    pub(super) ray_count: &'a AtomicU64,
}

impl LookShader for LensShader<'_> {
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
        if !self.scene.role_of(object).is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return Look::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        Look::Color(self.lens(object, surface, &ray, &change))
    }
}

impl LensShader<'_> {
    /// What a reflector or lens shows.
    #[inline(always)] // for the instructions of its caller
    fn lens(&self, object: u32, surface: &LayerSurface, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let scene = self.scene;
        let encounter = scene.drawn_encounter(surface, ray, change);
        let point = &encounter.point;
        let material = scene.material_of(object);
        let interface = Interface::of(scene, material, point, ray.direction);
        let own = match interface.scattered {
            0.0 => Vec3::ZERO,
            _ => scene.own_radiance(point, -ray.direction),
        };
        let Some((paths, maps)) = (self.lenses)(object) else {
            // Nothing is reflected at order 0.
            return own * interface.scattered;
        };
        let blend = self.mesh.blend(surface);
        let arriving = |first: First, arrived: &mut f32| {
            let blended = blend.as_ref().and_then(|blend| match self.edges {
                Edges::Traced => blend.path(first as usize),
                Edges::Nearest => blend.path(first as usize).or_else(|| Some(blend.nearest(first as usize))),
            });
            let (path, change) = blended.unwrap_or_else(|| {
                let path = paths.follow(ray.direction, encounter, first);
                self.ray_count.fetch_add(u64::from(path.events), Ordering::Relaxed);
                (path, RayDifferential::default())
            });
            let Some(leaving) = &path.leaving else { return path.added };
            if interface.attenuation.is_some() {
                *arrived = maps::distance(maps, leaving);
            }
            path.added + path.share * maps::radiance(maps, scene, leaving, &change)
        };
        let (mut sum, mut own_share, mut distance) = (Vec3::ZERO, interface.scattered, f32::INFINITY);
        if interface.reflected != Vec3::ZERO {
            let mut reflection = interface.reflected * arriving(First::Reflected, &mut distance);
            if let Some(deferred) = interface.deferred(own) {
                let (settled, weight) = deferred.settled(distance);
                (own_share, reflection) = (0.0, settled + reflection * weight);
            }
            sum += reflection;
        }
        if interface.transmitted != Vec3::ZERO {
            sum += interface.transmitted * arriving(First::Refracted, &mut distance);
        }
        sum += own * own_share;
        if material.role == Role::Lens && !interface.facing.outside {
            sum *= transmittance(material.absorption, ray.origin.distance(point.position));
        }
        if sum.is_finite() { sum } else { Vec3::ZERO }
    }
}
