//! Scenes without virtual geometry: their objects as a list to draw, and a shader for directly visible surfaces.

use super::fragment::{Fragment, FragmentBatch, FragmentShader, LayerSurface};
use super::lists::{DrawList, DrawTriangle};
use catoptric_core::parallel;
use catoptric_core::scene::{PicturePoint, Projection, Ray, Role, Scene, ShadingQueue, SurfaceQuery, View, ViewRays};
use glam::{Vec2, Vec3};

/// Vertices that are transformed at once.
const VERTICES_AT_ONCE: usize = 4096;

/// The triangles of selected objects as a list in layer 0, seen from `view`. `group` gives the group of an object's
/// triangles, or `None` if the object is left out. Sources are the scene's triangles.
///
/// The list is the tessellation's: parts nearer than the near plane are cut off while drawing.
pub fn scene_draw_list(scene: &Scene, view: &View, group: impl Fn(u32) -> Option<u32>) -> DrawList {
    let mut vertices_from = Vec::new();
    let mut triangles = Vec::new();
    let mut vertex_count = 0u32;
    for (index, object) in scene.objects.iter().enumerate() {
        let Some(group) = group(index as u32) else { continue };
        let alpha_tested = scene.is_alpha_tested(index as u32);
        let first = object.vertices.start;
        let is_one_sided = scene.is_one_sided(index as u32);
        for triangle in object.triangles.clone() {
            if is_one_sided && is_seen_from_behind(scene, triangle, view) {
                continue;
            }
            let vertices = scene.triangles[triangle as usize].map(|vertex| vertex - first + vertex_count);
            let patch = patch_of_triangle(scene, triangle);
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

/// Returns true if a view sees a triangle from behind.
pub fn is_seen_from_behind(scene: &Scene, triangle: u32, view: &View) -> bool {
    let corner = scene.positions[scene.triangles[triangle as usize][0] as usize];
    let direction = match view.projection {
        Projection::Perspective { .. } => corner - view.eye(),
        Projection::Orthographic { .. } => -Vec3::from(view.world_from_view.matrix3.z_axis),
    };
    scene.is_met_from_behind(triangle, direction)
}

/// The number of the smooth surface that a triangle of a scene is part of, for [`DrawTriangle::patch`]; 0: none.
#[inline]
pub fn patch_of_triangle(scene: &Scene, triangle: u32) -> u32 {
    let object = scene.triangle_objects[triangle as usize];
    // Reflections and refractions in a mesh may change much between two samples.
    let is_smooth = || !scene.role_of(object).is_specular();
    let of_mesh = || scene.triangle_parts.get(triangle as usize).copied().filter(|_| is_smooth());
    scene.patch_of_object(object).or_else(of_mesh).unwrap_or(0)
}

/// The appearance of a fragment of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShadingRequest {
    /// This.
    Color(Vec3),
    /// Light scattered by a point of a diffuse surface: many such points are worked out together.
    Scattered {
        /// The point.
        query: SurfaceQuery,
        /// The factor on its radiance along the way.
        throughput: Vec3,
        /// The radiance from before it.
        added: Vec3,
    },
}

impl ShadingRequest {
    /// The appearance of a surface (not one that reflects) along a ray.
    #[inline(always)] // for the instructions of its caller
    pub fn of_diffuse(scene: &Scene, surface: &LayerSurface, ray: &Ray, throughput: Vec3, added: Vec3) -> Self {
        let object = scene.triangle_objects[surface.source as usize];
        if scene.objects[object as usize].surface.is_some() {
            let point = scene.drawn_point(surface.source, &surface.barycentrics, ray);
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

/// A shader of a scene's surfaces: it gives the appearance of a fragment, and leaves the scattering of diffuse surfaces
/// to be worked out for many points together. Sources are the scene's triangles.
pub trait LookShader: Sync {
    /// The scene.
    fn scene(&self) -> &Scene;

    /// The appearance of a fragment.
    fn look(&self, fragment: &Fragment<'_>) -> ShadingRequest;

    /// Returns true if the colour of a fragment is found along paths that are followed together:
    /// [`Self::follow_together`].
    fn is_followed(&self, fragment: &Fragment<'_>) -> bool {
        let _ = fragment;
        false
    }

    /// Sets the colours of the fragments of a tile that are followed together, at the indices that stand beside them.
    fn follow_together(&self, fragments: &mut [(u32, Fragment<'_>)], colors: &mut [Vec3]) {
        let _ = (fragments, colors);
    }

    /// Receives every batch before its fragments are looked at: for counting.
    fn begin_batch(&self, batch: &FragmentBatch<'_>) {
        let _ = batch;
    }

    /// The eye's rays, if diffuse surfaces that are seen directly look like what they scatter along them, and need not
    /// be looked at one by one.
    fn eye(&self) -> Option<&ViewRays> {
        None
    }
}

impl<S: LookShader> FragmentShader for S {
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        self.look(fragment).color(self.scene())
    }

    fn shade_batch(&self, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
        shade_batch(self, batch, colors);
    }

    fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
        self.scene().is_surface_present(surface.source, &surface.barycentrics)
    }
}

#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn shade_batch<S: LookShader>(shader: &S, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
    shader.begin_batch(batch);
    let mut followed = Vec::new();
    shade_looks(shader.scene(), shader.eye(), batch, colors, |index, fragment| {
        if shader.is_followed(fragment) {
            followed.push((index as u32, *fragment));
            return ShadingRequest::Color(Vec3::ZERO);
        }
        shader.look(fragment)
    });
    if !followed.is_empty() {
        shader.follow_together(&mut followed, colors);
    }
}

/// The colours of a batch, with all scattering points worked out together; `look` receives the fragment's index. `eye`:
/// see [`LookShader::eye`].
#[inline(always)] // for the instructions of its caller
pub fn shade_looks<'b>(
    scene: &Scene,
    eye: Option<&ViewRays>,
    batch: &FragmentBatch<'b>,
    colors: &mut [Vec3],
    mut look: impl FnMut(usize, &Fragment<'b>) -> ShadingRequest,
) {
    let mut waiting = ShadingQueue::default();
    // Neighbours are mostly parts of one object.
    let mut last = (u32::MAX, false);
    for (index, fragment) in batch.iter().enumerate() {
        if let (Some(eye), [surface]) = (eye, fragment.chain) {
            let object = scene.triangle_objects[surface.source as usize];
            if object != last.0 {
                let material = scene.material_of(object);
                let diffuse = material.role == Role::Diffuse && material.lobes().is_none();
                last = (object, diffuse && scene.objects[object as usize].surface.is_none());
            }
            if last.1 {
                let towards_viewer = -eye.direction(fragment.position.x, fragment.position.y);
                let (triangle, barycentrics) = (surface.source, surface.barycentrics);
                let query = SurfaceQuery { triangle, barycentrics, towards_viewer };
                colors[index] = Vec3::ZERO;
                waiting.push(scene, query, index as u32, Vec3::ONE, colors);
                continue;
            }
        }
        match look(index, &fragment) {
            ShadingRequest::Color(found) => colors[index] = found,
            ShadingRequest::Scattered { query, throughput, added } => {
                colors[index] = added;
                waiting.push(scene, query, index as u32, throughput, colors);
            }
        }
    }
    waiting.shade(scene, colors);
}

/// Shades directly visible surfaces: the first surface of a chain, or the environment. Sources are the scene's
/// triangles. Objects that reflect or refract are black.
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
    fn look(&self, fragment: &Fragment<'_>) -> ShadingRequest {
        let ray = self.rays.ray(fragment.position.x, fragment.position.y);
        let Some(surface) = fragment.chain.first() else {
            return ShadingRequest::Color(self.scene.background(ray.direction));
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        if self.scene.role_of(object).is_specular() {
            return ShadingRequest::Color(Vec3::ZERO);
        }
        ShadingRequest::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO)
    }

    fn eye(&self) -> Option<&ViewRays> {
        Some(&self.rays)
    }
}
