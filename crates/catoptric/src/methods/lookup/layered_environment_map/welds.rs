//! Vertices that are the same, or at the same place.

use crate::scene::Scene;
use glam::Vec3;
use std::collections::HashMap;

/// What a vertex is the same as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Weld {
    /// The same for vertices of one object at one place, with one normal: the same rays leave there.
    pub(super) vertex: u32,
    /// The same for vertices at one place.
    pub(super) place: u32,
}

/// The vertices of a scene's reflectors and lenses.
#[derive(Clone, Debug, Default)]
pub(super) struct Welds {
    /// Of every vertex of the scene.
    welds: Vec<Weld>,
    /// How many places there are.
    pub(super) places: u32,
}

impl Welds {
    pub(super) fn new(scene: &Scene) -> Self {
        let mut welds = vec![Weld::default(); scene.positions.len()];
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        let mut vertices: HashMap<(u32, [u32; 3], u32), u32> = HashMap::new();
        // Adding 0 makes the two zeros one.
        let bits = |vector: Vec3| (vector + Vec3::ZERO).to_array().map(f32::to_bits);
        for object in scene.specular_objects() {
            for vertex in scene.objects[object as usize].vertices.clone() {
                let index = vertex as usize;
                let next = places.len() as u32;
                let place = *places.entry(bits(scene.positions[index])).or_insert(next);
                let next = vertices.len() as u32;
                let vertex = *vertices.entry((place, bits(scene.normals[index]), object)).or_insert(next);
                welds[index] = Weld { vertex, place };
            }
        }
        Self { welds, places: places.len() as u32 }
    }

    pub(super) fn of(&self, vertex: u32) -> Weld {
        self.welds[vertex as usize]
    }
}
