//! Error of a reflector's triangles against its surface.

use crate::find::virtual_objects::piece::{interpolated, weights_of};
use catoptric_core::parallel;
use catoptric_core::surface::mesh::convexity::MeshShape;

/// The error of a triangle's interpolated normals, as a share of their error where they are extrapolated to the corner
/// of a neighbour: an eighth for parabolas, and as much again for their slopes at the triangle's border.
const SHARE: f32 = 0.25;

/// The largest angle, for every triangle, between the normals that are interpolated in it and those of the surface, in
/// radians.
///
/// Estimated by the second difference: the amount by which its normals, extrapolated, miss those of its neighbours.
/// Spheres, whose normals are linear in the place, have none.
pub fn normal_errors(mesh: MeshShape<'_>) -> Vec<f32> {
    parallel::map_collect(mesh.triangles.len(), |index| {
        let triangle = mesh.triangles[index];
        let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let missed = |neighbour: &u32| {
            let beside = mesh.triangles.get(*neighbour as usize)?;
            let apart = *beside.iter().find(|vertex| !triangle.contains(vertex))? as usize;
            let led_on = interpolated(mesh.normals, triangle, weights_of(corners, mesh.positions[apart]));
            Some(led_on.try_normalize()?.distance(mesh.normals[apart]))
        };
        // Without slopes, as at the end of a strip of triangles without an area, nothing is known to be off.
        SHARE * mesh.neighbours[index].iter().filter_map(missed).fold(0.0, f32::max)
    })
}
