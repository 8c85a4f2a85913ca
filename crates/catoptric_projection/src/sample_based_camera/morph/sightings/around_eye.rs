//! What is known of points from frame to frame (Popescu, Sacks, Mei 2006, section VI: the projections of static
//! vertices are reused with varying weights): their appearances at a node, and those at all nodes around the eye, as
//! long as it stays among these.

use super::cache::PointCache;
use super::cubes::CubeCache;
use super::lookout::Sightings;
use crate::draw::virtual_mesh::SteadyMeshes;

/// What is known at the nodes around an eye.
#[derive(Default)]
pub struct AroundEye {
    /// Points one by one.
    pub(in super::super) points: PointCache<Sightings>,
    /// What is interpolated between.
    pub(in super::super) cubes: CubeCache,
    /// All points of objects.
    pub(in super::super) meshes: SteadyMeshes,
}
