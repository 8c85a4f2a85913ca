//! What a picture shows: the adaptive mesh before the scene.

use super::blend::Blend;
use super::maps::{self, LayersAbout};
use super::mesh::AdaptiveMesh;
use super::settings::Edges;
use crate::methods::lookup::greedy::{First, GreedyPath, GreedyPaths};
use crate::methods::lookup::reflector::FirstSurface;
use crate::optics::transmittance;
use crate::raster::{Fragment, FragmentBatch, FragmentShader, LayerSurface, Look, shade_looks};
use crate::scene::shade::SurfacePoint;
use crate::scene::{Ray, RayDifferential, Role, Scene, ViewRays};
use glam::{Vec2, Vec3};
use std::sync::atomic::{AtomicU64, Ordering};

/// Colours a view of the scene.
pub(super) struct LensShader<'a> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// Of every object the paths among its group, and that one's number.
    pub(super) lenses: &'a (dyn Fn(u32) -> Option<(GreedyPaths<'a>, usize)> + Sync),
    /// Of every group the layers about it, with their shares.
    pub(super) maps: &'a [Vec<(LayersAbout<'a>, f32)>],
    pub(super) mesh: &'a AdaptiveMesh,
    /// What is seen where the mesh's paths take different ways.
    pub(super) edges: Edges,
    /// Rays that were traced for fragments.
    pub(super) ray_count: &'a AtomicU64,
}

/// A ray that leaves a group.
struct LookUp {
    group: usize,
    /// What becomes of its light, and which fragment that is seen in.
    share: Vec3,
    fragment: usize,
}

/// Rays that leave groups, to be looked up side by side.
#[derive(Default)]
struct LookUps {
    list: Vec<LookUp>,
    rays: Vec<(Ray, RayDifferential)>,
}

/// Those of both ways: rays of one way stay close to their neighbours', which makes their look-ups cheaper.
type Waiting = [LookUps; 2];

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
        self.scene.is_surface_present(surface)
    }
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
    "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
))]
fn shade_lenses(shader: &LensShader<'_>, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
    let mut waiting = Waiting::default();
    shade_looks(shader.scene, batch, colors, |index, fragment| shader.look(fragment, index, &mut waiting));
    shader.add(&waiting, colors);
}

impl LensShader<'_> {
    /// What a fragment looks like, but for what is still to be looked up.
    #[inline(always)] // for the instructions of its caller
    fn look(&self, fragment: &Fragment<'_>, index: usize, waiting: &mut Waiting) -> Look {
        let at = fragment.position;
        let Some(surface) = fragment.chain.first() else {
            return Look::Color(self.scene.background(self.rays.ray(at.x, at.y).direction));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        if !self.scene.role_of(object).is_specular() {
            let ray = self.rays.ray(at.x, at.y);
            return Look::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        Look::Color(self.lens(object, surface, &self.rays.ray(at.x, at.y), index, waiting))
    }

    /// What a reflector or lens shows, but for what is still to be looked up.
    #[inline(always)] // for the instructions of its caller
    fn lens(&self, object: u32, surface: &LayerSurface, ray: &Ray, fragment: usize, waiting: &mut Waiting) -> Vec3 {
        let scene = self.scene;
        let point = &scene.drawn_point(surface, ray);
        let Some((paths, group)) = (self.lenses)(object) else {
            // Nothing is reflected at order 0.
            return FirstSurface::of(scene, point, ray.direction, || None).own;
        };
        let blend = self.mesh.blend(surface);
        let path = |first: First| self.path(&paths, blend.as_ref(), ray, point, first);
        let mut reflected = None;
        let distance = || {
            let (path, _) = reflected.insert(path(First::Reflected));
            let distance = path.leaving.map(|leaving| maps::distance(&self.maps[group], &leaving));
            Some(distance.unwrap_or(f32::INFINITY))
        };
        let FirstSurface { own, shares } = FirstSurface::of(scene, point, ray.direction, distance);
        let material = scene.material_of(object);
        let is_inside = material.role == Role::Lens && ray.direction.dot(point.geometric_normal) > 0.0;
        let passes = match is_inside {
            true => transmittance(material.absorption, ray.origin.distance(point.position)),
            false => Vec3::ONE,
        };
        let mut sum = own;
        let mut divides = true;
        for (first, share) in First::BOTH.into_iter().zip(shares).filter(|(_, share)| *share != Vec3::ZERO) {
            if !divides {
                break;
            }
            let known = reflected.filter(|_| first == First::Reflected);
            let (path, change) = known.unwrap_or_else(|| path(first));
            divides = path.divides;
            sum += share * path.added;
            let share = share * path.share * passes;
            if let Some(leaving) = path.leaving.filter(|leaving| share.is_finite() && leaving.direction.is_finite()) {
                let waiting = &mut waiting[first as usize];
                waiting.list.push(LookUp { group, share, fragment });
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
        paths: &GreedyPaths<'_>,
        blend: Option<&Blend<'_>>,
        ray: &Ray,
        point: &SurfacePoint,
        first: First,
    ) -> (GreedyPath, RayDifferential) {
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

    /// Adds what was still to be looked up.
    #[inline(always)] // for the instructions of its caller
    fn add(&self, waiting: &Waiting, colors: &mut [Vec3]) {
        for LookUps { list, rays } in waiting {
            let mut first = 0;
            for list in list.chunk_by(|a, b| a.group == b.group) {
                let rays = &rays[first..first + list.len()];
                first += list.len();
                maps::radiance(&self.maps[list[0].group], self.scene, rays, |index, radiance| {
                    let LookUp { share, fragment, .. } = list[index];
                    let added = share * radiance;
                    colors[fragment] += if added.is_finite() { added } else { Vec3::ZERO };
                });
            }
        }
    }
}
