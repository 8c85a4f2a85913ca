//! The steady part of objects' virtual meshes, kept while the eye stays among its nodes.

use crate::draw::virtual_mesh::edge::EdgeRule;
use crate::draw::virtual_mesh::picture_scale::PictureScale;
use crate::draw::virtual_mesh::weld::WeldedObject;
use crate::find::node_sightings::NodeSightings;
use crate::find::tetrahedron_form::{FormBlock, FormWeights, LANES};
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::{PicturePoint, PreciseView};
use glam::Vec2;
use rustc_hash::FxHashMap;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Blocks of polynomials that a thread evaluates at once. A size for threads; chosen, not measured.
const BLOCKS_AT_ONCE: usize = 512;

/// Points that appear once, by the bits of their positions.
pub(super) type KnownPoints = FxHashMap<[u32; 3], NodeSightings>;

/// Meshes by the path and the object.
#[derive(Default)]
pub struct SteadyMeshes {
    meshes: Mutex<HashMap<(u32, u32), KnownMesh>>,
}

impl SteadyMeshes {
    /// The bytes of all meshes.
    pub(crate) fn byte_count(&self) -> u64 {
        self.locked().values().filter_map(|known| known.mesh.as_ref()).map(|mesh| mesh.byte_count()).sum()
    }

    /// The meshes that are known.
    pub(super) fn locked(&self) -> MutexGuard<'_, HashMap<(u32, u32), KnownMesh>> {
        self.meshes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Inputs of a mesh, beside the nodes.
pub(super) struct MadeOf {
    pub(super) welded: Arc<WeldedObject>,
    pub(super) rule: EdgeRule,
}

impl MadeOf {
    pub(super) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.welded, &other.welded) && self.rule == other.rule
    }
}

/// The mesh of an object on a path, or the work at which making it was given up.
#[derive(Clone)]
pub(super) struct KnownMesh {
    pub(super) made_of: Arc<MadeOf>,
    /// `None` if that takes more work than `work`.
    pub(super) mesh: Option<Arc<SteadyMesh>>,
    pub(super) work: u64,
}

impl KnownMesh {
    /// True if it is known whether so much work is enough.
    pub(super) fn tells(&self, allowed: u64) -> bool {
        self.mesh.is_some() || allowed <= self.work
    }
}

/// The steady part of an object's mesh on a path.
#[derive(Default)]
pub(super) struct SteadyMesh {
    /// Polynomials, and how many of them are points.
    pub(super) blocks: Vec<FormBlock>,
    pub(super) count: usize,
    /// The triangles of pieces that are drawn, and their corners' polynomials and weights.
    pub(super) sources: Vec<u32>,
    pub(super) rows: Vec<[u32; 3]>,
    pub(super) weights: Vec<[Vec2; 3]>,
    pub(super) left: LeftPieces,
}

/// Pieces that are looked at from every eye anew.
#[derive(Default)]
pub(super) struct LeftPieces {
    pub(super) welded: WeldedObject,
    /// The triangle of each piece, and the weights of the piece's corners in it.
    pub(super) sources: Vec<(u32, [Vec2; 3])>,
    /// True for the edges of each piece that are not divided further.
    pub(super) is_fixed: Vec<[bool; 3]>,
    /// The steady points among the corners.
    pub(super) known: KnownPoints,
}

impl SteadyMesh {
    fn byte_count(&self) -> u64 {
        let LeftPieces { welded, sources, is_fixed, known } = &self.left;
        let drawn = size_of_val(&*self.sources) + size_of_val(&*self.rows) + size_of_val(&*self.weights);
        let left = size_of_val(&**sources) + size_of_val(&**is_fixed);
        let welded = size_of_val(&*welded.points) + size_of_val(&*welded.triangles);
        let known = known.len() * size_of::<([u32; 3], NodeSightings)>();
        (size_of_val(&*self.blocks) + drawn + left + welded + known) as u64
    }

    /// The points in the eye's picture; not a number behind the eye.
    pub(super) fn places(
        &self,
        weights: &FormWeights,
        picture: (&PreciseView, &PictureScale),
        stage: &Stage<'_>,
    ) -> Result<Vec<PicturePoint>, Cancelled> {
        let mut places = vec![PicturePoint::default(); LANES * self.blocks.len()];
        let mut chunks: Vec<&mut [PicturePoint]> = places.chunks_mut(LANES * BLOCKS_AT_ONCE).collect();
        parallel::for_each_mut_within(stage, &mut chunks, |chunk, places| {
            let blocks = &self.blocks[chunk * BLOCKS_AT_ONCE..];
            evaluate(blocks, weights, picture, places);
        })?;
        places.truncate(self.count);
        Ok(places)
    }
}

/// The places of the points of as many blocks as there is room for.
#[multiversion::multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+bmi1+bmi2+popcnt+lzcnt",
    "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
))]
fn evaluate(
    blocks: &[FormBlock],
    weights: &FormWeights,
    (view, scale): (&PreciseView, &PictureScale),
    places: &mut [PicturePoint],
) {
    for (block, places) in blocks.iter().zip(places.chunks_exact_mut(LANES)) {
        let (found, lengths) = block.at(weights);
        let [across, down] = view.places_of(&found);
        if let Ok(places) = places.try_into() {
            scale.points_at([&across, &down], &lengths, places);
        }
    }
}
