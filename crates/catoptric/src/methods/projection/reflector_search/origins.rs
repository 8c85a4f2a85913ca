//! Where rays come from that arrive at a reflector.

use super::image::Spot;
use crate::methods::projection::virtual_objects::{ReflectorMesh, interpolated};
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
