//! Virtual geometry: the triangles of an object where they appear after a specular path.
//!
//! Vertices are projected; triangles whose edges would be drawn too straight, or of which only a part appears, are
//! divided. Whether an edge is divided depends on its two ends alone, so neighbours agree and no crack opens. The
//! appearances at the ends of an edge belong together when they have the same focal index and each predicts the
//! other by its path Jacobian; so concave reflectors, which show a point several times, need no other book-keeping.

mod divider;
mod edge;
pub(crate) mod points;
mod steady;
mod weld;

pub use steady::{Steadiness, SteadyField, SteadyMeshes, SteadyPath, SteadySource};
pub use weld::WeldedObject;

use catoptric_core::math::Aabb;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::{PicturePoint, View};
use catoptric_engine::method::projector::{Projection, Projections, VertexProjector};
use catoptric_engine::raster::{BlockMask, DrawTriangle};
use divider::{DividedTriangle, Divider, ForcedEdges, MissedBoundary, WORK_A_PIECE};
use edge::EdgeRule;
use glam::{Vec2, Vec3};
use points::ProjectedPoints;
use std::collections::HashSet;
use std::ops::Range;
use std::sync::Arc;
use steady::{SteadyFrame, SteadyPart};

/// Fineness of virtual geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshQuality {
    /// Edges are divided until their middles are this near to where they belong, in pixels.
    pub edge_error_px: f32,
    /// Edges shorter than this are not divided, in pixels; those on which an appearance ends, than 32 times this.
    pub piece_px: f32,
    /// As in Chen and Arvo 2000: appearances at the two ends of an edge are joined where they lie near each other,
    /// whether they predict each other or not, and no mirror appears in itself.
    pub is_plain: bool,
    /// The picture: what appears outside it is not divided.
    pub picture: PictureScale,
    /// The fate of pieces on which appearances end, and of those that would have to be very small.
    pub ends: Ends,
}

/// Pieces on which appearances end (in folds, at silhouettes, behind other parts of a mirror) and strongly bent ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ends {
    /// Drawn: appearances are followed to their ends.
    #[default]
    Followed,
    /// Left to something else, with the blocks of the picture where they may show ([`VirtualMesh::holes`]).
    LeftOut,
}

impl MeshQuality {
    /// For a view's picture, by the finest edges' error and the smallest pieces, both in pixels.
    pub fn new(view: &View, edge_error_px: f32, piece_px: f32) -> Self {
        let (picture, ends) = (PictureScale::new(view), Ends::Followed);
        Self { edge_error_px, piece_px, is_plain: false, picture, ends }
    }
}

impl MeshQuality {
    /// The same with errors and pieces so many times larger.
    #[must_use]
    pub fn coarser(&self, times: f32) -> Self {
        Self { edge_error_px: self.edge_error_px * times, piece_px: self.piece_px * times, ..*self }
    }
}

/// Picture points from places in a picture and path lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureScale {
    size_px: Vec2,
    /// Pixels per unit of the tangent of the angle to the view axis; none in orthographic views.
    focal_px: Option<f32>,
}

impl PictureScale {
    /// The scale of a view's picture.
    pub fn new(view: &View) -> Self {
        let size_px = Vec2::new(view.width as f32, view.height as f32);
        let focal_px = match view.projection {
            catoptric_core::scene::Projection::Perspective { fov_y } => Some(size_px.y * 0.5 / (fov_y * 0.5).tangent()),
            catoptric_core::scene::Projection::Orthographic { .. } => None,
        };
        Self { size_px, focal_px }
    }

    /// The depth of the place that lies the path's length away on the view ray.
    #[inline(always)]
    fn depth(&self, image_px: Vec2, path_length: f32) -> f32 {
        match self.focal_px {
            Some(focal_px) => depth_along(image_px - self.size_px * 0.5, path_length, focal_px),
            None => path_length,
        }
    }

    /// Divisor of depths: the homogeneous coordinate.
    #[inline]
    fn w(&self, one: &Projection) -> f32 {
        if self.focal_px.is_some() { self.depth(one.image_px, one.path_length) } else { 1.0 }
    }

    /// None of the picture's blocks.
    fn no_blocks(&self) -> BlockMask {
        BlockMask::new([self.size_px.x, self.size_px.y].map(|pixels| pixels as usize))
    }

    /// True if places all lie beyond one side of the picture.
    fn is_beside<const COUNT: usize>(&self, places: [Vec2; COUNT]) -> bool {
        let beyond = |is: &dyn Fn(Vec2) -> bool| places.into_iter().all(is);
        beyond(&|place| place.x < 0.0)
            || beyond(&|place| place.y < 0.0)
            || beyond(&|place| place.x > self.size_px.x)
            || beyond(&|place| place.y > self.size_px.y)
    }

    fn point(&self, one: &Projection) -> PicturePoint {
        let depth = self.depth(one.image_px, one.path_length);
        let w = if self.focal_px.is_some() { depth } else { 1.0 };
        PicturePoint { xy: one.image_px * w, w, depth }
    }

    /// The points at places, so far away on their paths, to the bit as [`Self::point`] has them.
    #[inline(always)]
    fn points_at<const COUNT: usize>(
        &self,
        [across, down]: [&[f64; COUNT]; 2],
        lengths: &[f32; COUNT],
        points: &mut [PicturePoint; COUNT],
    ) {
        // Lists of numbers, so that many are done at once.
        let (mut x_px, mut y_px) = ([0.0f32; COUNT], [0.0f32; COUNT]);
        for k in 0..COUNT {
            (x_px[k], y_px[k]) = (across[k] as f32, down[k] as f32);
        }
        let (mut depths, mut w) = (*lengths, [1.0f32; COUNT]);
        if let Some(focal_px) = self.focal_px {
            let half = self.size_px * 0.5;
            for (k, depth) in depths.iter_mut().enumerate() {
                *depth = depth_along(Vec2::new(x_px[k], y_px[k]) - half, *depth, focal_px);
            }
            w = depths;
        }
        for (k, point) in points.iter_mut().enumerate() {
            *point = PicturePoint { xy: Vec2::new(x_px[k] * w[k], y_px[k] * w[k]), w: w[k], depth: depths[k] };
        }
    }
}

/// The depth of what lies so far away on the ray through a place so many pixels from the picture's middle.
#[inline(always)]
fn depth_along(from_middle_px: Vec2, path_length: f32, focal_px: f32) -> f32 {
    path_length / (1.0 + (from_middle_px / focal_px).length_squared()).sqrt()
}

/// Pieces of an object's triangles where they appear.
#[derive(Clone, Debug, Default)]
pub struct VirtualMesh {
    /// The corners of the pieces.
    pub vertices: Vec<PicturePoint>,
    /// The pieces; their groups are left at 0.
    pub triangles: Vec<DrawTriangle>,
    /// Weights of the source's second and third vertex at the corners.
    pub corners: Vec<[Vec2; 3]>,
    /// Blocks of the picture where pieces may show that are left out.
    pub holes: BlockMask,
    /// Points projected to make it.
    pub points_projected: u64,
    /// Pieces that were left undivided, or whose ends were not searched for, because there was too much to do.
    pub unfinished: u64,
    /// Vertices that were not projected, but put where the appearances of one near them lead, for the same reason.
    pub extrapolated: u64,
    /// Appearances of its vertices and of points on its edges that are left out: these had too many.
    pub left_out: u64,
    /// Vertices whose places follow from a few numbers that are kept.
    pub steady_points: u64,
    /// Time that these took, in milliseconds.
    pub blend_ms: f64,
    /// Work that it took.
    pub work: u64,
    /// Work that was allowed.
    pub(crate) allowed: u64,
    /// The least that may be allowed for the same mesh; `None` if any part of it was stopped, if only for a while.
    pub needed: Option<u64>,
}

/// Work that a mesh may take.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    /// In units of about 100 ns of one core.
    work: u64,
    /// What would not be whole is not made.
    whole: bool,
}

impl Allowance {
    /// For all of a mesh: it is coarser if this is not enough.
    pub fn for_all(work: u64) -> Self {
        Self { work, whole: false }
    }

    /// The work.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// For a whole mesh, or none at all.
    pub fn for_whole(work: u64) -> Self {
        Self { work, whole: true }
    }
}

impl VirtualMesh {
    /// What is known of a mesh that takes too much work.
    fn given_up(self) -> Self {
        let Self { points_projected, extrapolated, work, allowed, .. } = self;
        Self { points_projected, extrapolated, work, allowed, unfinished: self.unfinished.max(1), ..Self::default() }
    }

    /// True if nothing of it is coarser than asked for.
    pub fn is_whole(&self) -> bool {
        self.unfinished + self.extrapolated == 0
    }

    /// True if it would be the same with this much work allowed.
    pub fn holds_with(&self, allowed: u64) -> bool {
        allowed == self.allowed || self.needed.is_some_and(|needed| allowed >= needed)
    }

    /// Appends the pieces to those of other meshes.
    pub fn append_to(
        &self,
        vertices: &mut Vec<PicturePoint>,
        triangles: &mut Vec<DrawTriangle>,
        corners: &mut Vec<[Vec2; 3]>,
    ) {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(&self.vertices);
        let moved = |triangle: &DrawTriangle| DrawTriangle {
            vertices: triangle.vertices.map(|vertex| vertex + first),
            ..*triangle
        };
        triangles.extend(self.triangles.iter().map(moved));
        corners.extend_from_slice(&self.corners);
    }

    /// The same for some of a divider's pieces.
    fn append_some_to(
        &self,
        pieces: Range<usize>,
        vertices: &mut Vec<PicturePoint>,
        triangles: &mut Vec<DrawTriangle>,
        corners: &mut Vec<[Vec2; 3]>,
    ) {
        // Three vertices a piece, in their order.
        let (first, from) = (vertices.len() as u32, 3 * pieces.start as u32);
        vertices.extend_from_slice(&self.vertices[3 * pieces.start..3 * pieces.end]);
        let moved = |triangle: &DrawTriangle| {
            let vertices = triangle.vertices.map(|vertex| vertex - from + first);
            DrawTriangle { vertices, ..*triangle }
        };
        triangles.extend(self.triangles[pieces.clone()].iter().map(moved));
        corners.extend_from_slice(&self.corners[pieces]);
    }
}

/// A path and the objects projected on it.
#[derive(Clone)]
pub struct VirtualObject {
    /// The object's number in the scene.
    pub object: u32,
    /// Its points and triangles.
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
    fn project<P: VertexProjector + ?Sized>(&self, projector: &P, points: &[Vec3], found: &mut Projections) -> u64 {
        let first = found.point_count();
        projector.project_beyond(self.path, self.least_segment, points, found);
        self.retain_distant(first, found);
        let magnification = |one: &Projection| one.image_change[0].cross(one.image_change[1]).length();
        found.keep_largest_from(first, MAX_APPEARANCES, magnification) as u64
    }

    /// Appends a point with the appearance that continues `one`, and perhaps others.
    fn follow<P: VertexProjector + ?Sized>(
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

/// Of appearances of a point on one path no more than so many are drawn: those that are magnified most. Bumpy mirrors
/// show points a hundred times, in places of less than a pixel. A bound on time; chosen, not measured.
pub const MAX_APPEARANCES: usize = 8;

/// Triangles that are worked on at once. Sizes for threads; chosen, not measured.
const TRIANGLES_AT_ONCE: usize = 8;
const LEAST_PORTIONS: usize = 16;

/// Of so many triangles as many are worked on at once: of few, which are mostly large, every one alone.
fn triangles_at_once(count: usize) -> usize {
    (count / LEAST_PORTIONS).clamp(1, TRIANGLES_AT_ONCE)
}

/// Triangles are worked on again, because of what was found in their neighbours, or with what work the others have
/// left, at most this often. A bound on time; chosen, not measured.
const MAX_ROUNDS: usize = 6;

/// In the first round triangles may take this many times an even share of the work: most need next to nothing. Chosen,
/// not measured.
const FIRST_SHARES: u64 = 2;

/// Triangles are divided with the work of so many points or more. Chosen, not measured.
const DIVIDING_POINTS: u64 = 4;

/// Triangles are not worked on again with less work than that of so many points. Chosen, not measured.
const MIN_POINTS: u64 = 8;

/// Work that every triangle counts as: it is looked at, however little there is to do.
const WORK_A_TRIANGLE: u64 = 2;

/// Triangles that are divided before the work is looked at, where a mesh is to be whole. A size for threads; chosen,
/// not measured.
const TRIANGLES_A_BATCH: usize = 256;

/// Makes the virtual mesh of an object on one path, as its `steps` of a stage, with about as much work as is allowed:
/// what is left then is drawn coarser, and counted; or nothing is drawn.
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
        // So much is known, whether it was tried or not.
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

/// Makes the mesh of an object by dividing all of its triangles, or those pieces that are left beside what is steady.
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
            // With the work of a point or two next to nothing is divided: rather some triangles well than all of them
            // badly.
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
    /// One for each triangle.
    states: Vec<TriangleState>,
    /// The pieces of all divisions.
    parts: Vec<VirtualMesh>,
    dips: Vec<MissedBoundary>,
}

impl MeshPieces {
    /// Adds what came of some triangles, and returns the most work of one of them, and whether all are finished.
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
/// returns what each may take: twice what it had, and no less than `least`; and whether that is all of them.
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
