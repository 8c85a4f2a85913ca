//! What tells one scene from another: all that a picture of it depends on, as bytes to be hashed.

use super::{Environment, Scene, Texture};
use std::fmt::Debug;

/// Takes pieces of data one by one; where they are cut tells nothing.
type Sink<'a> = dyn FnMut(&[u8]) + 'a;

/// Arrays are preceded by their length, so that no two scenes give the same bytes by shifting what belongs where.
fn put_array<T: bytemuck::NoUninit>(sink: &mut Sink<'_>, values: &[T]) {
    sink(&(values.len() as u64).to_le_bytes());
    sink(bytemuck::cast_slice(values));
}

/// Small parts, by how they are printed: numbers are printed with all their digits.
fn put_printed(sink: &mut Sink<'_>, part: &impl Debug) {
    put_array(sink, format!("{part:?}").as_bytes());
}

impl Scene {
    /// Gives a hasher all that light in the scene depends on, but for the objects that are left out: geometry, materials with
    /// their roles, textures, lights, environment, region. Neither names nor cameras.
    ///
    /// The same scene gives the same bytes on machines of the same byte order, whatever file it came from.
    pub fn write_identity(&self, left_out: impl Fn(u32) -> bool, sink: &mut dyn FnMut(&[u8])) {
        for (number, object) in self.objects.iter().enumerate() {
            if left_out(number as u32) {
                continue;
            }
            let vertices = object.vertices.start as usize..object.vertices.end as usize;
            put_array(sink, &self.positions[vertices.clone()]);
            put_array(sink, &self.normals[vertices.clone()]);
            put_array(sink, bytemuck::cast_slice::<_, f32>(self.uvs[vertices.clone()].as_flattened()));
            put_array(sink, self.colors.get(vertices).unwrap_or_default());
            // From the object's first vertex: what is left out before it does not count.
            let first = object.vertices.start;
            let triangles = &self.triangles[object.triangles.start as usize..object.triangles.end as usize];
            let triangles: Vec<[u32; 3]> =
                triangles.iter().map(|corners| corners.map(|corner| corner.wrapping_sub(first))).collect();
            put_array(sink, &triangles);
            put_printed(sink, &(&object.surface, object.inside, object.material));
        }
        for material in &self.materials {
            put_printed(sink, &super::Material { name: String::new(), ..material.clone() });
        }
        for texture in &self.textures {
            texture.write_identity(sink);
        }
        put_printed(sink, &self.lights);
        match &self.environment {
            Some(environment) => environment.write_identity(sink),
            None => put_printed(sink, &"no environment"),
        }
        put_printed(sink, &self.region);
    }
}

impl Texture {
    fn write_identity(&self, sink: &mut Sink<'_>) {
        put_printed(sink, &(self.sampler, &self.levels));
        put_array(sink, &self.texels);
    }
}

impl Environment {
    fn write_identity(&self, sink: &mut Sink<'_>) {
        put_printed(sink, &(self.width, self.height));
        put_array(sink, &self.radiance);
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::{PoseOptions, Scene, builtin};

    fn scene(name: &str) -> Scene {
        builtin::parse(name).unwrap().pose(&PoseOptions::default()).unwrap()
    }

    fn identity(scene: &Scene, left_out: impl Fn(u32) -> bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        scene.write_identity(left_out, &mut |piece| bytes.extend_from_slice(piece));
        bytes
    }

    #[test]
    fn the_same_scene_has_the_same_identity() {
        let one = identity(&scene("sphere_room"), |_| false);
        assert_eq!(one, identity(&scene("sphere_room"), |_| false));
        let mut renamed = scene("sphere_room");
        renamed.name = "another".into();
        renamed.cameras.clear();
        assert_eq!(one, identity(&renamed, |_| false));
    }

    /// One change of each kind of thing.
    #[test]
    fn whatever_is_seen_counts() {
        type Change = fn(&mut Scene);
        let changes: [(&str, Change); 10] = [
            ("a position", |scene| scene.positions[7].x += 1e-6),
            ("a normal", |scene| scene.normals[7] = -scene.normals[7]),
            ("texture coordinates", |scene| scene.uvs[7][0].x += 1e-3),
            ("a triangle", |scene| scene.triangles[3].swap(0, 1)),
            ("a colour", |scene| scene.materials[1].base_color.x *= 0.999_999),
            ("a role", |scene| scene.materials[0].role = crate::scene::Role::Lens),
            ("colours of vertices", |scene| scene.colors = vec![[1.0; 4]; scene.positions.len()]),
            ("the region", |scene| scene.region = Some(scene.bounds)),
            ("an object", |scene| drop(scene.objects.pop())),
            ("the environment", |scene| {
                scene.environment = Some(crate::scene::Environment::new("", 2, 1, vec![[1.0; 3]; 2]).into());
            }),
        ];
        let before = identity(&scene("sphere_room"), |_| false);
        for (what, change) in changes {
            let mut changed = scene("sphere_room");
            change(&mut changed);
            assert_ne!(before, identity(&changed, |_| false), "{what}");
        }
    }

    /// A reflector that moves may be left out.
    #[test]
    fn what_is_left_out_does_not_count() {
        let mut moved = scene("sphere_room");
        let ball = moved.specular_objects()[0];
        let left_out = |object| object == ball;
        let before = identity(&scene("sphere_room"), left_out);
        let object = moved.objects[ball as usize].clone();
        for vertex in object.vertices {
            moved.positions[vertex as usize].y += 0.1;
        }
        assert_eq!(before, identity(&moved, left_out));
        assert_ne!(identity(&scene("sphere_room"), |_| false), identity(&moved, |_| false));
    }
}
