//! Scenes as they stand: their objects as a list to draw, and a shader for what is seen directly.

use super::{DrawList, DrawTriangle, Fragment, FragmentBatch, FragmentShader, LayerSurface};
use crate::parallel;
use crate::scene::shade::SurfacePoint;
use crate::scene::{AlphaMode, PicturePoint, Projection, Scene, View};
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
        let alpha_tested = scene.material_of(index as u32).alpha_mode != AlphaMode::Opaque;
        let first = object.vertices.start;
        for triangle in object.triangles.clone() {
            let vertices = scene.triangles[triangle as usize].map(|vertex| vertex - first + vertex_count);
            triangles.push(DrawTriangle { vertices, source: triangle, group, alpha_tested });
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
    DrawList { vertices, triangles, layer: 0, stencil: None }
}

/// Shades what is seen directly: the first surface of a chain, or the environment. Sources are the scene's triangles.
/// Objects that reflect or refract are black.
#[derive(Clone, Copy, Debug)]
pub struct SceneShader<'a> {
    scene: &'a Scene,
    view: &'a View,
    perspective: bool,
}

impl<'a> SceneShader<'a> {
    /// A shader for `scene` seen from `view`.
    pub fn new(scene: &'a Scene, view: &'a View) -> Self {
        Self { scene, view, perspective: matches!(view.projection, Projection::Perspective { .. }) }
    }

    /// The point of the scene that a surface shows at a picture position, and the unit direction to the viewer.
    ///
    /// On an analytic surface it is where the position's ray meets the surface itself; beside its silhouette, where
    /// the ray misses, the point of the tessellation.
    #[inline(always)]
    pub fn point(&self, surface: &LayerSurface, position: Vec2) -> (SurfacePoint, Vec3) {
        let mut point = self.scene.surface_point(surface.source, &surface.barycentrics);
        let exact = &self.scene.objects[point.object as usize].surface;
        let ray = (exact.is_some() || !self.perspective).then(|| self.view.ray(position.x, position.y));
        if let (Some(exact), Some(ray)) = (exact, ray) {
            if let Some(hit) = exact.intersect(ray.origin, ray.direction, self.view.near, f32::INFINITY) {
                point.position = hit.position;
                point.normal = hit.normal;
                point.geometric_normal = hit.normal;
            }
        }
        let towards_viewer = match ray {
            Some(ray) => -ray.direction,
            None => (self.view.eye() - point.position).try_normalize().unwrap_or(Vec3::Z),
        };
        (point, towards_viewer)
    }
}

impl FragmentShader for SceneShader<'_> {
    #[inline(always)]
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        let Some(surface) = fragment.chain.first() else {
            if self.scene.environment.is_none() {
                return Vec3::ZERO;
            }
            return self.scene.background(self.view.ray(fragment.position.x, fragment.position.y).direction);
        };
        let object = self.scene.triangle_objects[surface.source as usize];
        if self.scene.role_of(object).is_specular() {
            return Vec3::ZERO;
        }
        let (point, towards_viewer) = self.point(surface, fragment.position);
        self.scene.radiance(&point, towards_viewer)
    }

    fn shade_batch(&self, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
        shade_all(self, batch, colors);
    }

    fn is_present(&self, surface: &LayerSurface, position: Vec2) -> bool {
        let (point, _) = self.point(surface, position);
        self.scene.is_present(self.scene.material_of(point.object), &point)
    }
}

#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn shade_all(shader: &SceneShader<'_>, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
    for (fragment, color) in batch.iter().zip(colors) {
        *color = shader.shade(&fragment);
    }
}
