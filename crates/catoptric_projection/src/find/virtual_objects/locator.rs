//! Reflectors with rays at their vertices, and how points are found in them.

use super::mesh::ReflectorMesh;
use super::rays::{ReflectionPoints, VertexRays};
use catoptric_core::scene::View;
use catoptric_engine::method::Report;
use glam::Vec3;

/// Work for the rays at the vertices of a triangle. Measured on a mesh of ninety thousand.
const WORK_A_TRIANGLE: u64 = 24;

/// Bytes of a locator that take a unit of work to make and fill.
const BYTES_A_UNIT: u64 = 24;

/// A reflector with rays at its vertices.
#[derive(Clone, Copy)]
pub struct Reflector<'a> {
    /// Index among the scene's specular objects; `None` if the mesh is a finer one made for its rays.
    pub index: Option<u32>,
    /// The reflector's mesh.
    pub mesh: &'a ReflectorMesh,
    /// The rays at the vertices.
    pub rays: &'a VertexRays,
    /// The view, where the rays come straight from the eye.
    pub view: Option<&'a View>,
}

/// Finds where points appear in a reflector.
pub trait Locator: Send + Sync {
    /// Appends a batch of scene points with their reflection points, about: none to many each. A point's own do not
    /// depend on the others of the batch.
    fn locate(&self, reflector: &Reflector<'_>, points: &[Vec3], found: &mut ReflectionPoints);

    /// Bytes held.
    fn byte_count(&self) -> u64;

    /// Work that a reflector with its locator takes for each of its triangles, about: for rays at its vertices alone.
    fn work_a_triangle() -> u64 {
        WORK_A_TRIANGLE
    }

    /// Work that it took to make, about: as measured of maps and pictures alike.
    fn build_work(&self) -> u64 {
        self.byte_count() / BYTES_A_UNIT
    }

    /// Adds the counts of searches that were cut short by a limit so far.
    fn add_fallbacks(&self, report: &mut Report);
}
