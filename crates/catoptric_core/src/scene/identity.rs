//! The identity of a scene: all that a picture of it depends on, as bytes to be hashed.

use super::{Environment, Scene, Texture};
use std::fmt::Debug;

/// Takes pieces of data one by one; the cuts between them have no meaning.
type Sink<'a> = dyn FnMut(&[u8]) + 'a;

/// Arrays are preceded by their length, so that no two scenes give the same bytes by shifting values between arrays.
fn put_array<T: bytemuck::NoUninit>(sink: &mut Sink<'_>, values: &[T]) {
    sink(&(values.len() as u64).to_le_bytes());
    sink(bytemuck::cast_slice(values));
}

/// Small parts, by how they are printed: numbers are printed with all their digits.
fn put_printed(sink: &mut Sink<'_>, part: &impl Debug) {
    put_array(sink, format!("{part:?}").as_bytes());
}

impl Scene {
    /// Gives a hasher all that light in the scene depends on, but for the objects that are left out: geometry,
    /// materials with their roles, textures, lights, environment, region. Neither names nor cameras.
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
            put_array(sink, self.colors.get(vertices.clone()).unwrap_or_default());
            put_array(sink, self.tangents.get(vertices).unwrap_or_default());
            // Counted from the object's first vertex: omitted vertices before it have no effect.
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
        let has_shadows = self.light_visibility.is_some() && !self.lights.is_empty();
        put_printed(sink, &(&self.lights, has_shadows));
        if let Some(sky) = &self.sky {
            put_printed(sink, &"shadows of the environment");
            if sky.is_scattered() {
                put_printed(sink, &"light between surfaces");
            }
        }
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
        put_printed(sink, &(self.picture.width, self.picture.height));
        put_array(sink, &self.picture.radiance);
        if self.turn() != 0.0 {
            put_printed(sink, &("turned by", self.turn()));
        }
    }
}
