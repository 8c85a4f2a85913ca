//! Objects with each point once.

use catoptric_core::scene::{Object, Scene};
use catoptric_core::surface::mesh::weld::{NormalRule, WeldedVertices};
use glam::Vec3;

/// An object's triangles over its different points: vertices that differ in normals or texture coordinates alone are
/// projected once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WeldedObject {
    /// The points, in the order of their first vertices.
    pub points: Vec<Vec3>,
    /// Points of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl WeldedObject {
    /// Welds an object of a scene.
    pub fn new(scene: &Scene, object: &Object) -> Self {
        let vertices = object.vertices.start as usize..object.vertices.end as usize;
        let (positions, normals) = (&scene.positions[vertices.clone()], &scene.normals[vertices]);
        let WeldedVertices { numbers, firsts } = WeldedVertices::new(positions, normals, NormalRule::Any, 0.0);
        let own = &scene.triangles[object.triangles.start as usize..object.triangles.end as usize];
        let number_of = |vertex: u32| numbers[(vertex - object.vertices.start) as usize];
        Self {
            points: firsts.into_iter().map(|vertex| positions[vertex as usize]).collect(),
            triangles: own.iter().map(|triangle| triangle.map(number_of)).collect(),
        }
    }
}
