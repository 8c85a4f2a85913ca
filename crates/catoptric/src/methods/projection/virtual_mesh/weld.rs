//! Objects with each point once.

use crate::scene::{Object, Scene};
use glam::Vec3;
use std::collections::HashMap;

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
        let mut welded = Self::default();
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        let first = object.vertices.start;
        let mut places = Vec::with_capacity(object.vertices.len());
        for vertex in object.vertices.clone() {
            let position = scene.positions[vertex as usize];
            // Adding 0 makes the two zeros one.
            let key = (position + Vec3::ZERO).to_array().map(f32::to_bits);
            let place = *known.entry(key).or_insert_with(|| {
                welded.points.push(position);
                welded.points.len() as u32 - 1
            });
            places.push(place);
        }
        let triangles = object.triangles.clone();
        welded.triangles =
            triangles.map(|t| scene.triangles[t as usize].map(|v| places[(v - first) as usize])).collect();
        welded
    }
}
