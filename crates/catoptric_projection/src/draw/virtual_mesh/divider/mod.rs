//! Triangles to pieces that are drawn straight, cut where appearances end.

mod boundary_traces;
mod division;
mod drawing;
mod emission;
mod missed_boundaries;
mod shapes;

pub(super) use division::{COMPARISONS_A_UNIT, Division, MAX_DEPTH, WORK_A_PIECE, is_thin};
pub(super) use missed_boundaries::{ForcedEdges, MissedBoundary, PointKey, key};
pub(super) use shapes::{PieceQueue, TrianglePiece};

use super::edge::EdgeRule;
use super::mesh::VirtualMesh;
use super::object::VirtualObject;
use crate::find::work;
use catoptric_engine::method::projector::{Projection, VertexProjector};
use drawing::PieceDrawing;
use glam::{Vec2, Vec3};
use shapes::PieceCorner;
use std::collections::HashMap;

/// Something may appear so far from the middle of an edge at whose ends nothing does, in lengths of the edge: as far as
/// triangles reach that are as wide as long.
const LONE_RADIUS: f32 = 1.0;

/// Divides triangles of one object on one path.
pub(super) struct Divider<'a, P: VertexProjector + ?Sized> {
    drawing: PieceDrawing<'a, P>,
    forced: &'a ForcedEdges,
    /// The middles of edges that have been projected: both sides of an edge ask for them.
    middles: HashMap<PointKey, (u32, u32)>,
    queue: PieceQueue<PieceCorner>,
}

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
    /// A divider for triangles of `object`, each of which takes no more work than about `limit`.
    pub(super) fn new(
        projector: &'a P,
        object: &'a VirtualObject,
        rule: EdgeRule,
        limit: u64,
        forced: &'a ForcedEdges,
    ) -> Self {
        let drawing = PieceDrawing::new(projector, object, rule, limit);
        Self { drawing, forced, middles: HashMap::new(), queue: PieceQueue::default() }
    }

    /// Returns all pieces of the triangles so far, and the edges that their neighbours should divide.
    pub(super) fn finish(self) -> (VirtualMesh, Vec<MissedBoundary>) {
        (self.drawing.mesh, self.drawing.dips)
    }

    /// Divides a triangle of the object, given by its corners and their appearances, and by its edges' split
    /// priorities; those that are not numbers are found here.
    pub(super) fn triangle(
        &mut self,
        triangle: u32,
        corners: [(Vec3, &[Projection]); 3],
        known_priorities: [f32; 3],
    ) -> DividedTriangle {
        self.drawing.work_before = work::done();
        let unfinished = self.drawing.mesh.unfinished;
        self.drawing.source = self.drawing.object.first_triangle + triangle;
        let weights = [Vec2::ZERO, Vec2::X, Vec2::Y];
        let [a, b, c] = [0, 1, 2].map(|k: usize| {
            let (position, appearances) = corners[k];
            let first = self.drawing.appearances.len() as u32;
            self.drawing.appearances.extend_from_slice(appearances);
            PieceCorner { position, weights: weights[k], first, count: appearances.len() as u32 }
        });
        let edges = [[&b, &c], [&c, &a], [&a, &b]];
        let split_priority = [0, 1, 2].map(|k: usize| match known_priorities[k].is_nan() {
            true => self.split_priority(edges[k][0], edges[k][1]),
            false => known_priorities[k],
        });
        self.divide_all(TrianglePiece { corners: [a, b, c], split_priority, depth: 0 });
        DividedTriangle {
            end: self.drawing.mesh.triangles.len(),
            work: work::since(self.drawing.work_before),
            unfinished: self.drawing.mesh.unfinished - unfinished,
            priority: split_priority.into_iter().fold(0.0, f32::max),
        }
    }
}

impl<P: VertexProjector + ?Sized> Division for Divider<'_, P> {
    type Corner = PieceCorner;

    fn queue(&mut self) -> &mut PieceQueue<PieceCorner> {
        &mut self.queue
    }

    fn split_priority(&mut self, a: &PieceCorner, b: &PieceCorner) -> f32 {
        work::add(u64::from(a.count * b.count / COMPARISONS_A_UNIT));
        let (at_a, at_b) = (self.drawing.of(a), self.drawing.of(b));
        if at_a.is_empty() && at_b.is_empty() {
            let middle = (a.position + b.position) * 0.5;
            let (path, radius) = (self.drawing.object.path, LONE_RADIUS * a.position.distance(b.position));
            if !self.drawing.projector.may_show(path, middle, radius) {
                return 0.0;
            }
        }
        let holes = &self.drawing.mesh.holes;
        let split_priority = self.drawing.rule.split_priority(a.position, at_a, b.position, at_b, holes);
        let is_forced = split_priority <= 0.0 && self.forced.contain(a.position, b.position);
        if is_forced { f32::MIN_POSITIVE } else { split_priority }
    }

    fn is_line(&self, corners: &[PieceCorner; 3]) -> bool {
        is_thin(corners.map(|corner| corner.position), corners.iter().flat_map(|corner| self.drawing.of(corner)))
    }

    fn is_last(&mut self, depth: u32) -> bool {
        let is_last = depth >= MAX_DEPTH || self.drawing.is_spent();
        self.drawing.mesh.unfinished += u64::from(is_last);
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
                let PieceDrawing { projector, object, appearances, scratch, mesh, .. } = &mut self.drawing;
                let first = appearances.len();
                scratch.clear();
                mesh.left_out += object.project(*projector, &[position], scratch);
                appearances.extend_from_slice(scratch.all());
                mesh.points_projected += 1;
                let range = (first as u32, (appearances.len() - first) as u32);
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
                self.drawing.emit_appearance(corners, from, index);
            }
        }
    }
}
