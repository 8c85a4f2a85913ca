//! An object's points with their appearances: projected, or put where the appearances of a point near them lead.

use super::mesh::Allowance;
use super::object::VirtualObject;
use super::weld::WeldedObject;
use crate::find::work;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_engine::method::projector::{Projection, Projections, VertexProjector};
use glam::Vec3;

/// Points that share an even share of the work. A size for threads; chosen, not measured.
const POINTS_AT_ONCE: usize = 512;

/// Points that are projected before the work is looked at again. A size for batches; chosen, not measured.
const POINTS_A_BATCH: usize = 8;

/// Chunks that have not ended go on, with the work that others have left, this often. A bound on time; chosen, not
/// measured.
const MAX_ROUNDS: u32 = 4;

/// Where all points are needed: the divisor of the work after which the whole work is estimated, and the excess of the
/// estimate, as a factor, above which nothing more is tried. Chosen, not measured.
const FIRST_PART: u64 = 8;
const HOPELESS: u64 = 4;

/// The error of an extrapolated appearance, as a share of the distance of the extrapolation. Chosen, not measured.
const EXTRAPOLATED_ERROR: f32 = 0.25;

/// The appearances of an object's points on one path.
pub(super) struct ProjectedPoints {
    chunks: Vec<ProjectedChunk>,
    /// Points projected.
    pub(super) count: u64,
    /// Points that were not.
    pub(super) extrapolated: u64,
    pub(super) work: u64,
    /// Appearances that are left out: their points had too many.
    pub(super) left_out: u64,
    /// The least that may be allowed for the same result; `None` if any chunk was stopped, if only for a while.
    pub(super) needed: Option<u64>,
}

/// The expected work of all chunks, if the rest of each is like the part that is done.
fn expected_work(chunks: &[ProjectedChunk], points: &[&[Vec3]]) -> u64 {
    let of_chunk = |(chunk, points): (&ProjectedChunk, &&[Vec3])| {
        let shares = (chunk.work, points.len() as u64, chunk.known().max(1) as u64);
        shares.0.saturating_mul(shares.1) / shares.2
    };
    chunks.iter().zip(points).map(of_chunk).fold(0, u64::saturating_add)
}

/// A chunk of points.
struct ProjectedChunk {
    /// Numbers of the points, in the order in which they are projected.
    order: Vec<u16>,
    found: Projections,
    /// The row of each point among those found.
    rows: Vec<u16>,
    work: u64,
    left_out: u64,
}

impl ProjectedPoints {
    /// Projects points of an object, those of `welded`, with about as much work as is `allowed`, spread evenly over
    /// the object, but in every chunk a batch at least. The others are extrapolated, if not all have to be whole.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn new<P: VertexProjector + ?Sized>(
        projector: &P,
        (object, welded): (&VirtualObject, &WeldedObject),
        Allowance { work: allowed, whole }: Allowance,
        stage: &Stage<'_>,
    ) -> Result<Self, Cancelled> {
        let points: Vec<&[Vec3]> = welded.points.chunks(POINTS_AT_ONCE).collect();
        let mut chunks: Vec<ProjectedChunk> = points.iter().map(|points| ProjectedChunk::new(points.len())).collect();
        let (mut work, mut needed) = (0, None);
        for round in 0..MAX_ROUNDS {
            let waiting: Vec<usize> =
                (0..chunks.len()).filter(|&chunk| chunks[chunk].known() < points[chunk].len()).collect();
            if waiting.is_empty() || round > 0 && work >= allowed {
                break;
            }
            let limit = allowed.saturating_sub(work) / waiting.len() as u64;
            let mut taken: Vec<ProjectedChunk> =
                waiting.iter().map(|&chunk| std::mem::take(&mut chunks[chunk])).collect();
            let is_tried = whole && round == 0;
            if is_tried {
                let first = limit / FIRST_PART;
                parallel::for_each_mut_within(stage, &mut taken, |index, chunk| {
                    chunk.go_on(projector, object, points[index], first);
                })?;
            }
            let is_hopeless = is_tried && expected_work(&taken, &points) > HOPELESS.saturating_mul(allowed);
            parallel::for_each_mut_within(stage, &mut taken, |index, chunk| {
                // A cancelled stage ends with the chunk: nothing is to be done about it here.
                let _ = stage.advance(if round == 0 { points[waiting[index]].len() as u64 } else { 0 });
                let before = if is_tried { chunk.work } else { 0 };
                if before <= limit && !is_hopeless {
                    chunk.go_on(projector, object, points[waiting[index]], limit - before);
                }
            })?;
            let most = taken.iter().map(|chunk| chunk.work).max().unwrap_or(0);
            for (&number, chunk) in waiting.iter().zip(taken) {
                chunks[number] = chunk;
            }
            work = chunks.iter().map(|chunk| chunk.work).sum();
            let have_ended = || points.iter().zip(&chunks).all(|(points, chunk)| chunk.known() == points.len());
            if is_hopeless {
                break;
            }
            needed = (round == 0 && have_ended()).then(|| (most + 1) * points.len() as u64);
        }
        let count = chunks.iter().map(|chunk| chunk.known() as u64).sum();
        let extrapolated = welded.points.len() as u64 - count;
        if !whole {
            parallel::for_each_mut_within(stage, &mut chunks, |index, chunk| chunk.extrapolate(points[index]))?;
        }
        let left_out = chunks.iter().map(|chunk| chunk.left_out).sum();
        Ok(Self { chunks, count, extrapolated, work, left_out, needed })
    }

    /// The appearances of a point.
    pub(super) fn of(&self, point: u32) -> &[Projection] {
        let (chunk, number) = (point as usize / POINTS_AT_ONCE, point as usize % POINTS_AT_ONCE);
        let chunk = &self.chunks[chunk];
        chunk.found.of(chunk.rows[number].into())
    }
}

impl ProjectedChunk {
    fn new(count: usize) -> Self {
        let order = spread_order(count);
        let mut rows = vec![0; count];
        for (row, &number) in order.iter().enumerate() {
            rows[usize::from(number)] = row as u16;
        }
        Self { order, rows, found: Projections::default(), work: 0, left_out: 0 }
    }

    /// The number of points that were projected.
    fn known(&self) -> usize {
        self.found.point_count()
    }

    /// Projects more points, until that has taken more work than `limit`.
    fn go_on<P: VertexProjector + ?Sized>(
        &mut self,
        projector: &P,
        object: &VirtualObject,
        points: &[Vec3],
        limit: u64,
    ) {
        let before = work::done();
        let mut batch = Vec::with_capacity(POINTS_A_BATCH);
        for numbers in self.order[self.known()..].chunks(POINTS_A_BATCH) {
            batch.clear();
            batch.extend(numbers.iter().map(|&number| points[usize::from(number)]));
            self.left_out += object.project(projector, &batch, &mut self.found);
            work::add(batch.len() as u64);
            if work::since(before) > limit {
                break;
            }
        }
        self.work += work::since(before);
    }

    /// Adds the points that were not projected.
    fn extrapolate(&mut self, points: &[Vec3]) {
        let count = self.known();
        let (known, others) = self.order.split_at(count);
        for &number in others {
            let point = points[usize::from(number)];
            let apart = |row: &usize| points[usize::from(known[*row])].distance_squared(point);
            let Some(nearest) = (0..count).min_by(|a, b| apart(a).total_cmp(&apart(b))) else { return };
            let step = point - points[usize::from(known[nearest])];
            let led_on: Vec<Projection> = self.found.of(nearest).iter().map(|one| extrapolated(one, step)).collect();
            self.found.extend(&[point], |_, found| found.extend_from_slice(&led_on));
        }
    }
}

impl Default for ProjectedChunk {
    fn default() -> Self {
        Self::new(0)
    }
}

/// The numbers below `count`, in an order whose beginnings are spread evenly: by their bits, reversed.
pub fn spread_order(count: usize) -> Vec<u16> {
    let bits = usize::BITS - count.saturating_sub(1).leading_zeros();
    let reversed = |number: usize| if bits == 0 { 0 } else { number.reverse_bits() >> (usize::BITS - bits) };
    (0..1usize << bits).map(reversed).filter(|number| *number < count).map(|number| number as u16).collect()
}

/// An appearance extrapolated to a point a step away, to first order.
fn extrapolated(one: &Projection, step: Vec3) -> Projection {
    let image_px = one.predicted(step);
    let error_px = one.error_px + EXTRAPOLATED_ERROR * image_px.distance(one.image_px);
    Projection { image_px, error_px, ..*one }
}
