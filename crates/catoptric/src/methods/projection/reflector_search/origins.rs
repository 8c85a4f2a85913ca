//! Where rays come from, also a little beyond where that is known.

use super::image::Spot;
use crate::methods::projection::virtual_objects::{ReflectorMesh, interpolated, weights_of};
use glam::Vec3;

/// Where rays come from.
pub(super) struct Source {
    /// One point, if that is where all of them do.
    pub(super) eye: Option<Vec3>,
    /// Else by the vertices that they arrive at; not finite where none does.
    pub(super) origins: Vec<Vec3>,
}

impl Source {
    /// Where the ray comes from that arrives at a place of the reflector's mesh.
    #[inline]
    pub(super) fn origin(&self, mesh: &ReflectorMesh, spot: &Spot) -> Vec3 {
        match self.eye {
            Some(eye) => eye,
            None => interpolated(&self.origins, mesh.triangles[spot.triangle as usize], spot.weights),
        }
    }
}

/// Where rays come from, vertex by vertex, led on to those vertices without rays that lie across an edge from a triangle
/// with rays.
///
/// Rays of the bounce before do not arrive at vertices that lie on its surface, as along the sharp rim of a lens, though
/// they do arrive everywhere near: without this a ring of triangles along the rim would show nothing.
pub(super) fn extended(mesh: &ReflectorMesh, origins: &[Vec3]) -> Vec<Vec3> {
    let is_known = |vertex: &u32| origins[*vertex as usize].is_finite();
    let mut led = vec![(Vec3::ZERO, 0.0_f32); origins.len()];
    for (triangle, neighbours) in mesh.triangles.iter().zip(&mesh.neighbours) {
        let corner = match triangle.each_ref().map(is_known) {
            [false, true, true] => 0,
            [true, false, true] => 1,
            [true, true, false] => 2,
            _ => continue,
        };
        let Some(beside) = mesh.triangles.get(neighbours[corner] as usize) else { continue };
        if !beside.iter().all(is_known) {
            continue;
        }
        let vertex = triangle[corner] as usize;
        let corners = beside.map(|vertex| mesh.positions[vertex as usize]);
        let (sum, count) = &mut led[vertex];
        *sum += interpolated(origins, *beside, weights_of(corners, mesh.positions[vertex]));
        *count += 1.0;
    }
    let led_on = |(origin, (sum, count)): (&Vec3, (Vec3, f32))| {
        // Without a triangle beside it this is not a number.
        if origin.is_finite() { *origin } else { sum / count }
    };
    origins.iter().zip(led).map(led_on).collect()
}
