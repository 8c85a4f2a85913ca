//! Properties of a scene's specular objects that limit the triangles that rays from them can meet.

use crate::draw::mesh_neighbours::MeshNeighbours;
use catoptric_core::parallel;
use catoptric_core::scene::Scene;
use catoptric_core::surface::mesh::adjacency::neighbours;
use catoptric_core::surface::mesh::weld::{NormalRule, WeldedVertices, weld_distance};
use catoptric_engine::optics::path::manifold::MeshTopologies;
use glam::Vec3;

/// The shape of a reflector or lens, as far as it limits which of its triangles rays that have left it can meet.
#[derive(Clone, Copy, Debug, Default)]
pub struct ObjectShape {
    /// Rays that leave its outer side never meet it again.
    pub is_convex: bool,
    /// True if the object has an inside: rays that leave its outer side meet its outer side first, if they meet it at
    /// all.
    pub is_closed: bool,
    /// The diagonal of its bounding box.
    pub size: f32,
}

/// The shapes of a scene's objects; those of other objects than reflectors and lenses are the default's.
pub fn object_shapes(scene: &Scene) -> Vec<ObjectShape> {
    SceneShapes::new(scene, &MeshTopologies::of(scene)).objects
}

/// The shapes of a scene's objects; valid until a mesh changes.
#[derive(Clone, Debug, Default)]
pub(super) struct SceneShapes {
    objects: Vec<ObjectShape>,
    /// The triangles beside those of meshes.
    pub(super) neighbours: MeshNeighbours,
    /// A bit for each triangle of the scene: 1 if its winding is opposite to its normals.
    turned: Vec<u64>,
}

impl SceneShapes {
    pub(super) fn new(scene: &Scene, topologies: &MeshTopologies) -> Self {
        let shapes = parallel::map_collect(scene.objects.len(), |object| shape(scene, topologies, object as u32));
        let (objects, neighbours) = shapes.into_iter().unzip();
        let words = scene.triangles.len().div_ceil(64);
        let turned = parallel::map_collect(words, |word| {
            let triangles = scene.triangles[word * 64..].iter().take(64);
            triangles.enumerate().fold(0, |bits, (bit, triangle)| bits | u64::from(is_turned(scene, triangle)) << bit)
        });
        Self { objects, neighbours: MeshNeighbours { objects: neighbours }, turned }
    }

    pub(super) fn of(&self, object: u32) -> ObjectShape {
        self.objects[object as usize]
    }

    #[inline(always)]
    pub(super) fn is_turned(&self, triangle: u32) -> bool {
        self.turned[triangle as usize / 64] >> (triangle % 64) & 1 != 0
    }
}

fn is_turned(scene: &Scene, triangle: &[u32; 3]) -> bool {
    let [a, b, c] = triangle.map(|vertex| scene.positions[vertex as usize]);
    let normals: Vec3 = triangle.iter().map(|vertex| scene.normals[*vertex as usize]).sum();
    (b - a).cross(c - a).dot(normals) < 0.0
}

/// An object's shape, and the neighbours of its triangles if rays meet these.
fn shape(scene: &Scene, topologies: &MeshTopologies, index: u32) -> (ObjectShape, Vec<[u32; 3]>) {
    if !scene.role_of(index).is_specular() {
        return Default::default();
    }
    let object = &scene.objects[index as usize];
    let triangles = &scene.triangles[object.triangles.start as usize..object.triangles.end as usize];
    let vertices = object.vertices.start as usize..object.vertices.end as usize;
    let corners = triangles.iter().map(|triangle| triangle.map(|vertex| scene.positions[vertex as usize]));
    let (positions, normals) = (&scene.positions[vertices.clone()], &scene.normals[vertices.clone()]);
    let welded = WeldedVertices::new(positions, normals, NormalRule::Any, weld_distance(corners));
    let across = neighbours(triangles, |vertex| welded.numbers[vertex as usize - vertices.start]);
    let is_degenerate = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| welded.numbers[vertex as usize - vertices.start]);
        a == b || b == c || c == a
    };
    let has_all = |(triangle, across): (&[u32; 3], &[u32; 3])| {
        is_degenerate(triangle) || across.iter().all(|neighbour| *neighbour != u32::MAX)
    };
    // Through holes of an alpha test rays get to both sides.
    let has_holes = scene.is_alpha_tested(index);
    let is_closed = !has_holes && !triangles.is_empty() && triangles.iter().zip(&across).all(has_all);
    let is_convex = match &object.surface {
        Some(surface) => surface.is_convex() && !object.inside,
        None => topologies.is_convex(index),
    };
    let shape = ObjectShape { is_convex: is_convex && is_closed, is_closed, size: object.bounds.diagonal() };
    // The place on an exact surface does not depend on the triangle.
    (shape, if object.surface.is_some() { Vec::new() } else { across })
}
