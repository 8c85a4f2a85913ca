//! Which triangles of a mesh are neighbours, and how the mesh is curved at its vertices.

use crate::scene::Scene;
use glam::{DMat3, DQuat, DVec3, Vec3};
use std::collections::HashMap;
use std::ops::Range;

/// No triangle across an edge: a border, a crease, or more than two triangles at one edge.
pub(crate) const NO_NEIGHBOUR: u32 = u32::MAX;

/// Normals of vertices at one place that differ by no more are one normal: texture seams double vertices.
const SAME_NORMAL: f64 = 1e-3;

/// What an object's triangles have in common.
pub(super) struct Topology {
    /// For each vertex of the object the number of its place and normal: equal where the surface is smooth.
    pub(super) groups: Vec<u32>,
    /// For each triangle of the object, the triangle (of the object) across the edge opposite each vertex.
    pub(super) neighbours: Vec<[u32; 3]>,
    /// The shape operator of each group, in world axes: the change of the unit normal with a tangential step.
    pub(super) operators: Vec<DMat3>,
}

impl Topology {
    /// Of the triangles and vertices of one object.
    pub(super) fn new(scene: &Scene, triangles: Range<u32>, vertices: Range<u32>) -> Self {
        let (groups, group_count) = welded(scene, vertices.clone());
        let triangles = &scene.triangles[triangles.start as usize..triangles.end as usize];
        let group_of = |vertex: u32| groups[(vertex - vertices.start) as usize];
        let neighbours = neighbours(triangles, group_of);
        let mut sums = vec![(DMat3::ZERO, 0.0); group_count];
        for &triangle in triangles {
            let positions = triangle.map(|vertex| scene.positions[vertex as usize].as_dvec3());
            let normals = triangle.map(|vertex| scene.normals[vertex as usize].as_dvec3());
            let Some((operator, normal, area)) = face_operator(&positions, &normals) else { continue };
            for (vertex, own_normal) in triangle.into_iter().zip(normals) {
                let Some(own_normal) = own_normal.try_normalize() else { continue };
                // The operator of the face lies in the face's plane: turned into the vertex's tangent plane.
                let turn = DMat3::from_quat(DQuat::from_rotation_arc(normal, own_normal));
                let turned = turn * operator * turn.transpose();
                if turned.is_finite() {
                    let sum = &mut sums[group_of(vertex) as usize];
                    *sum = (sum.0 + turned * area, sum.1 + area);
                }
            }
        }
        let mean = |(sum, weight): (DMat3, f64)| if weight > 0.0 { sum * weight.recip() } else { DMat3::ZERO };
        Self { groups, neighbours, operators: sums.into_iter().map(mean).collect() }
    }

    /// Bytes held.
    pub(super) fn byte_count(&self) -> u64 {
        let bytes = size_of_val(self.groups.as_slice())
            + size_of_val(self.neighbours.as_slice())
            + size_of_val(self.operators.as_slice());
        bytes as u64
    }
}

/// Numbers vertices such that those at one place with one normal have one number.
pub(crate) fn welded(scene: &Scene, vertices: Range<u32>) -> (Vec<u32>, usize) {
    // The last group of each place; groups of one place are chained.
    let mut last_at: HashMap<[u32; 3], u32> = HashMap::with_capacity(vertices.len());
    let mut normals: Vec<(Vec3, u32)> = Vec::new();
    let same2 = (SAME_NORMAL * SAME_NORMAL) as f32;
    let mut group_of = |vertex: u32| {
        // Adding 0 makes one zero of the two.
        let place = (scene.positions[vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
        let normal = scene.normals[vertex as usize];
        let mut group = last_at.get(&place).copied().unwrap_or(NO_NEIGHBOUR);
        while let Some(&(known, before)) = normals.get(group as usize) {
            if known.distance_squared(normal) <= same2 {
                return group;
            }
            group = before;
        }
        let number = normals.len() as u32;
        let before = last_at.insert(place, number).unwrap_or(NO_NEIGHBOUR);
        normals.push((normal, before));
        number
    };
    let groups = vertices.map(&mut group_of).collect();
    (groups, normals.len())
}

/// For each triangle the one across the edge opposite to each corner, where just one shares it.
pub(crate) fn neighbours(triangles: &[[u32; 3]], group_of: impl Fn(u32) -> u32) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (number, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(&group_of);
        if a == b || b == c || c == a {
            continue;
        }
        for (opposite, (p, q)) in [(b, c), (c, a), (a, b)].into_iter().enumerate() {
            edges.push(([p.min(q), p.max(q)], number as u32, opposite as u8));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[NO_NEIGHBOUR; 3]; triangles.len()];
    for same in edges.chunk_by(|one, other| one.0 == other.0) {
        if let [(_, one, side), (_, other, other_side)] = *same {
            neighbours[one as usize][side as usize] = other;
            neighbours[other as usize][other_side as usize] = one;
        }
    }
    neighbours
}

/// The shape operator that fits a triangle's edges and the differences of its normals best (Rusinkiewicz 2004,
/// Estimating curvatures and their derivatives on triangle meshes, section 3.1), in world axes, with the triangle's
/// normal on the outer side and its area. None for triangles without area.
fn face_operator(positions: &[DVec3; 3], normals: &[DVec3; 3]) -> Option<(DMat3, DVec3, f64)> {
    let [a, b, c] = *positions;
    let face = (b - a).cross(c - a);
    let face = if face.dot(normals[0] + normals[1] + normals[2]) < 0.0 { -face } else { face };
    let normal = face.try_normalize()?;
    let across = [(b - a).try_normalize()?, normal.cross((b - a).try_normalize()?)];
    // Each edge (x, y) asks that [x y 0; 0 x y] (e, f, g) be the change of the normal along it.
    let (mut square, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let edge = positions[to] - positions[from];
        let change = normals[to] - normals[from];
        let (x, y) = (edge.dot(across[0]), edge.dot(across[1]));
        for (row, value) in
            [(DVec3::new(x, y, 0.0), change.dot(across[0])), (DVec3::new(0.0, x, y), change.dot(across[1]))]
        {
            square += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
            right += row * value;
        }
    }
    // Scaled to edges of length 1, or small triangles would look singular.
    let size2 = square.x_axis.x + square.z_axis.z;
    let inverse = (square * size2.recip()).try_inverse()?;
    let [e, f, g] = (inverse * right * size2.recip()).to_array();
    let outer = |p: DVec3, q: DVec3| DMat3::from_cols(p * q.x, p * q.y, p * q.z);
    let [u, v] = across;
    let operator = outer(u, u) * e + (outer(u, v) + outer(v, u)) * f + outer(v, v) * g;
    operator.is_finite().then_some((operator, normal, 0.5 * face.length()))
}
