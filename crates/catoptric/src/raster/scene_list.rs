//! Scenes as they stand: their objects as a list to draw, and a shader for what is seen directly.

use super::{DrawList, DrawTriangle, Fragment, FragmentBatch, FragmentShader, LayerSurface};
use crate::parallel;
use crate::scene::shade::{Encounter, SurfacePoint};
use crate::scene::{AlphaMode, PicturePoint, Ray, RayDifferential, Scene, SurfaceQuery, View, ViewRays};
use crate::surface::SurfaceHit;
use glam::{Vec2, Vec3};

/// Vertices that are transformed at once.
const VERTICES_AT_ONCE: usize = 4096;

/// The triangles of the wanted objects as a list in layer 0, seen from `view`. `group` gives the group of an object's
/// triangles, or none where the object is not wanted. Sources are the scene's triangles.
///
/// The list is as the tessellation stands: what is nearer than the near plane is cut off while drawing.
pub fn scene_draw_list(scene: &Scene, view: &View, group: impl Fn(u32) -> Option<u32>) -> DrawList {
    let mut vertices_from = Vec::new();
    let mut triangles = Vec::new();
    let mut vertex_count = 0u32;
    for (index, object) in scene.objects.iter().enumerate() {
        let Some(group) = group(index as u32) else { continue };
        let alpha_tested = scene.is_alpha_tested(index as u32);
        let analytic = scene.patch_of_object(index as u32);
        // What is seen in a mesh that reflects or refracts may change much between two samples.
        let is_smooth = !scene.role_of(index as u32).is_specular();
        let part = |triangle: u32| scene.triangle_parts.get(triangle as usize).copied().filter(|_| is_smooth);
        let first = object.vertices.start;
        for triangle in object.triangles.clone() {
            let vertices = scene.triangles[triangle as usize].map(|vertex| vertex - first + vertex_count);
            let patch = analytic.or_else(|| part(triangle)).unwrap_or(0);
            triangles.push(DrawTriangle { vertices, source: triangle, group, patch, alpha_tested });
        }
        vertices_from.push((vertex_count as usize, object.vertices.clone()));
        vertex_count += object.vertices.len() as u32;
    }
    let transform = view.picture_from_world();
    let mut vertices = vec![PicturePoint::default(); vertex_count as usize];
    parallel::for_each_chunk_mut(&mut vertices, VERTICES_AT_ONCE, |chunk, points| {
        let first = chunk * VERTICES_AT_ONCE;
        // The object that the chunk begins in, then on through the next ones.
        let mut object = vertices_from.partition_point(|(start, _)| *start <= first).saturating_sub(1);
        let mut done = 0;
        while done < points.len() && object < vertices_from.len() {
            let (start, range) = &vertices_from[object];
            let from = range.start as usize + (first + done - start);
            let count = (range.end as usize - from).min(points.len() - done);
            let positions = &scene.positions[from..from + count];
            for (point, position) in points[done..done + count].iter_mut().zip(positions) {
                *point = transform.apply(*position);
            }
            done += count;
            object += 1;
        }
    });
    DrawList { vertices, triangles, ..DrawList::default() }
}

impl Scene {
    /// The point that a drawn surface (its source a triangle of the scene) shows on a ray.
    ///
    /// On an analytic surface it is where the ray meets the surface itself; beside its silhouette, where the ray
    /// misses, the point of the tessellation.
    #[inline]
    pub fn drawn_point(&self, surface: &LayerSurface, ray: &Ray) -> SurfacePoint {
        match self.exact_hit(surface, ray) {
            Some((object, hit)) => self.exact_encounter(object, &hit, ray, None).point,
            None => self.surface_point(surface.source, &surface.barycentrics),
        }
    }

    /// Like [`Self::drawn_point`], with its changes a pixel.
    #[inline]
    pub fn drawn_encounter(&self, surface: &LayerSurface, ray: &Ray, change: &RayDifferential) -> Encounter {
        match self.exact_hit(surface, ray) {
            Some((object, hit)) => self.exact_encounter(object, &hit, ray, Some(change)),
            None => self.encounter(surface.source, &surface.barycentrics),
        }
    }

    #[inline]
    fn exact_hit(&self, surface: &LayerSurface, ray: &Ray) -> Option<(u32, SurfaceHit)> {
        let object = self.triangle_objects[surface.source as usize];
        let exact = self.objects[object as usize].surface.as_ref()?;
        // The tessellation was drawn at this place: of a ray's meetings with the surface the one near it is meant.
        let drawn = self.position_on(surface.source, surface.barycentrics.value);
        let distance = (drawn - ray.origin).dot(ray.direction);
        Some((object, exact.refine(ray.origin, ray.direction, distance)?))
    }

    /// Whether a drawn surface is there at all, by its alpha.
    pub fn is_surface_present(&self, surface: &LayerSurface) -> bool {
        let point = self.surface_point(surface.source, &surface.barycentrics);
        self.is_present(self.material_of(point.object), &point)
    }

    /// The [`DrawTriangle::patch`] of all triangles of an object that is one smooth surface: an analytic one.
    pub fn patch_of_object(&self, object: u32) -> Option<u32> {
        self.objects[object as usize].surface.as_ref().map(|_| u32::MAX - object)
    }

    /// Whether an object's material has holes where its alpha is low.
    pub fn is_alpha_tested(&self, object: u32) -> bool {
        self.material_of(object).alpha_mode != AlphaMode::Opaque
    }
}

/// What a fragment of a scene looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// This.
    Color(Vec3),
    /// What a point of a diffuse surface scatters: many such points are worked out together.
    Scattered {
        /// The point.
        query: SurfaceQuery,
        /// What becomes of its radiance on the way.
        throughput: Vec3,
        /// What comes from before it.
        added: Vec3,
    },
}

impl Look {
    /// What a surface (not one that reflects) looks like along a ray.
    #[inline]
    pub fn of_diffuse(scene: &Scene, surface: &LayerSurface, ray: &Ray, throughput: Vec3, added: Vec3) -> Self {
        let object = scene.triangle_objects[surface.source as usize];
        if scene.objects[object as usize].surface.is_some() {
            let point = scene.drawn_point(surface, ray);
            return Self::Color(added + throughput * scene.radiance(&point, -ray.direction));
        }
        let (triangle, barycentrics) = (surface.source, surface.barycentrics);
        let query = SurfaceQuery { triangle, barycentrics, towards_viewer: -ray.direction };
        Self::Scattered { query, throughput, added }
    }

    /// The colour, worked out alone.
    #[inline]
    pub fn color(&self, scene: &Scene) -> Vec3 {
        match self {
            Self::Color(color) => *color,
            Self::Scattered { query, throughput, added } => {
                let point = scene.surface_point(query.triangle, &query.barycentrics);
                *added + *throughput * scene.radiance(&point, query.towards_viewer)
            }
        }
    }
}

/// A shader of a scene's surfaces: it says what a fragment looks like, and leaves what diffuse surfaces scatter to be
/// worked out for many points together. Sources are the scene's triangles.
pub trait LookShader: Sync {
    /// The scene.
    fn scene(&self) -> &Scene;

    /// What a fragment looks like.
    fn look(&self, fragment: &Fragment<'_>) -> Look;
}

impl<S: LookShader> FragmentShader for S {
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        self.look(fragment).color(self.scene())
    }

    fn shade_batch(&self, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
        shade_looks(self.scene(), batch, colors, |_, fragment| self.look(fragment));
    }

    fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
        self.scene().is_surface_present(surface)
    }
}

/// The colours of a batch, with all scattering points worked out together; `look` is told which fragment it is.
#[inline(always)] // for the instructions of its caller
pub(crate) fn shade_looks(
    scene: &Scene,
    batch: &FragmentBatch<'_>,
    colors: &mut [Vec3],
    mut look: impl FnMut(usize, &Fragment<'_>) -> Look,
) {
    let mut queries = Vec::with_capacity(batch.len());
    let mut targets = Vec::with_capacity(batch.len());
    for (index, (fragment, color)) in batch.iter().zip(colors.iter_mut()).enumerate() {
        match look(index, &fragment) {
            Look::Color(found) => *color = found,
            Look::Scattered { query, throughput, added } => {
                queries.push(query);
                targets.push((index as u32, throughput));
                *color = added;
            }
        }
    }
    let mut results = vec![Vec3::ZERO; queries.len()];
    scene.radiance_batch(&queries, &mut results);
    for ((target, throughput), result) in targets.into_iter().zip(results) {
        colors[target as usize] += throughput * result;
    }
}

/// Shades what is seen directly: the first surface of a chain, or the environment. Sources are the scene's triangles.
/// Objects that reflect or refract are black.
#[derive(Clone, Copy, Debug)]
pub struct SceneShader<'a> {
    scene: &'a Scene,
    rays: ViewRays,
}

impl<'a> SceneShader<'a> {
    /// A shader for `scene` seen from `view`.
    pub fn new(scene: &'a Scene, view: &View) -> Self {
        Self { scene, rays: view.rays() }
    }
}

impl LookShader for SceneShader<'_> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    #[inline]
    fn look(&self, fragment: &Fragment<'_>) -> Look {
        let ray = self.rays.ray(fragment.position.x, fragment.position.y);
        let Some(surface) = fragment.chain.first() else {
            return Look::Color(self.scene.background(ray.direction));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        if self.scene.role_of(object).is_specular() {
            return Look::Color(Vec3::ZERO);
        }
        Look::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO)
    }
}
