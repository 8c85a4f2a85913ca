//! The input of the fit of cameras.

use crate::sample_based_camera::rays::grid_ray::GridRay;
use crate::sample_based_camera::rays::path_rays::DensePathRays;
use crate::sample_based_camera::rays::sampler::RaySampler;
use crate::sample_based_camera::settings::CameraKind;
use catoptric_core::math::Aabb;
use catoptric_core::scene::PreciseView;

/// Beams are widest across which their rays are so at this share of the scene's size. Chosen, not measured.
pub(in super::super) const TYPICAL_SHARE: f64 = 0.25;

/// A fit is tried on this many rays first, whatever the size of the subset: 12 a term of a bundle's highest degree.
/// Chosen, not measured.
pub(in super::super) const MAX_FITTED: usize = 120;

/// Subsets with more rays are worked on by another thread. A size for threads; chosen, not measured.
pub(in super::super) const PARALLEL_RAYS: usize = 600;

/// Rays are followed at least this share of the scene's size. Chosen, not measured.
const MIN_HEAD: f64 = 0.02;

/// Input of the fit of cameras: the rays of a path, seen in a view, in a scene's box, within an accuracy.
pub(in super::super) struct CameraBuilder<'a> {
    pub(in super::super) group: &'a DensePathRays,
    pub(in super::super) view: &'a PreciseView,
    pub(in super::super) bounds: Aabb,
    /// Tracer of rays between those of the map.
    pub(in super::super) sampler: &'a RaySampler<'a>,
    pub(in super::super) demand: CameraDemand,
}

/// Demands on cameras.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct CameraDemand {
    pub(in super::super) camera: CameraKind,
    /// The greatest error, in pixels, with which cameras see the points of their rays.
    pub(in super::super) accuracy_px: f64,
    /// Pinholes: no split shares out more than this many times its rays.
    pub(in super::super) max_shared: f32,
    /// The least spacing of rays that are traced between those of the map where these are too few.
    pub(in super::super) finest_ray_px: f32,
    /// About so many of them for each ray of the map, and no more; set for each map.
    pub(in super::super) traced_a_ray: u64,
    /// True if no rays are traced between: something else draws what they would show.
    pub(in super::super) leaves_out: bool,
}

/// Rays that were added to a path's, with their pieces.
#[derive(Debug, Default)]
pub(in super::super) struct Added {
    pub(in super::super) rays: Vec<(GridRay, u32)>,
    /// Rays traced to find them.
    pub(in super::super) traced: u64,
}

impl CameraBuilder<'_> {
    /// The length of a ray until it leaves the scene's box, and at least a little: at its very tail nothing can be
    /// tested.
    pub(in super::super) fn head(&self, ray: &GridRay) -> f64 {
        let (tail, direction) = (ray.tail, ray.direction);
        let mut exit = f64::INFINITY;
        for axis in 0..3 {
            let limit = if direction[axis] > 0.0 { self.bounds.max[axis] } else { self.bounds.min[axis] };
            let distance = (f64::from(limit) - tail[axis]) / direction[axis];
            if distance.is_finite() {
                exit = exit.min(distance.max(0.0));
            }
        }
        let size = f64::from(self.bounds.diagonal());
        if exit.is_finite() { exit.max(MIN_HEAD * size) } else { size }
    }

    /// The numbers of the rays of each piece.
    pub(in super::super) fn pieces(&self) -> Vec<Vec<u32>> {
        let mut pieces = vec![Vec::new(); self.group.piece_count as usize];
        for (ray, &piece) in self.group.piece_of_ray.iter().enumerate() {
            pieces[piece as usize].push(ray as u32);
        }
        pieces
    }
}
