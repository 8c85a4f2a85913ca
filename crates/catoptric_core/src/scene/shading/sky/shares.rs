//! The light of the sky and of emitters that arrives at surfaces, at all places of them.

use glam::{Vec2, Vec3};

/// The light that arrives at a place, on the side of its normals, and on the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arriving {
    /// The share of the sky's, for each colour.
    pub(super) sky: [Vec3; 2],
    /// The irradiance by emitters.
    pub(super) emitted: [Vec3; 2],
}

impl Arriving {
    /// All of the sky.
    pub(super) const OPEN: Self = Self { sky: [Vec3::ONE; 2], emitted: [Vec3::ZERO; 2] };

    /// The sum with so much of another one.
    pub(super) fn plus(&self, other: &Self, weight: f32) -> Self {
        Self {
            sky: [0, 1].map(|face| self.sky[face] + other.sky[face] * weight),
            emitted: [0, 1].map(|face| self.emitted[face] + other.emitted[face] * weight),
        }
    }
}

/// A triangle of a surface, whole or divided into four.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// The light that arrives at the triangle's corners: indices into [`SurfaceShares::arriving`].
    pub(super) corners: [u32; 3],
    /// The first of its four parts: those at its corners, then the middle one; 0: it is not divided.
    pub(super) parts: u32,
}

/// The light that arrives at all places of a scene's triangles.
#[derive(Debug)]
pub(super) struct SurfaceShares {
    pub(super) arriving: Vec<Arriving>,
    /// The triangles of the scene, then their parts.
    pub(super) nodes: Vec<Node>,
}

impl SurfaceShares {
    /// The share of the sky at a place of a triangle, on a side; all light, where the triangle was not there.
    #[inline]
    pub(super) fn sky(&self, triangle: u32, barycentrics: Vec2, side: usize) -> Vec3 {
        let Some((corners, at)) = self.node(triangle, barycentrics) else { return Vec3::ONE };
        let [first, second, third] = corners.map(|index| self.arriving[index as usize].sky[side]);
        first + (second - first) * at.x + (third - first) * at.y
    }

    /// The irradiance by emitters there.
    pub(super) fn emitted(&self, triangle: u32, barycentrics: Vec2, side: usize) -> Vec3 {
        let Some((corners, at)) = self.node(triangle, barycentrics) else { return Vec3::ZERO };
        let [first, second, third] = corners.map(|index| self.arriving[index as usize].emitted[side]);
        first + (second - first) * at.x + (third - first) * at.y
    }

    /// The corners of the smallest part of a triangle about a place, and the weights of the second and third one.
    #[inline(always)]
    fn node(&self, triangle: u32, barycentrics: Vec2) -> Option<([u32; 3], Vec2)> {
        // A pixel's middle may lie beside the triangle that the pixel shows.
        let at = barycentrics.max(Vec2::ZERO);
        let at = at / (at.x + at.y).max(1.0);
        let (mut b, mut c) = (at.x, at.y);
        let mut node = self.nodes.get(triangle as usize)?;
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
        Some((node.corners, Vec2::new(b, c)))
    }
}
