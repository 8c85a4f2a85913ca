//! Shading of a view: the adaptive mesh in front of the scene.

use super::mesh::AdaptiveMesh;
use super::mesh::blend::PathBlend;
use super::settings::Edges;
use super::textures::maps::{self, LayersAbout};
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Ray, RayDifferential, Role, Scene, ViewRays};
use catoptric_engine::light::reflector_shader::FirstSurface;
use catoptric_engine::light::two_path_tracer::{SpecularChain, TwoPathTracer};
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::step::{LightStep, crossed_medium, transmittance};
use catoptric_engine::raster::{Fragment, FragmentBatch, FragmentShader, LayerSurface, ShadingRequest, shade_looks};
use glam::{Vec2, Vec3};
use std::sync::atomic::{AtomicU64, Ordering};

/// Colours a view of the scene.
pub(super) struct LensShader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// Tracer of every object's group, and the group's number.
    pub(super) lenses: &'a (dyn Fn(u32) -> Option<(TwoPathTracer<'a>, usize)> + Sync),
    /// Layers about every group, with their weights.
    pub(super) maps: &'a [Vec<(LayersAbout<'a>, f32)>],
    pub(super) mesh: &'a AdaptiveMesh,
    /// Treatment of fragments whose corners' paths have different events.
    pub(super) edges: Edges,
    /// Rays that were traced for fragments.
    pub(super) ray_count: &'a AtomicU64,
}

/// A ray that leaves a group.
pub(super) struct DeferredLookUp {
    pub(super) group: usize,
    /// The factor of its light, and the number of the fragment in which it is seen.
    pub(super) share: Vec3,
    fragment: usize,
}

/// Rays that leave groups, to be looked up side by side.
#[derive(Default)]
pub(super) struct DeferredLookUps {
    pub(super) list: Vec<DeferredLookUp>,
    pub(super) rays: Vec<(Ray, RayDifferential)>,
}

/// Look-ups of both paths: rays of one path stay close to their neighbours', which makes their look-ups cheaper.
pub(super) type Waiting = [DeferredLookUps; 2];

impl FragmentShader for LensShader<'_> {
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        let mut waiting = Waiting::default();
        let mut color = self.look(fragment, 0, &mut waiting).color(self.scene);
        self.add(&waiting, std::slice::from_mut(&mut color));
        color
    }

    fn shade_batch(&self, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
        shade_lenses(self, batch, colors);
    }

    fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
        self.scene.is_surface_present(surface.source, &surface.barycentrics)
    }
}

#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn shade_lenses(shader: &LensShader<'_>, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
    let mut waiting = Waiting::default();
    shade_looks(shader.scene, Some(&shader.rays), batch, colors, |index, fragment| {
        shader.look(fragment, index, &mut waiting)
    });
    shader.add(&waiting, colors);
}

impl LensShader<'_> {
    /// Radiance of a fragment without that of deferred look-ups.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn look(&self, fragment: &Fragment<'_>, index: usize, waiting: &mut Waiting) -> ShadingRequest {
        let at = fragment.position;
        let Some(surface) = fragment.chain.first() else {
            return ShadingRequest::Color(self.scene.background_seen(self.rays.ray(at.x, at.y).direction));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        if !self.scene.role_of(object).is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return ShadingRequest::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        ShadingRequest::Color(self.lens(object, surface, &self.rays.ray(at.x, at.y), index, waiting))
    }

    /// Radiance of a reflector or lens without that of deferred look-ups.
    #[inline(always)] // for the instructions of its caller
    fn lens(&self, object: u32, surface: &LayerSurface, ray: &Ray, fragment: usize, waiting: &mut Waiting) -> Vec3 {
        let scene = self.scene;
        let point = &scene.drawn_point(surface.source, &surface.barycentrics, ray);
        let Some((paths, group)) = (self.lenses)(object) else {
            // At order 0 nothing is reflected.
            return FirstSurface::of(scene, point, ray.direction, |_| None).own;
        };
        let blend = self.mesh.blend(surface);
        let path = |first: BounceKind| self.path(&paths, blend.as_ref(), ray, point, first);
        let mut reflected = None;
        let distance = |_: &LightStep| {
            let (path, _) = reflected.insert(path(BounceKind::Reflect));
            let distance = path.leaving.map(|leaving| maps::distance(&self.maps[group], &leaving));
            Some(distance.unwrap_or(f32::INFINITY))
        };
        let FirstSurface { lobe, own, shares, .. } = FirstSurface::of(scene, point, ray.direction, distance);
        let outside = ray.direction.dot(point.geometric_normal) <= 0.0;
        let material = scene.material_of(object);
        let absorption = crossed_medium(material.role == Role::Lens, outside, material.absorption, Vec3::ZERO);
        let passes = transmittance(absorption, ray.origin.distance(point.position));
        let mut sum = own;
        let mut divides = true;
        for (first, share) in BounceKind::BOTH.into_iter().zip(shares).filter(|(_, share)| *share != Vec3::ZERO) {
            if !divides {
                break;
            }
            let known = reflected.filter(|_| first == BounceKind::Reflect);
            let (path, change) = known.unwrap_or_else(|| path(first));
            divides = path.divides;
            sum += share * path.added;
            let share = share * path.share * passes;
            let (mut leaving, mut change) = (path.leaving, change);
            if let (Some(lobe), Some(leaving)) = (lobe.filter(|_| first == BounceKind::Reflect), &mut leaving) {
                // The cone about the first event's mean direction; after more events, about the path's.
                if path.events == 1 {
                    leaving.direction = lobe.direction;
                }
                change = change.widened(leaving.direction, lobe.width);
            }
            if let Some(leaving) = leaving.filter(|leaving| share.is_finite() && leaving.direction.is_finite()) {
                let waiting = &mut waiting[first as usize];
                waiting.list.push(DeferredLookUp { group, share, fragment });
                waiting.rays.push((leaving, change));
            }
        }
        let sum = sum * passes;
        if sum.is_finite() { sum } else { Vec3::ZERO }
    }

    /// A fragment's path by one of the ways from its surface, with the change of the ray that leaves.
    #[inline(always)] // for the instructions of its caller
    fn path(
        &self,
        paths: &TwoPathTracer<'_>,
        blend: Option<&PathBlend<'_>>,
        ray: &Ray,
        point: &SurfacePoint,
        first: BounceKind,
    ) -> (SpecularChain, RayDifferential) {
        let blended = blend.and_then(|blend| match self.edges {
            Edges::Traced | Edges::Once => blend.path(first as usize),
            Edges::Nearest => blend.path(first as usize).or_else(|| Some(blend.nearest(first as usize))),
        });
        blended.unwrap_or_else(|| {
            let path = paths.follow(ray.direction, *point, first);
            self.ray_count.fetch_add(u64::from(path.events), Ordering::Relaxed);
            (path, RayDifferential::default())
        })
    }

    /// Adds the deferred look-ups.
    #[inline(always)] // for the instructions of its caller
    fn add(&self, waiting: &Waiting, colors: &mut [Vec3]) {
        for DeferredLookUps { list, rays } in waiting {
            let mut first = 0;
            for list in list.chunk_by(|a, b| a.group == b.group) {
                let rays = &rays[first..first + list.len()];
                first += list.len();
                maps::radiance(&self.maps[list[0].group], self.scene, rays, |index, radiance| {
                    let DeferredLookUp { share, fragment, .. } = list[index];
                    let added = share * radiance;
                    colors[fragment] += if added.is_finite() { added } else { Vec3::ZERO };
                });
            }
        }
    }
}
