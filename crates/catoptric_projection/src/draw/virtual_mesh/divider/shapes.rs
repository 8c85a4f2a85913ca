//! Pieces of a triangle that wait for their division, and their corners.

use glam::{Vec2, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

/// A corner of a piece.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct PieceCorner {
    pub(super) position: Vec3,
    /// Weights of the source's second and third vertex.
    pub(super) weights: Vec2,
    /// Range of its appearances among the divider's.
    pub(super) first: u32,
    pub(super) count: u32,
}

impl PieceCorner {
    pub(super) fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A point of the source.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TracePlace {
    pub(super) position: Vec3,
    /// Weights of the source's second and third vertex.
    pub(super) weights: Vec2,
}

impl TracePlace {
    pub(super) fn of(corner: &PieceCorner) -> Self {
        Self { position: corner.position, weights: corner.weights }
    }

    /// Half-way to another place.
    pub(super) fn middle(&self, other: &Self) -> Self {
        let position = (self.position + other.position) * 0.5;
        Self { position, weights: (self.weights + other.weights) * 0.5 }
    }

    /// The point where the line from here through `other` leaves a triangle that holds both; `None` if they coincide.
    pub(super) fn beyond(&self, other: &Self, triangle: &[Self; 3]) -> Option<Self> {
        let [a, b, c] = triangle.map(|corner| corner.weights);
        let area = (b - a).perp_dot(c - a);
        let shares = |at: Vec2| {
            let (second, third) = ((at - a).perp_dot(c - a) / area, (b - a).perp_dot(at - a) / area);
            Vec3::new(1.0 - second - third, second, third)
        };
        let (here, there) = (shares(self.weights), shares(other.weights));
        // The first share that vanishes on the way.
        let ends =
            [0, 1, 2].map(|k: usize| if there[k] < here[k] { here[k] / (here[k] - there[k]) } else { f32::INFINITY });
        let length = ends[0].min(ends[1]).min(ends[2]);
        let at = here + (there - here) * length;
        let mix = |[p, q, r]: [Vec3; 3]| p * at.x + q * at.y + r * at.z;
        at.is_finite().then(|| Self {
            position: mix(triangle.map(|corner| corner.position)),
            weights: a * at.x + b * at.y + c * at.z,
        })
    }
}

/// A piece with the divisions that its edges need; edge `k` is opposite to corner `k`.
#[derive(Clone, Copy)]
pub(in super::super) struct TrianglePiece<C> {
    pub(in super::super) corners: [C; 3],
    /// Split priority of each edge.
    pub(in super::super) split_priority: [f32; 3],
    pub(in super::super) depth: u32,
}

/// A slender piece of four corners `a b c d`, long from `a` to `b` and from `d` to `c`.
#[derive(Clone, Copy)]
pub(in super::super) struct Strip<C> {
    pub(in super::super) corners: [C; 4],
    /// Split priorities of the sides `a b` and `d c`.
    pub(in super::super) sides: [f32; 2],
    /// Split priorities of the ends `b c` and `d a`.
    pub(in super::super) ends: [f32; 2],
    pub(in super::super) depth: u32,
}

/// A piece or strip still to be divided.
struct QueuedPiece<C> {
    /// The largest of its edges' needs.
    split_priority: f32,
    /// Number of those before it.
    number: u32,
    shape: PieceShape<C>,
}

pub(in super::super) enum PieceShape<C> {
    Triangle(TrianglePiece<C>),
    Strip(Strip<C>),
}

/// Pieces and strips still to be divided.
pub(in super::super) struct PieceQueue<C> {
    waiting: BinaryHeap<QueuedPiece<C>>,
    /// Number of those that have waited.
    count: u32,
}

impl<C> Default for PieceQueue<C> {
    fn default() -> Self {
        Self { waiting: BinaryHeap::new(), count: 0 }
    }
}

impl<C> PieceQueue<C> {
    pub(in super::super) fn push(&mut self, split_priority: f32, shape: PieceShape<C>) {
        self.count += 1;
        self.waiting.push(QueuedPiece { split_priority, number: self.count, shape });
    }

    pub(in super::super) fn pop(&mut self) -> Option<PieceShape<C>> {
        self.waiting.pop().map(|piece| piece.shape)
    }
}

impl<C> Ord for QueuedPiece<C> {
    /// The highest priority comes first; of equal ones, the latest.
    fn cmp(&self, other: &Self) -> Ordering {
        self.split_priority.total_cmp(&other.split_priority).then(self.number.cmp(&other.number))
    }
}

impl<C> PartialOrd for QueuedPiece<C> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<C> PartialEq for QueuedPiece<C> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<C> Eq for QueuedPiece<C> {}
