//! Shapes given by implicit functions.

use super::tessellation::mesh::SurfaceMesh;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::DVec3;

/// The operations of every kind of surface, in its own frame.
pub(super) trait ImplicitShape {
    /// The smallest and largest corner of a box around the surface.
    fn corners(&self) -> [DVec3; 2];

    /// The implicit function to second order.
    fn taylor2(&self, point: DVec3) -> Taylor2;

    /// The implicit function to third order.
    fn taylor3(&self, point: DVec3) -> Taylor3;

    /// A vector along the gradient of the implicit function, of any length.
    fn outwards(&self, point: DVec3) -> DVec3;

    /// The smallest distance between `near` and `far` at which the ray meets the surface.
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64>;

    /// Triangles on the surface: with this share of the finest mesh's cells along each direction.
    fn tessellate(&self, fineness: f64) -> SurfaceMesh;

    /// Returns true if a ray that leaves the outer side never meets the surface again.
    fn is_convex(&self) -> bool {
        false
    }
}
