//! Division of triangles into pieces as they are seen from the middle of the eye's range: pieces whose corners appear
//! as polynomials are drawn from every eye; the others are divided further for each eye.

use super::meshes::KnownPoints;
use super::search::SteadySearch;
use super::source::Steadiness;
use crate::draw::virtual_mesh::divider::{
    COMPARISONS_A_UNIT, Division, MAX_DEPTH, PieceQueue, PointKey, TrianglePiece,
};
use crate::draw::virtual_mesh::divider::{is_thin, key};
use crate::draw::virtual_mesh::edge::EdgeRule;
use crate::find::node_sightings::NodeSightings;
use crate::find::tetrahedron_form::TetrahedronForm;
use crate::find::work::{self, ShareOfWork};
use catoptric_engine::method::projector::Projection;
use catoptric_engine::raster::BlockMask;
use glam::{Vec2, Vec3};
use rustc_hash::FxHashMap;
use std::collections::HashMap;
use std::ops::Range;

/// The length of edges, in pixels, up to which those with an end that is not steady are not divided from the middle:
/// each eye sees them differently, and divides them further itself. Of 16, 64 and 200 the best on `sphere_room`.
const COARSE_PX: f32 = 64.0;

/// Values in place of a row of polynomials: for a point whose appearances differ as the eye moves, and for one that
/// appears to no eye.
pub(super) const UNSTEADY: u32 = u32::MAX;
pub(super) const NOWHERE: u32 = u32::MAX - 1;

/// A corner of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct SteadyCorner {
    pub(super) position: Vec3,
    /// Weights of the source's second and third vertex.
    pub(super) weights: Vec2,
    /// The row of its polynomial, or one of the constants above.
    pub(super) row: u32,
    /// Range of its appearances from the middle among the divider's.
    first: u32,
    count: u32,
}

/// Polynomials, and how points appear from the middle.
#[derive(Default)]
pub(super) struct SteadyPoints {
    pub(super) forms: Vec<TetrahedronForm>,
    pub(super) appearances: Vec<Projection>,
}

impl SteadyPoints {
    /// Adds a point; returns its row, and the range of its appearances.
    pub(super) fn add(&mut self, found: Steadiness) -> (u32, Range<u32>) {
        let first = self.appearances.len() as u32;
        let row = match found {
            Steadiness::Shown(form, mean) => {
                self.forms.push(form);
                self.appearances.push(mean);
                self.forms.len() as u32 - 1
            }
            Steadiness::Nowhere => NOWHERE,
            Steadiness::Unsteady(seen) => {
                self.appearances.extend(seen);
                UNSTEADY
            }
        };
        (row, first..self.appearances.len() as u32)
    }
}

/// A piece with the number of its triangle.
pub(super) struct SteadyPiece {
    pub(super) triangle: u32,
    pub(super) corners: [SteadyCorner; 3],
}

/// Divides triangles of one object on one path.
pub(super) struct SteadyDivider<'a> {
    search: SteadySearch<'a>,
    rule: &'a EdgeRule,
    /// This divider's share of the work of all dividers.
    work: ShareOfWork<'a>,
    triangle: u32,
    /// The rows of polynomials that were found before.
    rows_before: u32,
    points: SteadyPoints,
    /// The sightings at the nodes of points that appear once, by their rows.
    seen: FxHashMap<u32, NodeSightings>,
    middles: HashMap<PointKey, (u32, Range<u32>)>,
    queue: PieceQueue<SteadyCorner>,
    /// Pieces that are drawn, and pieces that are left to divide from every eye.
    drawn: Vec<SteadyPiece>,
    left: Vec<SteadyPiece>,
    known: KnownPoints,
}

/// The result of dividing some triangles.
pub(super) struct SteadyPieces {
    /// The polynomials behind those that were there before.
    pub(super) forms: Vec<TetrahedronForm>,
    pub(super) drawn: Vec<SteadyPiece>,
    pub(super) left: Vec<SteadyPiece>,
    /// The points of the latter that appear once.
    pub(super) known: KnownPoints,
}

impl<'a> SteadyDivider<'a> {
    pub(super) fn new(search: SteadySearch<'a>, rule: &'a EdgeRule, work: ShareOfWork<'a>, rows_before: u32) -> Self {
        Self {
            search,
            rule,
            work,
            triangle: 0,
            rows_before,
            points: SteadyPoints::default(),
            seen: FxHashMap::default(),
            middles: HashMap::new(),
            queue: PieceQueue::default(),
            drawn: Vec::new(),
            left: Vec::new(),
            known: KnownPoints::default(),
        }
    }

    /// Divides a triangle, given by its corners with their rows and appearances.
    pub(super) fn triangle(&mut self, triangle: u32, corners: [(Vec3, u32, &[Projection]); 3]) {
        self.triangle = triangle;
        let weights = [Vec2::ZERO, Vec2::X, Vec2::Y];
        let corners @ [a, b, c] = [0, 1, 2].map(|k: usize| {
            let (position, row, appearances) = corners[k];
            let first = self.points.appearances.len() as u32;
            self.points.appearances.extend_from_slice(appearances);
            SteadyCorner { position, weights: weights[k], row, first, count: appearances.len() as u32 }
        });
        let split_priority = [self.split_priority(&b, &c), self.split_priority(&c, &a), self.split_priority(&a, &b)];
        self.divide_all(TrianglePiece { corners, split_priority, depth: 0 });
    }

    pub(super) fn finish(self) -> SteadyPieces {
        let Self { points, drawn, left, known, .. } = self;
        SteadyPieces { forms: points.forms, drawn, left, known }
    }

    fn of(&self, corner: &SteadyCorner) -> &[Projection] {
        &self.points.appearances[corner.first as usize..][..corner.count as usize]
    }

    /// The sightings at the nodes of a corner that appears once.
    fn seen(&mut self, corner: &SteadyCorner) -> Option<NodeSightings> {
        if corner.row >= NOWHERE {
            return None;
        }
        if let Some(known) = self.seen.get(&corner.row) {
            return Some(*known);
        }
        let found = self.search.sightings(corner.position)?;
        self.seen.insert(corner.row, found);
        Some(found)
    }

    /// Adds the middle of an edge; returns its row, and the range of its appearances.
    fn add_middle(&mut self, a: &SteadyCorner, b: &SteadyCorner, middle: Vec3) -> (u32, Range<u32>) {
        let ends = self.seen(a).zip(self.seen(b));
        let told = ends.and_then(|(at_a, at_b)| self.search.half_way([(a.position, &at_a), (b.position, &at_b)]));
        let (seen, found) = match told {
            Some((seen, found)) => (Some(seen), found),
            None => (None, self.search.steadiness(middle)),
        };
        let (row, range) = self.points.add(found);
        let row = if row < NOWHERE { self.rows_before + row } else { row };
        if let Some(seen) = seen.filter(|_| row < NOWHERE) {
            self.seen.insert(row, seen);
        }
        (row, range)
    }

    /// True if the corners of an edge surely show one appearance.
    fn belong_together(&self, a: &SteadyCorner, b: &SteadyCorner) -> bool {
        let (at_a, at_b) = (self.of(a), self.of(b));
        at_a.first().is_some_and(|one| self.rule.partner(one, at_a, at_b, b.position - a.position).is_some())
    }
}

impl Division for SteadyDivider<'_> {
    type Corner = SteadyCorner;

    fn queue(&mut self) -> &mut PieceQueue<SteadyCorner> {
        &mut self.queue
    }

    fn split_priority(&mut self, a: &SteadyCorner, b: &SteadyCorner) -> f32 {
        work::add(u64::from(a.count * b.count / COMPARISONS_A_UNIT));
        let priority = self.rule.split_priority(a.position, self.of(a), b.position, self.of(b), &BlockMask::default());
        let is_steady = a.row != UNSTEADY && b.row != UNSTEADY;
        if is_steady || priority > COARSE_PX { priority } else { 0.0 }
    }

    fn middle(&mut self, a: &SteadyCorner, b: &SteadyCorner) -> SteadyCorner {
        let position = (a.position + b.position) * 0.5;
        let weights = (a.weights + b.weights) * 0.5;
        let key = key(position);
        let (row, range) = match self.middles.get(&key) {
            Some(known) => known.clone(),
            None => {
                let (row, range) = self.add_middle(a, b, position);
                self.middles.insert(key, (row, range.clone()));
                (row, range)
            }
        };
        SteadyCorner { position, weights, row, first: range.start, count: range.len() as u32 }
    }

    fn is_line(&self, corners: &[SteadyCorner; 3]) -> bool {
        is_thin(corners.map(|corner| corner.position), corners.iter().flat_map(|corner| self.of(corner)))
    }

    fn is_last(&mut self, depth: u32) -> bool {
        depth >= MAX_DEPTH || self.work.is_too_much()
    }

    fn emit(&mut self, corners: &[SteadyCorner; 3]) {
        let [a, b, c] = corners;
        if corners.iter().all(|corner| corner.row == NOWHERE) {
            return;
        }
        let is_steady = corners.iter().all(|corner| corner.row < NOWHERE)
            && [[a, b], [b, c], [c, a]].into_iter().all(|[from, to]| self.belong_together(from, to));
        let piece = SteadyPiece { triangle: self.triangle, corners: *corners };
        if is_steady {
            return self.drawn.push(piece);
        }
        for corner in corners {
            if let Some(seen) = self.seen(corner) {
                self.known.insert(key(corner.position), seen);
            }
        }
        self.left.push(piece);
    }
}
