//! The cameras of one path, of either kind.

mod answer;
mod bsp;
mod builder;
mod bundle;
mod bundles;
mod camera_projection;
mod finer;
mod fit;
mod pinhole;

pub(super) use answer::{CameraAnswer, CameraScratch, Counts, LeafNumber};
pub(super) use builder::{Added, CameraBuilder, CameraDemand};
pub(super) use camera_projection::CameraProjection;

use super::layout::{WordReader, WordWriter};
use super::settings::CameraKind;
use crate::find::work;
use bsp::PinholeTrees;
use bundle::{ask, ask_near};
use bundles::BundleTree;
use glam::{DVec3, Vec3};

/// Work of a camera's answer.
const WORK_A_LEAF: u64 = 4;

/// The cameras of one path.
#[derive(Clone, Debug)]
pub(super) enum Cameras {
    Bundles(BundleTree),
    Pinholes(PinholeTrees),
}

impl CameraBuilder<'_> {
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

impl Cameras {
    /// Corners of the blocks of the map, in cells, that have no cameras.
    pub(super) fn left_out(&self) -> &[[[f32; 2]; 2]] {
        match self {
            Self::Bundles(tree) => tree.left_out(),
            Self::Pinholes(_) => &[],
        }
    }

    /// Calls `found` with all projections of a point by the cameras; with a `limit` (in cells), only with those up to
    /// that distance from a place in the map.
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
                // Leaves that interpolate come last: they may be off, and cameras have seen most of their points.
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

    /// The leaf that draws the reflection at a ray of the group, in a piece: the bundle that the ray belongs to, or the
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

    /// Drops the data of each of the group's rays.
    pub(super) fn forget_rays(&mut self) {
        match self {
            Self::Bundles(tree) => tree.forget_rays(),
            Self::Pinholes(_) => {}
        }
    }

    /// Writes them without the data of each ray.
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
