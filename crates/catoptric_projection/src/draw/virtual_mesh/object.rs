//! An object on a path, whose points are projected.

use super::weld::WeldedObject;
use catoptric_core::math::Aabb;
use catoptric_engine::method::projector::{Projection, Projections, VertexProjector};
use glam::Vec3;
use std::sync::Arc;

/// A path and the objects projected on it.
#[derive(Clone)]
pub struct VirtualObject {
    /// The object's number in the scene.
    pub object: u32,
    /// The object's points and triangles.
    pub welded: Arc<WeldedObject>,
    /// The number of its first triangle in the scene.
    pub first_triangle: u32,
    /// True if its triangles have holes.
    pub alpha_tested: bool,
    /// The path, an index of the projector's.
    pub path: u32,
    /// Appearances with shorter last segments than this are left out: 0, but for the path's last reflector itself.
    ///
    /// The points of a tessellation lie a little off its surface, and would appear where they touch it.
    pub least_segment: f32,
    /// The box around the path's last reflector.
    pub last_reflector: Aabb,
    /// The size of the scene.
    pub scene_size: f32,
}

impl VirtualObject {
    /// The steps of a stage that its mesh takes.
    pub(crate) fn steps(welded: &WeldedObject) -> usize {
        welded.points.len() + welded.triangles.len()
    }

    /// Appends points with all their appearances, but for a few where there are very many; returns how many are left
    /// out.
    pub(super) fn project<P: VertexProjector + ?Sized>(
        &self,
        projector: &P,
        points: &[Vec3],
        found: &mut Projections,
    ) -> u64 {
        let first = found.point_count();
        projector.project_beyond(self.path, self.least_segment, points, found);
        self.retain_distant(first, found);
        let magnification = |one: &Projection| one.image_change[0].cross(one.image_change[1]).length();
        found.keep_largest_from(first, MAX_APPEARANCES, magnification) as u64
    }

    /// Appends a point with the appearance that continues `one`, and perhaps others.
    pub(super) fn follow<P: VertexProjector + ?Sized>(
        &self,
        projector: &P,
        one: &Projection,
        point: Vec3,
        found: &mut Projections,
    ) {
        let first = found.point_count();
        projector.follow(one, point, found);
        self.retain_distant(first, found);
    }

    fn retain_distant(&self, first: usize, found: &mut Projections) {
        if self.least_segment > 0.0 {
            found.retain_from(first, |one| one.last_segment >= self.least_segment);
        }
    }
}

/// The maximum number of appearances of a point on one path that are drawn: those that are magnified most. Bumpy
/// mirrors show points a hundred times, in places of less than a pixel. A bound on time; chosen, not measured.
pub const MAX_APPEARANCES: usize = 8;
