//! The cameras of one path, of either kind.

mod bsp;
mod bundle;
mod bundles;
mod camera_projection;
mod finer;
mod fit;
mod pinhole;

use super::layout::{BundleLeaf, WordReader, WordWriter};
use super::rays::grid_ray::GridRay;
use super::rays::path_rays::DensePathRays;
use super::rays::sampler::RaySampler;
use super::settings::CameraKind;
use crate::find::work;
use bsp::PinholeTrees;
use bundle::{ask, ask_near};
use bundles::BundleTree;
pub(super) use camera_projection::CameraProjection;
use catoptric_core::math::Aabb;
use catoptric_core::scene::PreciseView;
use glam::{DVec3, Vec3};

/// Beams are widest across which their rays are so at this share of the scene's size. Chosen, not measured.
pub(super) const TYPICAL_SHARE: f64 = 0.25;

/// A fit is tried on so many rays first, whatever the size of the subset: 12 a term of a bundle's highest degree.
/// Chosen, not measured.
pub(super) const MAX_FITTED: usize = 120;

/// Subsets with more rays are worked on by another thread. A size for threads; chosen, not measured.
pub(super) const PARALLEL_RAYS: usize = 600;

/// Rays are followed at least this share of the scene's size. Chosen, not measured.
const MIN_HEAD: f64 = 0.02;

/// Work of a camera's answer.
const WORK_A_LEAF: u64 = 4;

/// Input of the fit of cameras: the rays of a path, seen in a view, in a scene's box, within an accuracy.
pub(super) struct CameraBuilder<'a> {
    pub(super) group: &'a DensePathRays,
    pub(super) view: &'a PreciseView,
    pub(super) bounds: Aabb,
    /// Tracer of rays between those of the map.
    pub(super) sampler: &'a RaySampler<'a>,
    pub(super) demand: CameraDemand,
}

/// Demands on cameras.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraDemand {
    pub(super) camera: CameraKind,
    /// They see the points of their rays at most this far from where they belong.
    pub(super) accuracy_px: f64,
    /// Pinholes: no split shares out more than this many times its rays.
    pub(super) max_shared: f32,
    /// Where the rays of the map are too few, others are traced no nearer to each other than this.
    pub(super) finest_ray_px: f32,
    /// About so many of them for each ray of the map, and no more; set for each map.
    pub(super) traced_a_ray: u64,
    /// None are traced: something else draws what is seen there.
    pub(super) leaves_out: bool,
}

/// Rays that were added to a path's, with their pieces.
#[derive(Debug, Default)]
pub(super) struct Added {
    pub(super) rays: Vec<(GridRay, u32)>,
    /// Rays traced to find them.
    pub(super) traced: u64,
}

impl CameraBuilder<'_> {
    /// How far a ray goes until it leaves the scene's box, and at least a little: at its very tail nothing can be
    /// tested.
    pub(super) fn head(&self, ray: &GridRay) -> f64 {
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
    pub(super) fn pieces(&self) -> Vec<Vec<u32>> {
        let mut pieces = vec![Vec::new(); self.group.piece_count as usize];
        for (ray, &piece) in self.group.piece_of_ray.iter().enumerate() {
            pieces[piece as usize].push(ray as u32);
        }
        pieces
    }

    /// The cameras, and the rays that were added to the group's for them.
    pub(super) fn cameras(&self) -> (Cameras, Added) {
        match self.demand.camera {
            CameraKind::RayBundle => {
                let (tree, added) = self.bundle_tree();
                (Cameras::Bundles(tree), added)
            }
            CameraKind::Pinhole => (Cameras::Pinholes(self.pinhole_trees()), Added::default()),
        }
    }
}

/// A camera's projection of a point, and the rays for which it holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraAnswer<'a> {
    pub(super) answer: &'a CameraProjection,
    /// The connected region of rays that it is meant for.
    pub(super) piece: u32,
    /// Places of these rays, in cells; `None` if all of the piece may be meant.
    pub(super) places: Option<[[f32; 2]; 2]>,
    /// Spacing of these rays, in cells.
    pub(super) apart: f32,
    /// True if it is interpolated between rays, and may be off by about that.
    pub(super) interpolates: bool,
}

impl<'a> CameraAnswer<'a> {
    /// The answer of a leaf.
    pub(super) fn of(answer: &'a CameraProjection, leaf: &BundleLeaf) -> Self {
        let places = Some([leaf.low_place, leaf.high_place]);
        Self { answer, piece: leaf.piece, places, apart: leaf.apart, interpolates: leaf.interpolates != 0 }
    }
}

/// A leaf among those of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LeafNumber {
    /// The number of the camera, or of a list of rays.
    pub(super) number: u32,
    /// True if it interpolates between rays.
    pub(super) is_list: bool,
}

/// Scratch space of look-ups.
#[derive(Debug, Default)]
pub(super) struct CameraScratch {
    pub(super) numbers: Vec<u32>,
    pub(super) answers: Vec<CameraProjection>,
}

/// Counts of cameras.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Leaves that are cameras within the accuracy.
    pub(super) leaves: u64,
    /// Leaves that interpolate between rays instead, and the rays in them.
    pub(super) ray_lists: u64,
    pub(super) rays_in_lists: u64,
    /// Blocks of the map that interpolate because there were too many to trace more rays for.
    pub(super) unrefined_blocks: u64,
    /// Lists of rays that would have been split further, had there not been too many splits.
    pub(super) unsplit_lists: u64,
    pub(super) bytes: u64,
}

/// The cameras of one path.
#[derive(Clone, Debug)]
pub(super) enum Cameras {
    Bundles(BundleTree),
    Pinholes(PinholeTrees),
}

impl Cameras {
    /// Corners of the blocks of the map, in cells, that have no cameras.
    pub(super) fn left_out(&self) -> &[[[f32; 2]; 2]] {
        match self {
            Self::Bundles(tree) => tree.left_out(),
            Self::Pinholes(_) => &[],
        }
    }

    /// Calls `found` with all projections of a point by the cameras; not with what lies more than a distance from a
    /// place in the map, if there is a `limit` (in cells).
    pub(super) fn ask(
        &self,
        point: Vec3,
        limit: Option<([f64; 2], f64)>,
        scratch: &mut CameraScratch,
        mut found: impl FnMut(&CameraAnswer<'_>),
    ) {
        let CameraScratch { numbers, answers } = scratch;
        numbers.clear();
        match self {
            Self::Bundles(tree) => {
                tree.leaves_at(point, numbers);
                if let Some((place, most)) = limit {
                    numbers.retain(|&leaf| tree.leaf(leaf).is_some_and(|leaf| leaf.distance_from(place) <= most));
                }
                // What interpolates comes last: it may be off, and cameras have seen most of it.
                numbers.sort_unstable_by_key(|&number| (tree.leaf(number).map_or(1, |leaf| leaf.interpolates), number));
                work::add(WORK_A_LEAF * numbers.len() as u64);
                for leaf in numbers.iter().filter_map(|&leaf| tree.leaf(leaf)) {
                    answers.clear();
                    ask(leaf, point, answers);
                    for answer in answers.iter() {
                        found(&CameraAnswer::of(answer, leaf));
                    }
                }
            }
            Self::Pinholes(trees) => {
                work::add(WORK_A_LEAF * u64::from(trees.piece_count()));
                trees.ask(point, scratch, &mut found);
            }
        }
    }

    /// Calls `found` with the projection of a point, near a first bounce point, by the camera of a ray; not at all
    /// where that is not known without asking all.
    pub(super) fn ask_near<R>(
        &self,
        ray: usize,
        point: Vec3,
        first: DVec3,
        found: impl FnOnce(&CameraAnswer<'_>) -> R,
    ) -> Option<R> {
        work::add(WORK_A_LEAF);
        let Self::Bundles(tree) = self else { return None };
        let leaf = tree.leaf_of(ray)?;
        let answer = &ask_near(leaf, point, first)?;
        Some(found(&CameraAnswer::of(answer, leaf)))
    }

    /// The leaf that draws what is seen at a ray of the group, in a piece: the bundle that the ray belongs to, or the
    /// pinhole that is asked for the point that shows there.
    pub(super) fn leaf_at(&self, ray: usize, piece: u32, point: Vec3) -> Option<LeafNumber> {
        match self {
            Self::Bundles(tree) => {
                let number = tree.leaf_number(ray)?;
                Some(LeafNumber { number, is_list: tree.leaf(number)?.interpolates != 0 })
            }
            Self::Pinholes(trees) => trees.leaf_at(piece, point),
        }
    }

    /// The group's rays have got other numbers: the old ones by the new.
    pub(super) fn renumber(&mut self, order: &[u32]) {
        match self {
            Self::Bundles(tree) => tree.renumber(order),
            Self::Pinholes(_) => {}
        }
    }

    /// Forgets what is known of each of the group's rays.
    pub(super) fn forget_rays(&mut self) {
        match self {
            Self::Bundles(tree) => tree.forget_rays(),
            Self::Pinholes(_) => {}
        }
    }

    /// Writes them, but for what is known of each ray.
    pub(super) fn store(&self, words: &mut WordWriter) {
        match self {
            Self::Bundles(tree) => tree.store(words),
            Self::Pinholes(trees) => trees.store(words),
        }
    }

    /// The cameras of a kind that [`Self::store`] has written; `None` for other words.
    pub(super) fn stored(kind: CameraKind, words: &mut WordReader<'_>) -> Option<Self> {
        Some(match kind {
            CameraKind::RayBundle => Self::Bundles(BundleTree::stored(words)?),
            CameraKind::Pinhole => Self::Pinholes(PinholeTrees::stored(words)?),
        })
    }

    pub(super) fn counts(&self) -> Counts {
        match self {
            Self::Bundles(tree) => tree.counts(),
            Self::Pinholes(trees) => trees.counts(),
        }
    }
}
