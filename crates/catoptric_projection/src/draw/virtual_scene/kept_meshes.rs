//! Virtual meshes that later frames may use, by path and object.

use crate::draw::virtual_mesh::{MeshQuality, VirtualMesh, WeldedObject};
use std::collections::HashMap;
use std::sync::Arc;

/// A path and an object on it, both by their numbers.
pub(super) type PathObject = (u32, u32);

/// The allowance and work of a mesh's first version, before there was work left to make it again.
#[derive(Clone, Copy)]
pub(super) struct FirstMesh {
    pub(super) allowed: u64,
    pub(super) work: u64,
    pub(super) needed: Option<u64>,
    /// Points that were projected.
    points: u64,
    /// True if the mesh is coarser than asked for, or empty.
    pub(super) is_coarse: bool,
}

impl FirstMesh {
    /// The record of a mesh that has just been made.
    pub(super) fn of(mesh: &VirtualMesh) -> Self {
        let (points, is_coarse) = (mesh.points_projected, !mesh.is_whole());
        Self { allowed: mesh.allowed, work: mesh.work, needed: mesh.needed, points, is_coarse }
    }

    /// About the least that would have to be allowed for a whole mesh of so many points, if the first points say it:
    /// they may take a half.
    pub(super) fn expected(&self, points: usize) -> u64 {
        let points = points as u64;
        if self.points == 0 || self.points >= points {
            return self.work;
        }
        (self.work.saturating_mul(points) / self.points).saturating_mul(2)
    }

    /// True if it would be the same with this much work allowed.
    pub(super) fn holds_with(&self, allowed: u64) -> bool {
        allowed == self.allowed || self.needed.is_some_and(|needed| allowed >= needed)
    }
}

/// Virtual meshes by path and object.
pub(super) type KeyedMeshes = HashMap<PathObject, KeptMesh>;

/// A virtual mesh that later frames may use.
pub(super) struct KeptMesh {
    /// The quality that was asked for.
    pub(super) quality: MeshQuality,
    /// The points and triangles that it was made of.
    pub(super) welded: Arc<WeldedObject>,
    pub(super) mesh: VirtualMesh,
    pub(super) first: FirstMesh,
}

/// Counts of the making of meshes.
#[derive(Default)]
pub(super) struct MadeMeshes {
    pub(super) points_projected: u64,
    /// The number of vertices that were evaluated from kept polynomials, and the time for that.
    pub(super) steady_points: u64,
    pub(super) blend_ms: f64,
    /// The number of objects on paths that have no mesh, because there was no work left for it.
    pub(super) left_out: u64,
}

impl MadeMeshes {
    /// Counts a mesh that has just been made.
    pub(super) fn count(&mut self, mesh: &VirtualMesh) {
        self.points_projected += mesh.points_projected;
        self.steady_points += mesh.steady_points;
        self.blend_ms += mesh.blend_ms;
    }
}
