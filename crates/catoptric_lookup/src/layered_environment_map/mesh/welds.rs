//! Vertices that are the same, or at the same place.

use catoptric_core::scene::Scene;
use catoptric_core::surface::mesh::weld::{NormalRule, Welder};

/// Key under which vertices are welded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Weld {
    /// A number that all vertices of one object at one place with one normal have in common: the same rays leave there.
    pub(crate) vertex: u32,
    /// A number that all vertices at one place have in common.
    pub(crate) place: u32,
}

/// The vertices of a scene's reflectors and lenses.
#[derive(Clone, Debug, Default)]
pub struct Welds {
    /// Number of the welded vertex of every vertex of the scene.
    welds: Vec<Weld>,
    /// The number of places.
    pub(crate) places: u32,
}

impl Welds {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut welds = vec![Weld::default(); scene.positions.len()];
        let (mut places, mut vertices_before) = (Welder::new(NormalRule::Any, 0.0), 0);
        for object in scene.specular_objects() {
            let mut vertices = Welder::new(NormalRule::Equal, 0.0);
            for vertex in scene.objects[object as usize].vertices.clone() {
                let (position, normal) = (scene.positions[vertex as usize], scene.normals[vertex as usize]);
                let place = places.number(position, normal);
                welds[vertex as usize] = Weld { vertex: vertices_before + vertices.number(position, normal), place };
            }
            vertices_before += vertices.count();
        }
        Self { welds, places: places.count() }
    }

    pub(crate) fn of(&self, vertex: u32) -> Weld {
        self.welds[vertex as usize]
    }
}
