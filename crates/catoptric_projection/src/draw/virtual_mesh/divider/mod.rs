//! Triangles to pieces that are drawn straight, cut where appearances end.

mod boundary_traces;
mod division;
mod from_middle;
mod missed_boundaries;
mod shapes;

pub(super) use from_middle::{NOWHERE, SteadyCorner, SteadyDivider, SteadyPiece, SteadyPieces, SteadyPoints};
pub(super) use missed_boundaries::{ForcedEdges, MissedBoundary};

use super::edge::EdgeRule;
use super::{VirtualMesh, VirtualObject};
use crate::find::work;
use boundary_traces::{BoundaryTrace, EndKey, TracePlace};
use catoptric_engine::method::projector::{Projection, Projections, VertexProjector};
use catoptric_engine::raster::DrawTriangle;
use division::{Division, is_thin};
use glam::{Vec2, Vec3};
use missed_boundaries::{PointKey, key};
use shapes::{PieceCorner, PieceQueue, TrianglePiece};
use std::collections::HashMap;
use std::ops::Range;

/// Work that a piece counts as, beside that of the points projected for it: it is drawn, too. About what the rasteriser
/// takes for a triangle of some pixels.
pub(super) const WORK_A_PIECE: u64 = 20;

/// Pieces are halved this many times at the most. A bound on time; chosen, not measured.
const MAX_DEPTH: u32 = 80;

/// Some of what ends in a fold comes back on another sheet, at an angle: this share of the way on the other side is
/// left out, too. Chosen, not measured.
const BACK_SHARE: f32 = 0.5;

/// Blocks this near to pieces that are left out are left out, too, in pixels: a pixel's samples lie around its middle,
/// and appearances are known to less than one.
const LEFT_OUT_LEEWAY_PX: f32 = 1.0;

/// What is left out of a piece is looked for no further away than this, in pixels: the solver finds appearances there
/// that are stretched without bounds. Chosen, not measured.
const FARTHEST_LEFT_OUT_PX: f32 = 32.0;

/// Something may appear so far from the middle of an edge at whose ends nothing does, in lengths of the edge: as far as
/// triangles reach that are as wide as long.
const LONE_RADIUS: f32 = 1.0;

/// Beside a fold, pictures move twice as far as their start tells: as the root of what is left of the way. A piece is
/// expected to show this many times as far away as its corners tell. Chosen, not measured.
const BESIDE_FOLDS: f32 = 1.75;

/// Divides triangles of one object on one path.
pub(super) struct Divider<'a, P: VertexProjector + ?Sized> {
    projector: &'a P,
    object: &'a VirtualObject,
    rule: EdgeRule,
    /// The triangle of the scene.
    source: u32,
    /// The work that each triangle may take.
    limit: u64,
    forced: &'a ForcedEdges,
    dips: Vec<MissedBoundary>,
    /// The appearances of all points so far.
    appearances: Vec<Projection>,
    /// The middles of edges that have been projected: both sides of an edge ask for them.
    middles: HashMap<PointKey, (u32, u32)>,
    /// Where in `way_points` the ways of appearances to their ends are.
    ends: HashMap<EndKey, Range<u32>>,
    way_points: Vec<(Projection, f32)>,
    scratch: Projections,
    queue: PieceQueue<PieceCorner>,
    /// The piece that is being drawn.
    piece: [TracePlace; 3],
    /// The side of it that ways lead to, if neither of its ends has the appearance and no way got there yet.
    far_side: Option<[TracePlace; 2]>,
    /// Work of this thread before the triangle.
    work_before: u64,
    mesh: VirtualMesh,
}

/// Pairs of appearances at the ends of an edge that are compared, each with its rivals, in a unit of work.
const COMPARISONS_A_UNIT: u32 = 2;

/// A triangle's result.
#[derive(Clone, Copy, Debug)]
pub(super) struct DividedTriangle {
    /// Pieces so far.
    pub(super) end: usize,
    /// Work that it took.
    pub(super) work: u64,
    /// Pieces of it that were left undivided, or whose ends were not searched for, because its work was done.
    pub(super) unfinished: u64,
    /// The largest split priority of its edges.
    pub(super) priority: f32,
}

impl<'a, P: VertexProjector + ?Sized> Divider<'a, P> {
    /// For triangles of `object`, each of which takes no more work than about `limit`.
    pub(super) fn new(
        projector: &'a P,
        object: &'a VirtualObject,
        rule: EdgeRule,
        limit: u64,
        forced: &'a ForcedEdges,
    ) -> Self {
        let known = if rule.leaves_out() { projector.holes(object.path) } else { None };
        let holes = known.cloned().unwrap_or_else(|| rule.picture().no_blocks());
        let mesh = VirtualMesh { holes, ..VirtualMesh::default() };
        Self {
            projector,
            object,
            rule,
            source: 0,
            limit,
            forced,
            dips: Vec::new(),
            appearances: Vec::new(),
            middles: HashMap::new(),
            ends: HashMap::new(),
            way_points: Vec::new(),
            scratch: Projections::default(),
            queue: PieceQueue::default(),
            piece: [TracePlace::default(); 3],
            far_side: None,
            work_before: 0,
            mesh,
        }
    }

    /// All pieces of the triangles so far, and the edges that their neighbours should divide.
    pub(super) fn finish(self) -> (VirtualMesh, Vec<MissedBoundary>) {
        (self.mesh, self.dips)
    }

    /// Divides a triangle of the object, given by its corners and their appearances, and by its edges' split
    /// priorities; those that are not numbers are found here.
    pub(super) fn triangle(
        &mut self,
        triangle: u32,
        corners: [(Vec3, &[Projection]); 3],
        known_priorities: [f32; 3],
    ) -> DividedTriangle {
        self.work_before = work::done();
        let unfinished = self.mesh.unfinished;
        self.source = self.object.first_triangle + triangle;
        let weights = [Vec2::ZERO, Vec2::X, Vec2::Y];
        let [a, b, c] = [0, 1, 2].map(|k: usize| {
            let (position, appearances) = corners[k];
            let first = self.appearances.len() as u32;
            self.appearances.extend_from_slice(appearances);
            PieceCorner { position, weights: weights[k], first, count: appearances.len() as u32 }
        });
        let edges = [[&b, &c], [&c, &a], [&a, &b]];
        let split_priority = [0, 1, 2].map(|k: usize| match known_priorities[k].is_nan() {
            true => self.split_priority(edges[k][0], edges[k][1]),
            false => known_priorities[k],
        });
        self.divide_all(TrianglePiece { corners: [a, b, c], split_priority, depth: 0 });
        DividedTriangle {
            end: self.mesh.triangles.len(),
            work: work::since(self.work_before),
            unfinished: self.mesh.unfinished - unfinished,
            priority: split_priority.into_iter().fold(0.0, f32::max),
        }
    }

    fn of(&self, corner: &PieceCorner) -> &[Projection] {
        &self.appearances[corner.range()]
    }

    /// True if the triangle's work is done.
    fn is_spent(&self) -> bool {
        work::since(self.work_before) >= self.limit
    }

    /// Draws an appearance, unless an earlier corner has it too.
    fn emit_appearance(&mut self, corners: &[PieceCorner; 3], from: usize, index: usize) {
        let own = &corners[from];
        let one = self.appearances[index];
        let mut shared: [Option<usize>; 3] = [None; 3];
        shared[from] = Some(index);
        for (k, other) in corners.iter().enumerate().filter(|(k, _)| *k != from) {
            let partner = self.partner(index, own, other);
            if partner.is_some() && k < from {
                return; // drawn from there
            }
            shared[k] = partner;
        }
        if let [Some(_), Some(_), Some(_)] = shared {
            let (second, third) = ((from + 1) % 3, (from + 2) % 3);
            let agree = shared[second].and_then(|there| self.partner(there, &corners[second], &corners[third]));
            let agrees = agree.is_none() || agree == shared[third];
            let shown = [0, 1, 2].map(|k: usize| shared[k].map_or(one, |at| self.appearances[at]));
            if self.rule.leaves_out() && (!agrees || self.is_bent(corners, &shown)) {
                return self.leave_out(shown.map(|one| one.image_px));
            }
            if agrees {
                self.push([0, 1, 2].map(|k: usize| (shown[k], corners[k].weights)));
            }
            return;
        }
        if self.limit == 0 {
            // Where it ends is anybody's guess.
            self.mesh.unfinished += 1;
            return;
        }
        let goes_beside = |k: usize| {
            let stays = |at: usize, next: usize| {
                self.rule.stays_beside(&self.appearances[at], corners[next].position - corners[k].position)
            };
            shared[k].is_none_or(|at| stays(at, (k + 1) % 3) && stays(at, (k + 2) % 3))
        };
        if (0..3).all(goes_beside) {
            return;
        }
        if self.rule.leaves_out() {
            return self.emit_beside_hole(corners, shared);
        }
        // From a corner (or from the two of an edge) two ways lead to where the appearance ends; what is drawn lies
        // between them.
        let mut ways: [Option<BoundaryTrace>; 2] = [None, None];
        let mut number = 0;
        for k in 0..3 {
            let Some(here) = shared[k] else { continue };
            for next in [(k + 1) % 3, (k + 2) % 3] {
                if shared[next].is_none() {
                    ways[number] = Some(self.way_to_end(here, &corners[k], &corners[next]));
                    number += 1;
                }
            }
        }
        if let [Some(left), Some(right)] = &ways {
            self.piece = corners.map(|corner| TracePlace::of(&corner));
            let far = |k: usize| self.piece[(from + k) % 3];
            let alone = shared.iter().flatten().count() == 1;
            self.far_side = alone.then(|| [far(1), far(2)]);
            self.fill(left, right, 0);
        }
    }

    /// True if a piece is drawn too straight between its corners' appearances.
    fn is_bent(&self, corners: &[PieceCorner; 3], shown: &[Projection; 3]) -> bool {
        (0..3).any(|k| {
            let next = (k + 1) % 3;
            self.rule.is_bent(&shown[k], &shown[next], corners[next].position - corners[k].position)
        })
    }

    /// Draws a piece that only some corners share into the hole that the others lie in, or leaves it out.
    fn emit_beside_hole(&mut self, corners: &[PieceCorner; 3], shared: [Option<usize>; 3]) {
        let mut shown = shared.map(|index| index.map(|index| self.appearances[index]));
        for k in 0..3 {
            // From the corner before, or the one before that.
            let from = [1, 2].map(|back| (k + back) % 3).into_iter().find(|&from| shared[from].is_some());
            if let (None, Some(from)) = (shown[k], from)
                && let Some(index) = shared[from]
            {
                shown[k] = self.continued_into_hole(&self.appearances[index].clone(), &corners[from], &corners[k]);
            }
        }
        if let [Some(a), Some(b), Some(c)] = shown {
            return self.push([(a, corners[0].weights), (b, corners[1].weights), (c, corners[2].weights)]);
        }
        for (k, index) in shared.iter().enumerate() {
            let Some(index) = *index else { continue };
            let (one, here) = (self.appearances[index], &corners[k]);
            let mut places = [one.image_px; 5];
            for next in [1, 2] {
                let there = &corners[(k + next) % 3];
                let step = there.position - here.position;
                let way_px = self.rule.way_px(&self.appearances[index], self.of(here), self.of(there), step);
                let way = (one.predicted(step) - one.image_px).normalize_or_zero();
                let (ahead, back) = (BESIDE_FOLDS * way_px, BACK_SHARE * way_px);
                places[2 * next - 1] += way * ahead.min(FARTHEST_LEFT_OUT_PX);
                places[2 * next] -= way * back.min(FARTHEST_LEFT_OUT_PX);
            }
            self.leave_out(places);
        }
    }

    /// The appearance at another corner into which `one` goes on, if that lies in a hole, where it is not drawn.
    fn continued_into_hole(&mut self, one: &Projection, from: &PieceCorner, to: &PieceCorner) -> Option<Projection> {
        let step = to.position - from.position;
        if !self.rule.is_in_hole(one.predicted(step), &self.mesh.holes) {
            return None;
        }
        let found = self.continued(one, to.position, step);
        Some(found.unwrap_or_else(|| Projection { image_px: one.predicted(step), ..*one }))
    }

    /// Leaves the blocks of the picture to something else that places touch, or lie between.
    fn leave_out<const COUNT: usize>(&mut self, places: [Vec2; COUNT]) {
        let low = places.into_iter().fold(Vec2::INFINITY, Vec2::min) - LEFT_OUT_LEEWAY_PX;
        let high = places.into_iter().fold(Vec2::NEG_INFINITY, Vec2::max) + LEFT_OUT_LEEWAY_PX;
        self.mesh.holes.add_box(low, high);
    }

    /// The appearance of another corner that belongs to one of `own`.
    fn partner(&self, index: usize, own: &PieceCorner, other: &PieceCorner) -> Option<usize> {
        let step = other.position - own.position;
        let (here, there) = (self.of(own), self.of(other));
        let partner = self.rule.partner(&self.appearances[index], here, there, step)?;
        let place = there.iter().position(|one| std::ptr::eq(one, partner))?;
        Some(other.range().start + place)
    }

    fn push(&mut self, corners: [(Projection, Vec2); 3]) {
        let [a, b, c] = corners.map(|(_, weights)| weights);
        if a == b || b == c || c == a {
            return; // cut to nothing
        }
        let mesh = &mut self.mesh;
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(corners.iter().map(|(projection, _)| self.rule.picture().point(projection)));
        let vertices = [first, first + 1, first + 2];
        let (source, alpha_tested) = (self.source, self.object.alpha_tested);
        mesh.triangles.push(DrawTriangle { vertices, source, group: 0, patch: 0, alpha_tested });
        mesh.corners.push(corners.map(|(_, weights)| weights));
        work::add(WORK_A_PIECE);
    }
}

impl<P: VertexProjector + ?Sized> Division for Divider<'_, P> {
    type Corner = PieceCorner;

    fn queue(&mut self) -> &mut PieceQueue<PieceCorner> {
        &mut self.queue
    }

    fn split_priority(&mut self, a: &PieceCorner, b: &PieceCorner) -> f32 {
        work::add(u64::from(a.count * b.count / COMPARISONS_A_UNIT));
        let (at_a, at_b) = (self.of(a), self.of(b));
        if at_a.is_empty() && at_b.is_empty() {
            let middle = (a.position + b.position) * 0.5;
            let (path, radius) = (self.object.path, LONE_RADIUS * a.position.distance(b.position));
            if !self.projector.may_show(path, middle, radius) {
                return 0.0;
            }
        }
        let holes = &self.mesh.holes;
        let split_priority = self.rule.split_priority(a.position, at_a, b.position, at_b, holes);
        let is_forced = split_priority <= 0.0 && self.forced.contain(a.position, b.position);
        if is_forced { f32::MIN_POSITIVE } else { split_priority }
    }

    fn is_line(&self, corners: &[PieceCorner; 3]) -> bool {
        is_thin(corners.map(|corner| corner.position), corners.iter().flat_map(|corner| self.of(corner)))
    }

    fn is_last(&mut self, depth: u32) -> bool {
        let is_last = depth >= MAX_DEPTH || self.is_spent();
        self.mesh.unfinished += u64::from(is_last);
        is_last
    }

    fn middle(&mut self, a: &PieceCorner, b: &PieceCorner) -> PieceCorner {
        // Sums do not depend on the order: neighbours find the same point.
        let position = (a.position + b.position) * 0.5;
        let weights = (a.weights + b.weights) * 0.5;
        let key = key(position);
        let (first, count) = match self.middles.get(&key) {
            Some(known) => *known,
            None => {
                let first = self.appearances.len();
                self.scratch.clear();
                self.mesh.left_out += self.object.project(self.projector, &[position], &mut self.scratch);
                self.appearances.extend_from_slice(self.scratch.all());
                self.mesh.points_projected += 1;
                let range = (first as u32, (self.appearances.len() - first) as u32);
                self.middles.insert(key, range);
                range
            }
        };
        PieceCorner { position, weights, first, count }
    }

    /// Draws every appearance of the corners: whole where all three share it, cut where it ends where some do.
    fn emit(&mut self, corners: &[PieceCorner; 3]) {
        let [a, b, c] = corners.map(|corner| corner.count);
        work::add(u64::from((a * b + b * c + c * a) / COMPARISONS_A_UNIT));
        for (from, corner) in corners.iter().enumerate() {
            for index in corner.range() {
                self.emit_appearance(corners, from, index);
            }
        }
    }
}
