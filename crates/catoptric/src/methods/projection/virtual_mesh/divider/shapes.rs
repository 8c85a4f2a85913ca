//! Pieces of a triangle that wait for their division.

use glam::{Vec2, Vec3};
use std::cmp::Ordering;
use std::ops::Range;

/// A corner of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) position: Vec3,
    /// Weights of the source's second and third vertex.
    pub(super) weights: Vec2,
    /// Where its appearances are among the divider's.
    pub(super) first: u32,
    pub(super) count: u32,
}

impl Corner {
    pub(super) fn range(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A piece with what its edges ask for; edge `k` is opposite to corner `k`.
#[derive(Clone, Copy)]
pub(super) struct Piece {
    pub(super) corners: [Corner; 3],
    /// How much each edge needs a division.
    pub(super) strain: [f32; 3],
    pub(super) depth: u32,
}

/// A slender piece of four corners `a b c d`, long from `a` to `b` and from `d` to `c`.
#[derive(Clone, Copy)]
pub(super) struct Strip {
    pub(super) corners: [Corner; 4],
    /// How much the sides `a b` and `d c` need a division.
    pub(super) sides: [f32; 2],
    /// How much the ends `b c` and `d a` do.
    pub(super) ends: [f32; 2],
    pub(super) depth: u32,
}

/// What is still to be divided.
pub(super) struct Waiting {
    /// The largest of its edges' needs.
    pub(super) strain: f32,
    /// How many came before it.
    pub(super) number: u32,
    pub(super) shape: Shape,
}

pub(super) enum Shape {
    Triangle(Piece),
    Strip(Strip),
}

impl Ord for Waiting {
    /// Those that need it most come first, of equals the latest.
    fn cmp(&self, other: &Self) -> Ordering {
        self.strain.total_cmp(&other.strain).then(self.number.cmp(&other.number))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}
