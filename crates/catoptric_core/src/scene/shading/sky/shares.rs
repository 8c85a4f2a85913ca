//! The light of the sky and of emitters that arrives at surfaces, at all places of them.

use glam::{Vec2, Vec3};

/// The light that arrives at a place, on the side of its normals, and on the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arriving {
    /// The share of the sky's, for each colour.
    pub(super) sky: [Vec3; 2],
    /// The irradiance by surfaces that emit light or scatter it.
    pub(super) by_surfaces: [Vec3; 2],
}

impl Arriving {
    /// All of the sky.
    pub(super) const OPEN: Self = Self { sky: [Vec3::ONE; 2], by_surfaces: [Vec3::ZERO; 2] };

    /// The sum with so much of another one.
    pub(super) fn plus(&self, other: &Self, weight: f32) -> Self {
        Self {
            sky: [0, 1].map(|face| self.sky[face] + other.sky[face] * weight),
            by_surfaces: [0, 1].map(|face| self.by_surfaces[face] + other.by_surfaces[face] * weight),
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
        self.interpolated(triangle, barycentrics, |index| self.arriving[index as usize].sky[side]).unwrap_or(Vec3::ONE)
    }

    /// The irradiance by surfaces there.
    pub(super) fn by_surfaces(&self, triangle: u32, barycentrics: Vec2, side: usize) -> Vec3 {
        let irradiance =
            self.interpolated(triangle, barycentrics, |index| self.arriving[index as usize].by_surfaces[side]);
        irradiance.unwrap_or(Vec3::ZERO)
    }

    /// The values that a function of the light's indices has, at a place of a triangle; `None` where the triangle was
    /// not there.
    #[inline(always)]
    pub(super) fn interpolated(
        &self,
        triangle: u32,
        barycentrics: Vec2,
        of_corner: impl Fn(u32) -> Vec3,
    ) -> Option<Vec3> {
        let (corners, at) = self.node(triangle, barycentrics)?;
        let [first, second, third] = corners.map(of_corner);
        Some(first + (second - first) * at.x + (third - first) * at.y)
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
