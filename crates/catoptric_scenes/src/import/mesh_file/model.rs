//! Models of one mesh.

use super::super::files::file_stem;
use catoptric_core::scene::Material;
use catoptric_core::scene::model::{LocalTransform, MeshAsset, Model, Node, Primitive};
use glam::{DQuat, DVec3, Vec3};
use std::collections::HashMap;

/// Edges between triangles whose normals differ by less than 30 degrees are smooth where a file brings no normals.
const SMOOTH_COSINE: f32 = 0.866_025_4;
/// At vertices of more triangles than these every one is flat: comparing all pairs would take too long.
const MAX_COMPARED: usize = 256;
/// The albedo of what has no material.
const PLASTER: f32 = 0.8;

/// A mesh before it becomes a model.
#[derive(Default)]
pub(super) struct Mesh {
    pub(super) positions: Vec<DVec3>,
    /// As many as positions, or unused.
    pub(super) normals: Vec<Vec3>,
    /// Linear; as many as positions, or unused.
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The model of one node, which has the name of the file.
    pub(super) fn into_model(self, name: &str) -> Model {
        let count = self.positions.len();
        let center = far_center(&self.positions);
        let mut primitive = Primitive {
            positions: self.positions.iter().map(|position| (*position - center).as_vec3()).collect(),
            normals: if self.normals.len() == count { self.normals } else { Vec::new() },
            colors: if self.colors.len() == count { self.colors } else { Vec::new() },
            triangles: self.triangles,
            ..Primitive::default()
        };
        let before = primitive.triangles.len();
        let is_finite = |corner: &u32| primitive.positions[*corner as usize].is_finite();
        primitive.triangles.retain(|triangle| triangle.iter().all(is_finite));
        let left_out = before - primitive.triangles.len();
        if primitive.normals.is_empty() {
            smooth(&mut primitive);
        }
        let node_name = file_stem(name).to_owned();
        let mut model = Model { name: name.into(), ..Model::default() };
        model.materials.push(Material::diffuse(&node_name, Vec3::splat(PLASTER)));
        model.nodes.push(Node { name: node_name.clone(), local: place(center), mesh: Some(0), ..Node::default() });
        model.meshes.push(MeshAsset { name: node_name, primitives: vec![primitive], morph_weights: Vec::new() });
        if left_out > 0 {
            model.warnings.push(format!("{left_out} triangles are left out: their corners are no numbers"));
        }
        model
    }
}

/// Gives a primitive normals: at each corner the mean of the triangles at its vertex, by their areas, that lie within
/// [`SMOOTH_COSINE`] of its own. Vertices whose corners have different normals become several.
fn smooth(primitive: &mut Primitive) {
    let (positions, colors) = (&primitive.positions, &primitive.colors);
    let area_normal = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
        (b - a).cross(c - a)
    };
    let normals: Vec<Vec3> = primitive.triangles.iter().map(area_normal).collect();
    let units: Vec<Vec3> = normals.iter().map(|normal| normal.normalize_or_zero()).collect();
    // The triangles at each vertex, one after the other, and where those of a vertex begin.
    let mut begins = vec![0u32; positions.len() + 1];
    primitive.triangles.iter().flatten().for_each(|corner| begins[*corner as usize + 1] += 1);
    for vertex in 0..positions.len() {
        begins[vertex + 1] += begins[vertex];
    }
    let mut ends = begins.clone();
    let mut at_vertices = vec![0u32; primitive.triangles.len() * 3];
    for (index, corner) in
        primitive.triangles.iter().enumerate().flat_map(|(index, t)| t.iter().map(move |c| (index, c)))
    {
        let end = &mut ends[*corner as usize];
        at_vertices[*end as usize] = index as u32;
        *end += 1;
    }
    let mut numbers: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    let mut vertices: Vec<(u32, Vec3)> = Vec::new();
    let triangles = primitive.triangles.iter().enumerate().map(|(index, triangle)| {
        triangle.map(|corner| {
            let around = &at_vertices[begins[corner as usize] as usize..begins[corner as usize + 1] as usize];
            let is_near = |other: &&u32| units[**other as usize].dot(units[index]) >= SMOOTH_COSINE;
            let sum: Vec3 = match around.len() {
                0..=MAX_COMPARED => around.iter().filter(is_near).map(|other| normals[*other as usize]).sum(),
                _ => normals[index],
            };
            let normal = sum.normalize_or(units[index]);
            *numbers.entry((corner, normal.to_array().map(f32::to_bits))).or_insert_with(|| {
                vertices.push((corner, normal));
                vertices.len() as u32 - 1
            })
        })
    });
    let triangles = triangles.collect();
    let of_corner = |corner: u32| colors.get(corner as usize).copied();
    let colors = vertices.iter().filter_map(|(corner, _)| of_corner(*corner)).collect();
    let positions = vertices.iter().map(|(corner, _)| positions[*corner as usize]).collect();
    primitive.normals = vertices.iter().map(|(_, normal)| *normal).collect();
    (primitive.positions, primitive.colors, primitive.triangles) = (positions, colors, triangles);
}

/// The middle of all vertices, whole numbers, if they are far from the origin, where single precision would round them;
/// else zero.
pub(in super::super) fn far_center(positions: &[DVec3]) -> DVec3 {
    /// Vertices are far from an origin that is so many times their extent away.
    const FAR: f64 = 32.0;
    let finite = positions.iter().filter(|position| position.is_finite());
    let (low, high) = finite.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), position| {
        (low.min(*position), high.max(*position))
    });
    let (center, size) = (((low + high) * 0.5).round(), (high - low).length());
    if size > 0.0 && size.is_finite() && center.abs().max_element() > FAR * size { center } else { DVec3::ZERO }
}

/// The pose of a node that moves what lies about the origin to a place.
pub(in super::super) fn place(center: DVec3) -> LocalTransform {
    match center {
        DVec3::ZERO => LocalTransform::default(),
        translation => LocalTransform::Rigid { translation, rotation: DQuat::IDENTITY },
    }
}
