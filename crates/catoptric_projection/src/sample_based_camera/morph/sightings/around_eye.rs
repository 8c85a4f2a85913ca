//! Known appearances of points, kept from frame to frame (Popescu, Sacks, Mei 2006, section VI: the projections of
//! static vertices are reused with varying weights): those at one node, and those at all nodes around the eye, as long
//! as it stays among these.

use super::cache::PointCache;
use super::cubes::CubeCache;
use super::lookout::Sightings;
use crate::draw::virtual_mesh::SteadyMeshes;

/// Known appearances at the nodes around an eye.
#[derive(Default)]
pub struct AroundEye {
    /// Points one by one.
    pub(in super::super) points: PointCache<Sightings>,
    /// Cubes in which appearances are interpolated.
    pub(in super::super) cubes: CubeCache,
    /// The steady parts of objects' virtual meshes.
    pub(in super::super) meshes: SteadyMeshes,
}
