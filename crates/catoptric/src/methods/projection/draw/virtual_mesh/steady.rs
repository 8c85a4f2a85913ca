//! What of a virtual mesh stays while the eye moves a little (Popescu, Sacks, Mei 2006, section VI: the projections of
//! static vertices are reused with varying weights): the appearances of points as polynomials, and the pieces that are
//! drawn between these.
//!
//! Edges are divided as they are seen from one place in the middle of where the eye may be. Pieces some of whose
//! corners may come and go are left: they are divided further as the eye sees them, like triangles of their own; but
//! for edges between steady corners, so that both of their sides agree.

use super::divider::{NOWHERE, SteadyCorner, SteadyDivider, SteadyPiece, SteadyPieces, SteadyPoints};
use super::edge::EdgeRule;
use super::{MeshQuality, MissedBoundary, PictureScale, VirtualMesh, VirtualObject, WORK_A_PIECE, WeldedObject};
use crate::clock::Stopwatch;
use crate::methods::projection::find::tetrahedron_form::{FormBlock, FormWeights, LANES, TetrahedronForm};
use crate::methods::projection::find::work::SharedWork;
use crate::methods::projector::Projection;
use crate::parallel;
use crate::progress::{Cancelled, Stage};
use crate::raster::DrawTriangle;
use crate::scene::{PicturePoint, PreciseView};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Points that a thread takes at once. A size for threads; chosen, not measured.
const POINTS_AT_ONCE: usize = 256;

/// Blocks of polynomials that a thread evaluates at once. A size for threads; chosen, not measured.
const BLOCKS_AT_ONCE: usize = 512;

/// How a point appears wherever the eye is.
pub(in crate::methods::projection) enum Steadiness {
    /// Once; with its appearance from the middle.
    Shown(TetrahedronForm, Projection),
    Nowhere,
    /// It may come and go, or appear several times; with what is known of its appearances from the middle.
    Unsteady(Vec<Projection>),
}

/// Who finds out how points appear.
pub(in crate::methods::projection) trait SteadySource: Sync {
    /// Where the eye is on a path; `None` where nothing is known to be steady.
    fn on_path(&self, path: u32) -> Option<SteadyPath<'_>>;

    /// How a point appears on a path.
    fn steadiness(&self, at: &SteadyPath<'_>, point: Vec3) -> Steadiness;
}

/// A path while the eye stays among some nodes.
pub(in crate::methods::projection) struct SteadyPath<'a> {
    /// The path's number now.
    pub(in crate::methods::projection) path: u32,
    /// Meshes that were made while the eye did, and the path's number there.
    pub(in crate::methods::projection) meshes: &'a SteadyMeshes,
    pub(in crate::methods::projection) kept_path: u32,
    /// A place in the middle of the nodes, and a picture from there that holds all of the mirror.
    pub(in crate::methods::projection) middle: Vec3,
    pub(in crate::methods::projection) view_from_middle: PreciseView,
    pub(in crate::methods::projection) scale_from_middle: PictureScale,
    /// The eye's place among the nodes, and what it sees.
    pub(in crate::methods::projection) weights: FormWeights,
    pub(in crate::methods::projection) view: PreciseView,
    pub(in crate::methods::projection) scale: PictureScale,
}

/// Meshes by the path and the object.
#[derive(Default)]
pub(in crate::methods::projection) struct SteadyMeshes {
    meshes: Mutex<HashMap<(u32, u32), KnownMesh>>,
}

impl SteadyMeshes {
    /// The bytes of all meshes.
    pub(in crate::methods::projection) fn byte_count(&self) -> u64 {
        self.locked().values().filter_map(|known| known.mesh.as_ref()).map(|mesh| mesh.byte_count()).sum()
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
struct SteadyMesh {
    /// Polynomials, and how many of them are points.
    blocks: Vec<FormBlock>,
    count: usize,
    /// The triangles of pieces that are drawn, and their corners' polynomials and weights.
    sources: Vec<u32>,
    rows: Vec<[u32; 3]>,
    weights: Vec<[Vec2; 3]>,
    left: LeftPieces,
}

/// Pieces that are looked at from every eye anew.
#[derive(Default)]
struct LeftPieces {
    welded: WeldedObject,
    /// For each the triangle that it is of, and the weights of its corners there.
    sources: Vec<(u32, [Vec2; 3])>,
    /// Which of its edges are not divided further.
    is_fixed: Vec<[bool; 3]>,
}

/// What is steady of an object, as it is seen.
pub(super) struct SteadyFrame {
    mesh: Arc<SteadyMesh>,
    places: Vec<PicturePoint>,
    /// Work for making the mesh.
    work: u64,
    /// Time for finding the places.
    blend_ms: f64,
}

/// What is there of an object.
pub(super) enum SteadyPart {
    None,
    /// Finding it takes more than it may.
    TooMuch,
    Found(SteadyFrame),
}

impl SteadyPart {
    /// What is steady of an object, found with as much work or less.
    pub(super) fn of(
        source: Option<&dyn SteadySource>,
        object: &VirtualObject,
        quality: &MeshQuality,
        allowed: u64,
        stage: &Stage<'_>,
    ) -> Result<Self, Cancelled> {
        if object.least_segment > 0.0 {
            return Ok(Self::None);
        }
        let Some((source, at)) = source.and_then(|source| Some((source, source.on_path(object.path)?))) else {
            return Ok(Self::None);
        };
        let quality = MeshQuality { picture: at.scale_from_middle, ..*quality };
        let rule = EdgeRule::new(&quality, &object.last_reflector, object.scene_size);
        let made_of = MadeOf { welded: object.welded.clone(), rule };
        let key = (at.kept_path, object.object);
        let known = at.meshes.locked().get(&key).filter(|known| known.made_of.is_same(&made_of)).cloned();
        let KnownMesh { mesh, work, .. } = match known.filter(|known| known.tells(allowed)) {
            Some(known) => known,
            None => {
                let made = made((source, &at), made_of, allowed, stage)?;
                at.meshes.locked().insert(key, made.clone());
                made
            }
        };
        let Some(mesh) = mesh.filter(|_| work <= allowed) else { return Ok(Self::TooMuch) };
        let watch = Stopwatch::new();
        let places = mesh.places(&at, stage)?;
        let blend_ms = watch.elapsed_ms();
        // Where the mirror reaches behind the picture's plane, not everything is before it.
        let all_before = places.iter().all(|place| place.w > 0.0);
        Ok(if all_before { Self::Found(SteadyFrame { mesh, places, work, blend_ms }) } else { Self::None })
    }
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
        (source, at): (&dyn SteadySource, &SteadyPath<'_>),
        points: &[Vec3],
        work: &SharedWork,
        stage: &Stage<'_>,
    ) -> Result<Self, Cancelled> {
        let parts: Vec<&[Vec3]> = points.chunks(POINTS_AT_ONCE).collect();
        let chunks = parallel::map_within(stage, parts.len(), |part| {
            let (mut points, mut share) = (SteadyPoints::default(), work.share());
            let wanted = parts[part].iter().take_while(|_| !share.is_too_much());
            let places = wanted.map(|point| points.add(source.steadiness(at, *point))).collect();
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
    source: (&dyn SteadySource, &SteadyPath<'_>),
    made_of: MadeOf,
    allowed: u64,
    stage: &Stage<'_>,
) -> Result<KnownMesh, Cancelled> {
    let MadeOf { welded, rule } = &made_of;
    let work = SharedWork::new(allowed);
    let points = FoundPoints::new(source, &welded.points, &work, stage)?;
    let mut mesh = None;
    if !work.is_too_much() {
        let corner = |point: u32| {
            let (row, appearances) = points.of(point);
            (welded.points[point as usize], row, appearances)
        };
        let numbers: Vec<u32> = (0..welded.triangles.len() as u32).collect();
        let parts: Vec<&[u32]> = numbers.chunks(super::triangles_at_once(numbers.len())).collect();
        let pieces = parallel::map_within(stage, parts.len(), |part| {
            let mut divider = SteadyDivider::new(source, rule, work.share(), points.form_count);
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
        let LeftPieces { welded, sources, is_fixed } = &self.left;
        let drawn = size_of_val(&*self.sources) + size_of_val(&*self.rows) + size_of_val(&*self.weights);
        let left = size_of_val(&**sources) + size_of_val(&**is_fixed);
        let welded = size_of_val(&*welded.points) + size_of_val(&*welded.triangles);
        (size_of_val(&*self.blocks) + drawn + left + welded) as u64
    }

    /// Adds pieces; the rows of their own polynomials begin with `first`, and `numbers` are those of the points that
    /// pieces that are left have so far.
    fn add(
        &mut self,
        SteadyPieces { forms: mut own, drawn, left }: SteadyPieces,
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
        for SteadyPiece { triangle, corners } in left {
            let LeftPieces { welded, sources, is_fixed } = &mut self.left;
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
    fn places(&self, at: &SteadyPath<'_>, stage: &Stage<'_>) -> Result<Vec<PicturePoint>, Cancelled> {
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
        for (lane, place) in places.iter_mut().enumerate() {
            *place = scale.point_at(Vec2::new(across[lane] as f32, down[lane] as f32), lengths[lane]);
        }
    }
}

impl SteadyFrame {
    /// Work that it counts as, whether it was known or not; its pieces are drawn, too.
    pub(super) fn work(&self) -> u64 {
        self.work + WORK_A_PIECE * self.mesh.rows.len() as u64
    }

    /// The pieces that are looked at.
    pub(super) fn left(&self) -> &WeldedObject {
        &self.mesh.left.welded
    }

    /// The split priorities of the edges of such a piece, as far as they are known; else not a number.
    pub(super) fn priorities(&self, piece: u32) -> [f32; 3] {
        self.mesh.left.is_fixed[piece as usize].map(|is_fixed| if is_fixed { 0.0 } else { f32::NAN })
    }

    /// True unless a boundary is said to be missed on an edge that is not divided from the other side either.
    pub(super) fn may_be_missed(&self, boundary: &MissedBoundary) -> bool {
        boundary.side.is_none_or(|side| !self.mesh.left.is_fixed[boundary.triangle as usize][side])
    }

    /// From the mesh of what is left to that of all.
    pub(super) fn complete(&self, mesh: &mut VirtualMesh, object: &VirtualObject) {
        for (triangle, corners) in mesh.triangles.iter_mut().zip(&mut mesh.corners) {
            let (source, [a, b, c]) = self.mesh.left.sources[(triangle.source - object.first_triangle) as usize];
            triangle.source = object.first_triangle + source;
            *corners = corners.map(|weights| a + (b - a) * weights.x + (c - a) * weights.y);
        }
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend_from_slice(&self.places);
        mesh.triangles.extend(self.mesh.sources.iter().zip(&self.mesh.rows).map(|(source, rows)| DrawTriangle {
            vertices: rows.map(|row| first + row),
            source: object.first_triangle + source,
            group: 0,
            patch: 0,
            alpha_tested: object.alpha_tested,
        }));
        mesh.corners.extend_from_slice(&self.mesh.weights);
        mesh.steady_points = self.places.len() as u64;
        mesh.blend_ms = self.blend_ms;
    }
}
