//! Where rays come from that arrive at a reflector.

use crate::find::virtual_objects::{ReflectorMesh, interpolated};
use crate::reflector_search::image::MeshSpot;
use glam::Vec3;

/// Where rays come from.
pub(in super::super) struct RayOrigins {
    /// One point, if that is where all of them do.
    pub(in super::super) eye: Option<Vec3>,
    /// Else by the vertices that they arrive at; not finite where none does.
    pub(in super::super) origins: Vec<Vec3>,
}

impl RayOrigins {
    /// Where the ray comes from that arrives at a place of the reflector's mesh.
    #[inline]
    pub(in super::super) fn origin(&self, mesh: &ReflectorMesh, spot: &MeshSpot) -> Vec3 {
        match self.eye {
            Some(eye) => eye,
            None => interpolated(&self.origins, mesh.triangles[spot.triangle as usize], spot.weights),
        }
    }
}
