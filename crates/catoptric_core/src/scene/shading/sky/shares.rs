//! The shares of the sky that surfaces see, at all places of them.

use glam::Vec2;

/// The shares of the sky that arrive at a surface: on the side of its normals, and on the other.
pub(super) type Shares = [f32; 2];

/// A triangle of a surface, whole or divided into four.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// The shares at its corners.
    pub(super) corners: [u32; 3],
    /// The first of its four parts: those at its corners, then the middle one; 0: it is not divided.
    pub(super) parts: u32,
}

/// The shares of all places of a scene's triangles.
#[derive(Debug)]
pub(super) struct SurfaceShares {
    pub(super) shares: Vec<Shares>,
    /// The triangles of the scene, then their parts.
    pub(super) nodes: Vec<Node>,
}

impl SurfaceShares {
    /// The shares at a place of a triangle; all light, where the triangle was not there.
    #[inline]
    pub(super) fn at(&self, triangle: u32, barycentrics: Vec2) -> Shares {
        // What a pixel shows may have its middle beside the triangle.
        let at = barycentrics.max(Vec2::ZERO);
        let at = at / (at.x + at.y).max(1.0);
        let (mut b, mut c) = (at.x, at.y);
        let Some(mut node) = self.nodes.get(triangle as usize) else { return [1.0; 2] };
        while node.parts != 0 {
            let a = 1.0 - b - c;
            let part = if a >= 0.5 {
                (b, c) = (2.0 * b, 2.0 * c);
                0
            } else if b >= 0.5 {
                (b, c) = (2.0 * b - 1.0, 2.0 * c);
                1
            } else if c >= 0.5 {
                (b, c) = (2.0 * b, 2.0 * c - 1.0);
                2
            } else {
                (b, c) = (1.0 - 2.0 * b, 1.0 - 2.0 * c);
                3
            };
            node = &self.nodes[node.parts as usize + part];
        }
        let [first, second, third] = node.corners.map(|index| self.shares[index as usize]);
        [0, 1].map(|face| first[face] + (second[face] - first[face]) * b + (third[face] - first[face]) * c)
    }
}
