//! Tessellations: shared helpers, and grids over parameters.

use crate::math::portable::PortableMath;
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::TAU;

/// A tessellation of a surface.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMesh {
    /// Points on the surface.
    pub positions: Vec<Vec3>,
    /// Exact outer unit normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl SurfaceMesh {
    /// Adds a triangle, unless two of its corners are the same point.
    pub(in super::super) fn push_triangle(&mut self, triangle: [u32; 3]) {
        let [a, b, c] = triangle.map(|vertex| self.positions[vertex as usize]);
        if a != b && b != c && c != a {
            self.triangles.push(triangle);
        }
    }

    /// Joins a grid of vertices (rows of `columns + 1`) by triangles; the outer side is where columns run to the right
    /// when rows run upwards.
    pub(in super::super) fn join_grid(&mut self, rows: u32, columns: u32) {
        let index = |row: u32, column: u32| row * (columns + 1) + column;
        for row in 0..rows {
            for column in 0..columns {
                let (a, b) = (index(row, column), index(row, column + 1));
                let (c, d) = (index(row + 1, column + 1), index(row + 1, column));
                self.push_triangle([a, b, c]);
                self.push_triangle([a, c, d]);
            }
        }
    }
}

/// Cells along a direction: a share of those of the finest mesh, but not too few.
pub(in super::super) fn cells(finest: u32, fineness: f64) -> u32 {
    ((f64::from(finest) * fineness).round() as u32).clamp(finest.min(8), finest)
}

/// A sphere of rings (pole to pole along y) and segments, with exact normals.
pub fn sphere_mesh(radius: f32, rings: u32, segments: u32) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for ring in 0..=rings {
        let v = ring as f32 / rings as f32;
        let (sin_polar, cos_polar) = (v * std::f32::consts::PI).sine_cosine();
        for segment in 0..=segments {
            let u = segment as f32 / segments as f32;
            // The seam's two columns of vertices must be the same points, bit for bit.
            let (sin, cos) = ((segment % segments) as f32 / segments as f32 * std::f32::consts::TAU).sine_cosine();
            let sin_polar = if ring == 0 || ring == rings { 0.0 } else { sin_polar };
            let normal = Vec3::new(sin_polar * cos, cos_polar, sin_polar * sin).normalize();
            mesh.positions.push(normal * radius);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    let index = |ring: u32, segment: u32| ring * (segments + 1) + segment;
    for ring in 0..rings {
        for segment in 0..segments {
            let [a, b, c, d] = [
                index(ring, segment),
                index(ring, segment + 1),
                index(ring + 1, segment + 1),
                index(ring + 1, segment),
            ];
            if ring > 0 {
                mesh.triangles.push([a, b, c]);
            }
            if ring + 1 < rings {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

/// A point of the profile of a surface of revolution about y.
pub(in super::super) struct ProfilePoint {
    pub(in super::super) radius: f64,
    pub(in super::super) height: f64,
    /// Direction of the profile (radius, height) here; the outer side is to its right.
    pub(in super::super) direction: [f64; 2],
}

/// The surface that a profile sweeps out about the y axis, in `segments` steps.
pub(in super::super) fn revolved(profile: &[ProfilePoint], segments: u32) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let rows = profile.len().saturating_sub(1) as u32;
    for (row, point) in profile.iter().enumerate() {
        for column in 0..=segments {
            // The seam's two columns of vertices must be the same points, bit for bit. Columns run clockwise from
            // above: to the right, seen from outside.
            let angle = ((segments - column) % segments) as f64 * (TAU / segments as f64);
            let (sin, cos) = angle.sine_cosine();
            let [along_radius, along_height] = point.direction;
            let normal = DVec3::new(along_height * cos, -along_radius, along_height * sin);
            mesh.positions.push(Vec3::new(
                (point.radius * cos) as f32,
                point.height as f32,
                (point.radius * sin) as f32,
            ));
            mesh.normals.push(normal.normalize_or(DVec3::Y).as_vec3());
            mesh.uvs.push(Vec2::new(column as f32 / segments as f32, 1.0 - row as f32 / rows.max(1) as f32));
        }
    }
    mesh.join_grid(rows, segments);
    mesh
}
