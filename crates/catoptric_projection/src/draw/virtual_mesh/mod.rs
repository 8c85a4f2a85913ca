//! Virtual geometry: the triangles of an object where they appear after a specular path.
//!
//! Vertices are projected; triangles whose edges would be drawn too straight, or of which only a part appears, are
//! divided. Whether an edge is divided depends on its two ends alone, so neighbours agree and no crack opens. The
//! appearances at the ends of an edge belong together when they have the same focal index and each predicts the
//! other by its path Jacobian; so concave reflectors, which show a point several times, need no other book-keeping.

mod divider;
mod edge;
mod mesh;
mod object;
mod picture_scale;
pub(crate) mod points;
mod portions;
mod quality;
mod steady;
mod weld;

pub use mesh::{Allowance, VirtualMesh};
pub use object::{MAX_APPEARANCES, VirtualObject};
pub use picture_scale::PictureScale;
pub use quality::{Ends, MeshQuality};
pub use steady::{Steadiness, SteadyField, SteadyMeshes, SteadyPath, SteadySource};
pub use weld::WeldedObject;

use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_engine::method::projector::VertexProjector;
use divider::{DividedTriangle, Divider, ForcedEdges, MissedBoundary};
use edge::EdgeRule;
use points::ProjectedPoints;
use portions::triangles_at_once;
use std::collections::HashSet;
use std::ops::Range;
use steady::{SteadyFrame, SteadyPart};

/// The maximum number of rounds in which triangles are worked on again, because of boundaries found in their
/// neighbours, or with the work that others have left. A bound on time; chosen, not measured.
const MAX_ROUNDS: usize = 6;

/// The most work of a triangle in the first round, in even shares: most need next to nothing. Chosen, not measured.
const FIRST_SHARES: u64 = 2;

/// Triangles are divided with the work of this many points or more. Chosen, not measured.
const DIVIDING_POINTS: u64 = 4;

/// Triangles are not worked on again with less work than that of this many points. Chosen, not measured.
const MIN_POINTS: u64 = 8;

/// Work that every triangle counts as: it is looked at, however little there is to do.
const WORK_A_TRIANGLE: u64 = 2;

/// Triangles that are divided before the work is looked at, where a mesh is to be whole. A size for threads; chosen,
/// not measured.
const TRIANGLES_A_BATCH: usize = 256;

/// Makes the virtual mesh of an object on one path, as its `steps` of a stage, with about as much work as is allowed:
/// the rest is drawn coarser, and counted; or nothing is drawn.
///
/// # Errors
/// [`Cancelled`].
pub fn virtual_mesh<P: VertexProjector + ?Sized>(
    (projector, steady): (&P, Option<&dyn SteadySource>),
    object: &VirtualObject,
    quality: &MeshQuality,
    Allowance { work: allowed, whole }: Allowance,
    stage: &Stage<'_>,
) -> Result<VirtualMesh, Cancelled> {
    match SteadyPart::of(steady.filter(|_| whole), object, quality, allowed, stage)? {
        SteadyPart::None => divided(projector, (object, None), quality, Allowance { work: allowed, whole }, stage),
        // The mesh takes at least the work that is allowed, whether it was tried or not.
        SteadyPart::TooMuch => Ok(VirtualMesh { work: allowed, allowed, ..VirtualMesh::default() }.given_up()),
        SteadyPart::Found(frame) => {
            let left = VirtualObject::steps(frame.left());
            stage.advance(VirtualObject::steps(&object.welded).saturating_sub(left) as u64)?;
            let allowance = Allowance { work: allowed.saturating_sub(frame.work()), whole };
            let left = (object, Some(&*frame));
            let mut mesh = divided(&frame.projector(projector), left, quality, allowance, stage)?;
            if mesh.is_whole() {
                frame.complete(&mut mesh, object);
            }
            mesh.work += frame.work();
            mesh.needed = mesh.needed.map(|needed| needed + frame.work());
            Ok(VirtualMesh { allowed, ..mesh })
        }
    }
}

/// Makes the mesh of an object by dividing all of its triangles, or the pieces that are left beside the steady ones.
fn divided<P: VertexProjector + ?Sized>(
    projector: &P,
    (object, steady): (&VirtualObject, Option<&SteadyFrame<'_>>),
    quality: &MeshQuality,
    Allowance { work: allowed, whole }: Allowance,
    stage: &Stage<'_>,
) -> Result<VirtualMesh, Cancelled> {
    let welded = steady.map_or(&*object.welded, SteadyFrame::left);
    let projected = ProjectedPoints::new(projector, (object, welded), Allowance { work: allowed / 2, whole }, stage)?;
    let mesh = VirtualMesh {
        points_projected: projected.count,
        extrapolated: projected.extrapolated,
        left_out: projected.left_out,
        work: projected.work + WORK_A_TRIANGLE * welded.triangles.len() as u64,
        allowed,
        needed: projected.needed.map(|points| 2 * points),
        ..VirtualMesh::default()
    };
    if whole && (mesh.extrapolated > 0 || mesh.work > allowed) {
        return Ok(mesh.given_up());
    }
    let mut forced = ForcedEdges::default();
    let states = vec![TriangleState::default(); welded.triangles.len()];
    let mut pieces = MeshPieces { mesh, states, parts: Vec::new(), dips: Vec::new() };
    let mean_work = projected.work / projected.count.max(1) + 1;
    let mut wanted: Vec<u32> = (0..welded.triangles.len() as u32).collect();
    let mut limit = FIRST_SHARES * allowed.saturating_sub(pieces.mesh.work) / wanted.len().max(1) as u64;
    for round in 0..MAX_ROUNDS {
        if limit < DIVIDING_POINTS * mean_work {
            // The work of a point or two divides next to nothing: some triangles are divided well rather than all of
            // them badly.
            limit = if whole { DIVIDING_POINTS * mean_work } else { 0 };
        }
        let (work_before, mut most, mut all_finished) = (pieces.mesh.work, 0, true);
        for batch in wanted.chunks(if whole { TRIANGLES_A_BATCH } else { usize::MAX }) {
            let chunks: Vec<&[u32]> = batch.chunks(triangles_at_once(batch.len())).collect();
            let divided = parallel::map_within(stage, chunks.len(), |chunk| {
                let rule = EdgeRule::new(quality, &object.last_reflector, object.scene_size);
                let mut divider = Divider::new(projector, object, rule, limit, &forced);
                // A cancelled stage ends with the chunk: nothing is to be done about it here.
                let _ = stage.advance(if round == 0 { chunks[chunk].len() as u64 } else { 0 });
                let mut results = Vec::with_capacity(chunks[chunk].len());
                for &triangle in chunks[chunk] {
                    let points = welded.triangles[triangle as usize];
                    let corners = points.map(|point| (welded.points[point as usize], projected.of(point)));
                    let priorities = steady.map_or([f32::NAN; 3], |steady| steady.priorities(triangle));
                    results.push(divider.triangle(triangle, corners, priorities));
                }
                (divider.finish(), results)
            })?;
            for (part, triangles) in divided.into_iter().zip(&chunks) {
                let (most_of_part, is_finished) = pieces.add(part, triangles, limit);
                most = most.max(most_of_part);
                all_finished &= is_finished;
            }
            if whole && pieces.mesh.work > allowed {
                return Ok(pieces.mesh.given_up());
            }
        }
        let all = (most.max(DIVIDING_POINTS * mean_work) + 1) * wanted.len() as u64;
        let mesh = &mut pieces.mesh;
        mesh.needed = mesh.needed.filter(|_| all_finished).map(|needed| needed.max(work_before + all));
        let may_be_missed = |dip: &MissedBoundary| steady.is_none_or(|steady| steady.may_be_missed(dip));
        pieces.dips.retain(|dip| may_be_missed(dip) && forced.add(dip));
        wanted = welded.beside(&pieces.dips);
        pieces.dips.clear();
        let remaining = allowed.saturating_sub(pieces.mesh.work);
        let least = MIN_POINTS * mean_work;
        let is_enough;
        (limit, is_enough) = unfinished(&pieces.states, remaining, least, &mut wanted);
        if whole && !is_enough {
            return Ok(pieces.mesh.given_up());
        }
        if wanted.is_empty() || pieces.mesh.work >= allowed {
            break;
        }
    }
    let mesh = pieces.joined();
    Ok(if whole && !mesh.is_whole() { mesh.given_up() } else { mesh })
}

/// The pieces of a mesh in work.
struct MeshPieces {
    /// Everything but the pieces.
    mesh: VirtualMesh,
    /// The state of each triangle.
    states: Vec<TriangleState>,
    /// The pieces of all divisions.
    parts: Vec<VirtualMesh>,
    dips: Vec<MissedBoundary>,
}

impl MeshPieces {
    /// Adds the results of some triangles. Returns the most work of one of them, and true if all are finished.
    fn add(
        &mut self,
        ((part, dips), results): ((VirtualMesh, Vec<MissedBoundary>), Vec<DividedTriangle>),
        triangles: &[u32],
        limit: u64,
    ) -> (u64, bool) {
        let (mut start, mut most, mut all_finished) = (0, 0, true);
        for (&triangle, result) in triangles.iter().zip(&results) {
            self.states[triangle as usize] = TriangleState::new(self.parts.len() as u32, start, result, limit);
            start = result.end;
            self.mesh.work += result.work;
            most = most.max(result.work);
            all_finished &= result.unfinished == 0;
        }
        self.mesh.points_projected += part.points_projected;
        self.mesh.left_out += part.left_out;
        self.mesh.holes.add(&part.holes);
        self.parts.push(part);
        self.dips.extend(dips);
        (most, all_finished)
    }

    /// The mesh with the last pieces of every triangle.
    fn joined(self) -> VirtualMesh {
        let mut mesh = self.mesh;
        mesh.unfinished = self.states.iter().map(|state| state.unfinished).sum();
        let VirtualMesh { vertices, triangles, corners, .. } = &mut mesh;
        for TriangleState { mesh, pieces, .. } in self.states {
            if !pieces.is_empty() {
                self.parts[mesh as usize].append_some_to(pieces, vertices, triangles, corners);
            }
        }
        mesh
    }
}

/// A triangle's last division.
#[derive(Clone, Debug, Default)]
struct TriangleState {
    /// The mesh that its pieces are in, and where.
    mesh: u32,
    pieces: Range<usize>,
    /// Pieces that are unfinished.
    unfinished: u64,
    /// The need of its edges for a division.
    priority: f32,
    /// Work that it was allowed.
    limit: u64,
}

impl TriangleState {
    fn new(mesh: u32, start: usize, result: &DividedTriangle, limit: u64) -> Self {
        let DividedTriangle { end, unfinished, priority, .. } = *result;
        Self { mesh, pieces: start..end, unfinished, priority, limit }
    }
}

/// Adds those of the unfinished triangles to `wanted` that need it most, as many as `remaining` work is enough for, and
/// returns the work that each may take: twice that of the last round, and no less than `least`. Also returns true if
/// these are all of them.
fn unfinished(states: &[TriangleState], remaining: u64, least: u64, wanted: &mut Vec<u32>) -> (u64, bool) {
    let is_unfinished = |triangle: &u32| states[*triangle as usize].unfinished > 0;
    let mut waiting: Vec<u32> = (0..states.len() as u32).filter(is_unfinished).collect();
    let all = waiting.len();
    let share = remaining / (waiting.len() + wanted.len()).max(1) as u64;
    let limit = share.max(least);
    waiting.retain(|triangle| 2 * states[*triangle as usize].limit <= limit);
    let priority = |triangle: &u32| states[*triangle as usize].priority;
    waiting.sort_by(|a, b| priority(b).total_cmp(&priority(a)).then(a.cmp(b)));
    waiting.truncate((remaining / limit.max(1)) as usize);
    let is_enough = waiting.len() == all;
    wanted.extend(waiting);
    wanted.sort_unstable();
    wanted.dedup();
    (limit, is_enough)
}

impl WeldedObject {
    /// The triangles on both sides of dips, sorted.
    fn beside(&self, dips: &[MissedBoundary]) -> Vec<u32> {
        let mut found: Vec<u32> = dips.iter().map(|dip| dip.triangle).collect();
        let side_of = |dip: &MissedBoundary| {
            let points = self.triangles[dip.triangle as usize];
            dip.side.map(|side| sorted([points[(side + 1) % 3], points[(side + 2) % 3]]))
        };
        let sides: HashSet<[u32; 2]> = dips.iter().filter_map(side_of).collect();
        if !sides.is_empty() {
            for (triangle, [a, b, c]) in self.triangles.iter().enumerate() {
                if [[*a, *b], [*b, *c], [*c, *a]].into_iter().any(|side| sides.contains(&sorted(side))) {
                    found.push(triangle as u32);
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
