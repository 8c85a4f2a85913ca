//! What is steady of objects, kept while the eye stays among its nodes.

use super::super::divider::{NOWHERE, SteadyCorner, SteadyDivider, SteadyPiece, SteadyPieces, SteadyPoints};
use super::super::edge::EdgeRule;
use super::super::{PictureScale, VirtualObject, WeldedObject, triangles_at_once};
use super::search::{KnownPoints, SteadySearch};
use super::{SteadyPath, SteadySource};
use crate::find::node_sightings::NodeSightings;
use crate::find::tetrahedron_form::{FormBlock, FormWeights, LANES, TetrahedronForm};
use crate::find::work::SharedWork;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::{PicturePoint, PreciseView};
use catoptric_engine::method::projector::Projection;
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Points that a thread takes at once. A size for threads; chosen, not measured.
const POINTS_AT_ONCE: usize = 256;

/// Blocks of polynomials that a thread evaluates at once. A size for threads; chosen, not measured.
const BLOCKS_AT_ONCE: usize = 512;

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

    /// What is steady of an object, with the work of making it, if that is no more than is allowed.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn get(
        &self,
        source: (&dyn SteadySource, &SteadyPath<'_>),
        object: &VirtualObject,
        rule: EdgeRule,
        allowed: u64,
        stage: &Stage<'_>,
    ) -> Result<Option<(Arc<SteadyMesh>, u64)>, Cancelled> {
        let made_of = MadeOf { welded: object.welded.clone(), rule };
        let key = (source.1.kept_path, object.object);
        let known = self.locked().get(&key).filter(|known| known.made_of.is_same(&made_of)).cloned();
        let KnownMesh { mesh, work, .. } = match known.filter(|known| known.tells(allowed)) {
            Some(known) => known,
            None => {
                let made = made(source, made_of, allowed, stage)?;
                self.locked().insert(key, made.clone());
                made
            }
        };
        Ok(mesh.filter(|_| work <= allowed).map(|mesh| (mesh, work)))
    }

    fn locked(&self) -> MutexGuard<'_, HashMap<(u32, u32), KnownMesh>> {
        self.meshes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a mesh depends on, beside the nodes.
struct MadeOf {
    welded: Arc<WeldedObject>,
    rule: EdgeRule,
}

impl MadeOf {
    fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.welded, &other.welded) && self.rule == other.rule
    }
}

/// What is known of an object on a path.
#[derive(Clone)]
struct KnownMesh {
    made_of: Arc<MadeOf>,
    /// `None` if that takes more work than `work`.
    mesh: Option<Arc<SteadyMesh>>,
    work: u64,
}

impl KnownMesh {
    /// True if it is known whether so much work is enough.
    fn tells(&self, allowed: u64) -> bool {
        self.mesh.is_some() || allowed <= self.work
    }
}

/// What is steady of an object on a path.
#[derive(Default)]
pub(super) struct SteadyMesh {
    /// Polynomials, and how many of them are points.
    blocks: Vec<FormBlock>,
    count: usize,
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
    /// For each the triangle that it is of, and the weights of its corners there.
    pub(super) sources: Vec<(u32, [Vec2; 3])>,
    /// Which of its edges are not divided further.
    pub(super) is_fixed: Vec<[bool; 3]>,
    /// Those of its points that are steady.
    pub(super) known: KnownPoints,
}

/// An object's points with how they appear.
struct FoundPoints {
    chunks: Vec<FoundChunk>,
    /// For each chunk the polynomials before it.
    forms_before: Vec<u32>,
    /// All polynomials.
    form_count: u32,
}

struct FoundChunk {
    points: SteadyPoints,
    /// For each point its row and its appearances from the middle.
    places: Vec<(u32, Range<u32>)>,
}

impl FoundPoints {
    /// Looks for points until there is too much work.
    fn new(
        search: &SteadySearch<'_>,
        points: &[Vec3],
        work: &SharedWork,
        stage: &Stage<'_>,
    ) -> Result<Self, Cancelled> {
        let parts: Vec<&[Vec3]> = points.chunks(POINTS_AT_ONCE).collect();
        let chunks = parallel::map_within(stage, parts.len(), |part| {
            let (mut points, mut share) = (SteadyPoints::default(), work.share());
            let wanted = parts[part].iter().take_while(|_| !share.is_too_much());
            let places = wanted.map(|point| points.add(search.steadiness(*point))).collect();
            FoundChunk { points, places }
        })?;
        let (mut forms_before, mut form_count) = (Vec::with_capacity(chunks.len()), 0);
        for chunk in &chunks {
            forms_before.push(form_count);
            form_count += chunk.points.forms.len() as u32;
        }
        Ok(Self { chunks, forms_before, form_count })
    }

    /// The row of a point, and its appearances from the middle.
    fn of(&self, point: u32) -> (u32, &[Projection]) {
        let (chunk, number) = (point as usize / POINTS_AT_ONCE, point as usize % POINTS_AT_ONCE);
        let FoundChunk { points, places } = &self.chunks[chunk];
        let (row, range) = &places[number];
        let row = if *row < NOWHERE { self.forms_before[chunk] + row } else { *row };
        (row, &points.appearances[range.start as usize..range.end as usize])
    }

    fn into_forms(self) -> Vec<TetrahedronForm> {
        self.chunks.into_iter().flat_map(|chunk| chunk.points.forms).collect()
    }
}

/// Makes the mesh of an object on a path, if no more work is needed for that than is allowed.
fn made(
    (source, at): (&dyn SteadySource, &SteadyPath<'_>),
    made_of: MadeOf,
    allowed: u64,
    stage: &Stage<'_>,
) -> Result<KnownMesh, Cancelled> {
    let MadeOf { welded, rule } = &made_of;
    let work = SharedWork::new(allowed);
    let field = source.field(at, &welded.points, &work, stage)?;
    let search = SteadySearch { source, at, field: field.as_deref() };
    let points = FoundPoints::new(&search, &welded.points, &work, stage)?;
    let mut mesh = None;
    if !work.is_too_much() {
        let corner = |point: u32| {
            let (row, appearances) = points.of(point);
            (welded.points[point as usize], row, appearances)
        };
        let numbers: Vec<u32> = (0..welded.triangles.len() as u32).collect();
        let parts: Vec<&[u32]> = numbers.chunks(triangles_at_once(numbers.len())).collect();
        let pieces = parallel::map_within(stage, parts.len(), |part| {
            let mut divider = SteadyDivider::new(search, rule, work.share(), points.form_count);
            for &triangle in parts[part].iter().take_while(|_| !work.is_too_much()) {
                divider.triangle(triangle, welded.triangles[triangle as usize].map(corner));
            }
            divider.finish()
        })?;
        mesh = (!work.is_too_much()).then(|| Arc::new(SteadyMesh::new(points, pieces)));
    }
    let work = if mesh.is_some() { work.done() } else { allowed };
    Ok(KnownMesh { made_of: Arc::new(made_of), mesh, work })
}

impl SteadyMesh {
    fn new(points: FoundPoints, pieces: Vec<SteadyPieces>) -> Self {
        let (mut mesh, mut numbers) = (Self::default(), HashMap::new());
        let first = points.form_count;
        let mut forms = points.into_forms();
        pieces.into_iter().for_each(|pieces| mesh.add(pieces, (&mut forms, first), &mut numbers));
        mesh.count = forms.len();
        mesh.blocks = forms.chunks(LANES).map(FormBlock::new).collect();
        mesh
    }

    fn byte_count(&self) -> u64 {
        let LeftPieces { welded, sources, is_fixed, known } = &self.left;
        let drawn = size_of_val(&*self.sources) + size_of_val(&*self.rows) + size_of_val(&*self.weights);
        let left = size_of_val(&**sources) + size_of_val(&**is_fixed);
        let welded = size_of_val(&*welded.points) + size_of_val(&*welded.triangles);
        let known = known.len() * size_of::<([u32; 3], NodeSightings)>();
        (size_of_val(&*self.blocks) + drawn + left + welded + known) as u64
    }

    /// Adds pieces; the rows of their own polynomials begin with `first`, and `numbers` are those of the points that
    /// pieces that are left have so far.
    fn add(
        &mut self,
        SteadyPieces { forms: mut own, drawn, left, known }: SteadyPieces,
        (forms, first): (&mut Vec<TetrahedronForm>, u32),
        numbers: &mut HashMap<[u32; 3], u32>,
    ) {
        let moved = forms.len() as u32 - first;
        forms.append(&mut own);
        for SteadyPiece { triangle, corners } in drawn {
            self.sources.push(triangle);
            self.rows.push(corners.map(|corner| if corner.row < first { corner.row } else { corner.row + moved }));
            self.weights.push(corners.map(|corner| corner.weights));
        }
        self.left.known.extend(known);
        for SteadyPiece { triangle, corners } in left {
            let LeftPieces { welded, sources, is_fixed, .. } = &mut self.left;
            sources.push((triangle, corners.map(|corner| corner.weights)));
            let is_steady = |corner: &SteadyCorner| corner.row <= NOWHERE;
            is_fixed.push([0, 1, 2].map(|k| is_steady(&corners[(k + 1) % 3]) && is_steady(&corners[(k + 2) % 3])));
            welded.triangles.push(corners.map(|corner| {
                *numbers.entry(corner.position.to_array().map(f32::to_bits)).or_insert_with(|| {
                    welded.points.push(corner.position);
                    welded.points.len() as u32 - 1
                })
            }));
        }
    }

    /// Where the points are in the eye's picture; not a number behind it.
    pub(super) fn places(&self, at: &SteadyPath<'_>, stage: &Stage<'_>) -> Result<Vec<PicturePoint>, Cancelled> {
        let mut places = vec![PicturePoint::default(); LANES * self.blocks.len()];
        let mut chunks: Vec<&mut [PicturePoint]> = places.chunks_mut(LANES * BLOCKS_AT_ONCE).collect();
        parallel::for_each_mut_within(stage, &mut chunks, |chunk, places| {
            let blocks = &self.blocks[chunk * BLOCKS_AT_ONCE..];
            evaluate(blocks, &at.weights, (&at.view, &at.scale), places);
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
