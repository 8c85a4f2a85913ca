//! Origins of the rays that arrive at a reflector.

use crate::find::virtual_objects::{ReflectorMesh, interpolated};
use crate::reflector_search::image::MeshSpot;
use glam::Vec3;

/// Origins of the rays that arrive at a reflector.
pub(in super::super) struct RayOrigins {
    /// The common origin, if there is one.
    pub(in super::super) eye: Option<Vec3>,
    /// Else the origin for each vertex that a ray arrives at; not finite for vertices without one.
    pub(in super::super) origins: Vec<Vec3>,
}

impl RayOrigins {
    /// The origin of the ray that arrives at a place of the reflector's mesh.
    #[inline]
    pub(in super::super) fn origin(&self, mesh: &ReflectorMesh, spot: &MeshSpot) -> Vec3 {
        match self.eye {
            Some(eye) => eye,
            None => interpolated(&self.origins, mesh.triangles[spot.triangle as usize], spot.weights),
        }
    }
}
