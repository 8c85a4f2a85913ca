//! Pieces of a triangle that wait for their division.

use glam::{Vec2, Vec3};
use std::cmp::Ordering;
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
pub(super) struct TrianglePiece {
    pub(super) corners: [PieceCorner; 3],
    /// Split priority of each edge.
    pub(super) split_priority: [f32; 3],
    pub(super) depth: u32,
}

/// A slender piece of four corners `a b c d`, long from `a` to `b` and from `d` to `c`.
#[derive(Clone, Copy)]
pub(super) struct Strip {
    pub(super) corners: [PieceCorner; 4],
    /// Split priorities of the sides `a b` and `d c`.
    pub(super) sides: [f32; 2],
    /// Split priorities of the ends `b c` and `d a`.
    pub(super) ends: [f32; 2],
    pub(super) depth: u32,
}

/// A piece or strip still to be divided.
pub(super) struct QueuedPiece {
    /// The largest of its edges' needs.
    pub(super) split_priority: f32,
    /// Number of those before it.
    pub(super) number: u32,
    pub(super) shape: PieceShape,
}

pub(super) enum PieceShape {
    Triangle(TrianglePiece),
    Strip(Strip),
}

impl Ord for QueuedPiece {
    /// Those that need it most come first, of equals the latest.
    fn cmp(&self, other: &Self) -> Ordering {
        self.split_priority.total_cmp(&other.split_priority).then(self.number.cmp(&other.number))
    }
}

impl PartialOrd for QueuedPiece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for QueuedPiece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for QueuedPiece {}
