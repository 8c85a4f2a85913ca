//! Tangents of normal maps for meshes that bring none: those of MikkTSpace, as glTF 2.0 asks (section 3.7.2.1).

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use catoptric_core::scene::model::Primitive;
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// The tangents of all corners of a primitive's triangles, while they are calculated.
struct Corners<'a> {
    primitive: &'a Primitive,
    channel: usize,
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // MikkTSpace's v runs up, as in the format that it was made for; glTF's runs down.
        let uv = self.primitive.uvs[self.channel][self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        if let Some(tangent) = tangent {
            self.tangents[face][corner] = Vec4::from(tangent.tangent_encoded());
        }
    }
}

/// Gives a primitive tangents if it has none, for a normal map with these texture coordinates. Vertices whose corners
/// have different tangents, at the seams of mirrored textures, become several.
///
/// Without texture coordinates there is nothing to be done.
pub(crate) fn complete(primitive: &mut Primitive, channel: usize) {
    let is_complete = !primitive.tangents.is_empty() || primitive.uvs[channel].is_empty();
    if is_complete || primitive.positions.iter().any(|position| !position.is_finite()) {
        return;
    }
    if primitive.normals.is_empty() {
        // Flat: every triangle has its own three vertices.
        let from: Vec<u32> = primitive.triangles.iter().flatten().copied().collect();
        *primitive = with_vertices(primitive, &from);
        primitive.triangles = (0..from.len() as u32 / 3).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        let corners = primitive.positions.chunks_exact(3);
        let normals = corners.map(|c| (c[1] - c[0]).cross(c[2] - c[0]).try_normalize().unwrap_or(Vec3::Y));
        primitive.normals = normals.flat_map(|normal| [normal; 3]).collect();
        // Offsets of normals are for normals that are not there.
        primitive.morph_targets.iter_mut().for_each(|target| target.normals.clear());
    }
    let tangents = vec![[Vec4::new(1.0, 0.0, 0.0, 1.0); 3]; primitive.triangles.len()];
    let mut corners = Corners { primitive, channel, tangents };
    // Meshes without any triangle of size have no tangents.
    if generate_tangents(&mut corners).is_err() {
        return;
    }
    let Corners { tangents, .. } = corners;
    give(primitive, &tangents);
}

/// Gives vertices the tangents of their corners.
fn give(primitive: &mut Primitive, tangents: &[[Vec4; 3]]) {
    let mut from: Vec<u32> = (0..primitive.positions.len() as u32).collect();
    let mut given: Vec<Option<Vec4>> = vec![None; from.len()];
    let mut more: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut triangles = std::mem::take(&mut primitive.triangles);
    for (corners, tangents) in triangles.iter_mut().zip(tangents) {
        for (vertex, tangent) in corners.iter_mut().zip(tangents) {
            match given[*vertex as usize] {
                None => given[*vertex as usize] = Some(*tangent),
                Some(known) if known == *tangent => {}
                Some(_) => {
                    let original = *vertex;
                    *vertex = *more.entry((original, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
                        from.push(original);
                        given.push(Some(*tangent));
                        from.len() as u32 - 1
                    });
                }
            }
        }
    }
    if !more.is_empty() {
        *primitive = with_vertices(primitive, &from);
    }
    primitive.triangles = triangles;
    primitive.tangents = given.into_iter().map(|tangent| tangent.unwrap_or(Vec4::new(1.0, 0.0, 0.0, 1.0))).collect();
}

/// A primitive with these vertices of another one, without triangles and tangents.
fn with_vertices(primitive: &Primitive, from: &[u32]) -> Primitive {
    fn gathered<T: Copy>(values: &[T], from: &[u32]) -> Vec<T> {
        if values.is_empty() { Vec::new() } else { from.iter().map(|&vertex| values[vertex as usize]).collect() }
    }
    let mut result = Primitive {
        positions: gathered(&primitive.positions, from),
        normals: gathered(&primitive.normals, from),
        uvs: [gathered(&primitive.uvs[0], from), gathered(&primitive.uvs[1], from)],
        colors: gathered(&primitive.colors, from),
        joints: gathered(&primitive.joints, from),
        weights: gathered(&primitive.weights, from),
        morph_targets: primitive.morph_targets.clone(),
        material: primitive.material,
        ..Primitive::default()
    };
    for target in &mut result.morph_targets {
        target.positions = gathered(&target.positions, from);
        target.normals = gathered(&target.normals, from);
        target.tangents.clear();
    }
    result
}
