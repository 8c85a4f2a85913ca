//! Pieces of a triangle that wait for their division.

use glam::{Vec2, Vec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

/// A corner of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct PieceCorner {
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

/// A piece with what its edges ask for; edge `k` is opposite to corner `k`.
#[derive(Clone, Copy)]
pub(super) struct TrianglePiece<C> {
    pub(super) corners: [C; 3],
    /// Split priority of each edge.
    pub(super) split_priority: [f32; 3],
    pub(super) depth: u32,
}

/// A slender piece of four corners `a b c d`, long from `a` to `b` and from `d` to `c`.
#[derive(Clone, Copy)]
pub(super) struct Strip<C> {
    pub(super) corners: [C; 4],
    /// Split priorities of the sides `a b` and `d c`.
    pub(super) sides: [f32; 2],
    /// Split priorities of the ends `b c` and `d a`.
    pub(super) ends: [f32; 2],
    pub(super) depth: u32,
}

/// A piece or strip still to be divided.
struct QueuedPiece<C> {
    /// The largest of its edges' needs.
    split_priority: f32,
    /// Number of those before it.
    number: u32,
    shape: PieceShape<C>,
}

pub(super) enum PieceShape<C> {
    Triangle(TrianglePiece<C>),
    Strip(Strip<C>),
}

/// Pieces and strips still to be divided.
pub(super) struct PieceQueue<C> {
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
    pub(super) fn push(&mut self, split_priority: f32, shape: PieceShape<C>) {
        self.count += 1;
        self.waiting.push(QueuedPiece { split_priority, number: self.count, shape });
    }

    pub(super) fn pop(&mut self) -> Option<PieceShape<C>> {
        self.waiting.pop().map(|piece| piece.shape)
    }
}

impl<C> Ord for QueuedPiece<C> {
    /// Those that need it most come first, of equals the latest.
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
