//! Neighbours of a mesh's triangles, and its curvature at the vertices.

use catoptric_core::scene::Scene;
use catoptric_core::surface::mesh::adjacency::neighbours;
use catoptric_core::surface::mesh::convexity::MeshShape;
use catoptric_core::surface::mesh::weld::{NormalRule, WeldedVertices, weld_distance};
use glam::{DMat3, DQuat, DVec3};
use std::ops::Range;

/// Normals of vertices at one place that differ by no more are one normal: texture seams double vertices.
const SAME_NORMAL: NormalRule = NormalRule::Within(1e-3);

/// Data shared by an object's triangles.
pub(super) struct Topology {
    /// For each vertex of the object the number of its place and normal: equal where the surface is smooth.
    pub(super) groups: Vec<u32>,
    /// For each triangle of the object, the triangle (of the object) across the edge opposite each vertex.
    pub(super) neighbours: Vec<[u32; 3]>,
    /// True if it is closed and convex: rays that leave its outer side never come back.
    pub(super) convex: bool,
    /// The shape operator of each group, in world axes: the change of the unit normal with a tangential step.
    pub(super) operators: Vec<DMat3>,
}

impl Topology {
    /// The topology of one object's triangles and vertices.
    pub(super) fn new(scene: &Scene, triangles: Range<u32>, vertices: Range<u32>) -> Self {
        let WeldedVertices { numbers: groups, firsts } = welded_vertices(scene, triangles.clone(), vertices.clone());
        let triangles = &scene.triangles[triangles.start as usize..triangles.end as usize];
        let group_of = |vertex: u32| groups[(vertex - vertices.start) as usize];
        let neighbours = neighbours(triangles, group_of);
        let mut sums = vec![(DMat3::ZERO, 0.0); firsts.len()];
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
        // Equal neighbours need equal normals: a cube, which is convex too, has creases where neighbours end.
        let (positions, normals) = (&scene.positions, &scene.normals);
        let convex = MeshShape { positions, normals, triangles, neighbours: &neighbours }.is_convex();
        let mean = |(sum, weight): (DMat3, f64)| if weight > 0.0 { sum * weight.recip() } else { DMat3::ZERO };
        Self { groups, neighbours, convex, operators: sums.into_iter().map(mean).collect() }
    }

    /// Bytes held.
    pub(super) fn byte_count(&self) -> u64 {
        let bytes = size_of_val(self.groups.as_slice())
            + size_of_val(self.neighbours.as_slice())
            + size_of_val(self.operators.as_slice());
        bytes as u64
    }
}

/// Numbers the vertices of an object such that those at one place with one normal have one number. Places no further
/// apart than a small share of the object's size are one ([`weld_distance`]).
pub fn welded_vertices(scene: &Scene, triangles: Range<u32>, vertices: Range<u32>) -> WeldedVertices {
    let vertices = vertices.start as usize..vertices.end as usize;
    let own = &scene.triangles[triangles.start as usize..triangles.end as usize];
    let corners = own.iter().map(|triangle| triangle.map(|vertex| scene.positions[vertex as usize]));
    let (positions, normals) = (&scene.positions[vertices.clone()], &scene.normals[vertices]);
    WeldedVertices::new(positions, normals, SAME_NORMAL, weld_distance(corners))
}

/// The shape operator that fits a triangle's edges and the differences of its normals best (Rusinkiewicz 2004,
/// Estimating curvatures and their derivatives on triangle meshes, section 3.1), in world axes, with the triangle's
/// normal on the outer side and its area. Returns `None` for triangles without area.
fn face_operator(positions: &[DVec3; 3], normals: &[DVec3; 3]) -> Option<(DMat3, DVec3, f64)> {
    let [a, b, c] = *positions;
    let face = (b - a).cross(c - a);
    let face = if face.dot(normals[0] + normals[1] + normals[2]) < 0.0 { -face } else { face };
    let normal = face.try_normalize()?;
    let across = [(b - a).try_normalize()?, normal.cross((b - a).try_normalize()?)];
    // Each edge (x, y) demands that [x y 0; 0 x y] (e, f, g) is the change of the normal along it.
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
