//! A point to be shaded, and the general way to do so.

use super::super::super::Scene;
use super::super::shade::Barycentrics;
use glam::Vec3;

/// A point to be shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceQuery {
    /// The triangle of the scene.
    pub triangle: u32,
    /// The place on it.
    pub barycentrics: Barycentrics,
    /// The direction to the previous point of the path, of any length.
    pub towards_viewer: Vec3,
}

/// The general way, for points with properties too rare for lanes.
#[cold]
pub(super) fn one_by_one(scene: &Scene, query: &SurfaceQuery) -> Vec3 {
    let towards_viewer = query.towards_viewer.normalize_or_zero();
    scene.radiance(&scene.surface_point(query.triangle, &query.barycentrics), towards_viewer)
}
