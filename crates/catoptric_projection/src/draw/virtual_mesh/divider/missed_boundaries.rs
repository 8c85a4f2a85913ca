//! Edges that are divided because of boundaries found beside them.

use glam::Vec3;
use std::collections::HashSet;

/// The bits of a position: positions that are equal to the bit are one point.
pub(in super::super) type PointKey = [u32; 3];

pub(in super::super) fn key(position: Vec3) -> PointKey {
    position.to_array().map(f32::to_bits)
}

/// An appearance that ends: from a point, towards another, where it appears at the first.
pub(super) type EndKey = (PointKey, PointKey, [u32; 2]);

/// An edge by its ends, in order.
pub(super) type EdgeKey = [PointKey; 2];

pub(super) fn edge_key(a: Vec3, b: Vec3) -> EdgeKey {
    let mut keys = [key(a), key(b)];
    keys.sort_unstable();
    keys
}

/// Edges that are divided whatever their ends show.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct ForcedEdges {
    edges: HashSet<EdgeKey>,
}

impl ForcedEdges {
    /// Adds an edge; false if it was known.
    pub(in super::super) fn add(&mut self, dip: &MissedBoundary) -> bool {
        self.edges.insert(dip.edge)
    }

    /// True if the edge between two points is one.
    pub(super) fn contain(&self, a: Vec3, b: Vec3) -> bool {
        !self.edges.is_empty() && self.edges.contains(&edge_key(a, b))
    }
}

/// An edge across which an appearance goes on although neither of its ends has it: where a fold or a silhouette bulges
/// over the edge. The triangle on its other side has no sign of it.
#[derive(Clone, Debug)]
pub(in super::super) struct MissedBoundary {
    pub(super) edge: EdgeKey,
    /// The triangle of the object.
    pub(in super::super) triangle: u32,
    /// The side of that triangle that the edge lies on, by the corner opposite to it; none within the triangle.
    pub(in super::super) side: Option<usize>,
}
