//! Objects that have moved between two moments of a scene.

use super::{SceneTables, surface_records, surfaces, vertex};
use crate::hierarchy::{Hierarchy, MovedPlaces};
use crate::layout::MAX_LIGHTS;
use catoptric::parallel;
use catoptric::scene::{Environment, Object, Scene, Texture};
use std::sync::Arc;

/// Vertices that are worked on at once. A size for threads.
const VERTICES_AT_ONCE: usize = 2048;

/// The objects that differ between two moments of a scene in the places of their vertices, and nothing else but lights.
#[derive(Clone, Debug)]
pub struct Moved {
    /// For every object of the scene, true if it differs.
    pub objects: Vec<bool>,
}

impl Moved {
    /// The objects that have moved; `None` if other things have changed, too, such as which triangles have an extent:
    /// the hierarchy over all of them says which had one.
    pub fn between(before: &Scene, now: &Scene, hierarchy: &Hierarchy) -> Option<Self> {
        let is_same_object = |(a, b): (&Object, &Object)| {
            let surfaces = [a, b].map(|object| object.surface.is_some());
            (a.material, &a.triangles, &a.vertices, a.inside) == (b.material, &b.triangles, &b.vertices, b.inside)
                && surfaces[0] == surfaces[1]
        };
        let is_same = before.objects.len() == now.objects.len()
            && before.objects.iter().zip(&now.objects).all(is_same_object)
            && before.materials == now.materials
            && has_pictures(now, &before.textures, before.environment.as_ref())
            && are_same(before.sky.as_ref(), now.sky.as_ref())
            && before.lights.is_empty() == now.lights.is_empty()
            && now.lights.len() <= MAX_LIGHTS
            && before.light_visibility.is_some() == now.light_visibility.is_some()
            && before.triangles == now.triangles
            && before.triangle_objects == now.triangle_objects
            && before.triangle_parts == now.triangle_parts
            && before.uvs == now.uvs
            && before.colors == now.colors
            && [before.positions.len(), before.normals.len(), before.tangents.len()]
                == [now.positions.len(), now.normals.len(), now.tangents.len()];
        let has_moved = |object: &Object| {
            let range = object.vertices.start as usize..object.vertices.end as usize;
            before.positions.get(range.clone()) != now.positions.get(range.clone())
                || before.normals.get(range.clone()) != now.normals.get(range.clone())
                || before.tangents.get(range.clone()) != now.tangents.get(range)
        };
        let moved = is_same.then(|| Self { objects: now.objects.iter().map(has_moved).collect() })?;
        let keep_extents = moved.of(now).all(|object| hierarchy.has_same_extents(now, object.triangles.clone()));
        keep_extents.then_some(moved)
    }

    /// The objects of the scene that have.
    pub fn of<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = &'a Object> {
        scene.objects.iter().zip(&self.objects).filter_map(|(object, moved)| moved.then_some(object))
    }

    /// True if an object has moved.
    pub fn has(&self, object: u32) -> bool {
        self.objects[object as usize]
    }
}

impl SceneTables {
    /// Brings the tables to another moment of the scene that they are of, `before`, and tells what changes in the
    /// hierarchy.
    pub fn move_to(&mut self, before: &Scene, scene: &Scene, moved: &Moved) -> MovedPlaces {
        let places = self.hierarchy.move_to(scene, |object| moved.has(object));
        self.shapes = surfaces::shapes(scene, Some((before, &self.shapes)));
        (self.surfaces, self.behind_surfaces) = surface_records(scene, &self.shapes, self.follows_lobes);
        for object in moved.of(scene) {
            let first = object.vertices.start as usize;
            let vertices = &mut self.vertices[first..object.vertices.end as usize];
            parallel::for_each_chunk_mut(vertices, VERTICES_AT_ONCE, |chunk, vertices| {
                for (index, known) in (first + chunk * VERTICES_AT_ONCE..).zip(vertices) {
                    *known = vertex(scene, index, known.part);
                }
            });
        }
        places
    }
}

/// True if these are a scene's textures and its environment.
pub(crate) fn has_pictures(scene: &Scene, textures: &[Arc<Texture>], environment: Option<&Arc<Environment>>) -> bool {
    are_same(environment, scene.environment.as_ref())
        && textures.len() == scene.textures.len()
        && textures.iter().zip(&scene.textures).all(|(a, b)| Arc::ptr_eq(a, b))
}

fn are_same<T>(one: Option<&Arc<T>>, other: Option<&Arc<T>>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => Arc::ptr_eq(one, other),
        (one, other) => one.is_none() && other.is_none(),
    }
}
