//! Edge functions of triangles in a bundle: where in the picture its rays pass on which side of an edge, and how deep.

use super::bundle::{RayBundle, TERMS};
use crate::light::wide_hierarchy::TriangleBlock;
use crate::math::lanes::{LANES, bits_of};

/// Functions of eight triangles over a tile, as coefficients of 1, u, v, u², uv, v².
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct EdgeFunctions {
    /// The Plücker products of the rays with the edges opposite to the first, second and third corner, doubled. Where
    /// all three have one sign the ray meets the triangle; with their sum they are the corners' weights.
    pub(in super::super) edges: [[[f32; LANES]; TERMS]; 3],
    /// Divided by the sum of the edges: the depth where the ray meets the triangle's plane.
    pub(in super::super) planes: [[f32; LANES]; TERMS],
}

impl EdgeFunctions {
    /// The functions of a block's triangles.
    ///
    /// Neighbours get the same function with the opposite sign for their common edge, to the bit: every step is odd in
    /// the edge's direction.
    #[inline(always)]
    pub(in super::super) fn new(bundle: &RayBundle, block: &TriangleBlock) -> Self {
        let mut functions = Self { edges: [[[0.0; LANES]; TERMS]; 3], planes: [[0.0; LANES]; TERMS] };
        let origin = bundle.origin.to_array();
        let mut from = [[0.0f32; LANES]; 9];
        for (coordinate, (from, corner)) in from.iter_mut().zip(&block.corners).enumerate() {
            for lane in 0..LANES {
                from[lane] = corner[lane] - origin[coordinate % 3];
            }
        }
        for (edge, functions) in functions.edges.iter_mut().enumerate() {
            let (p, q) = (((edge + 1) % 3) * 3, ((edge + 2) % 3) * 3);
            let (mut cross, mut along) = ([[0.0f32; LANES]; 3], [[0.0f32; LANES]; 3]);
            for lane in 0..LANES {
                let (px, py, pz) = (from[p][lane], from[p + 1][lane], from[p + 2][lane]);
                let (qx, qy, qz) = (from[q][lane], from[q + 1][lane], from[q + 2][lane]);
                let (ex, ey, ez) = (qx - px, qy - py, qz - pz);
                let (sx, sy, sz) = (px + qx, py + qy, pz + qz);
                cross[0][lane] = sy * ez - sz * ey;
                cross[1][lane] = sz * ex - sx * ez;
                cross[2][lane] = sx * ey - sy * ex;
                along[0][lane] = ex + ex;
                along[1][lane] = ey + ey;
                along[2][lane] = ez + ez;
            }
            for (term, function) in functions.iter_mut().enumerate() {
                let (d, m) = (bundle.directions[term], bundle.moments[term]);
                for lane in 0..LANES {
                    let by_direction = cross[0][lane] * d.x + cross[1][lane] * d.y + cross[2][lane] * d.z;
                    let by_moment = along[0][lane] * m.x + along[1][lane] * m.y + along[2][lane] * m.z;
                    function[lane] = by_direction + by_moment;
                }
            }
        }
        let mut normal = [[0.0f32; LANES]; 3];
        let mut distance = [0.0f32; LANES];
        for lane in 0..LANES {
            let (ax, ay, az) = (from[0][lane], from[1][lane], from[2][lane]);
            let (bx, by, bz) = (from[3][lane] - ax, from[4][lane] - ay, from[5][lane] - az);
            let (cx, cy, cz) = (from[6][lane] - ax, from[7][lane] - ay, from[8][lane] - az);
            let (nx, ny, nz) = (2.0 * (by * cz - bz * cy), 2.0 * (bz * cx - bx * cz), 2.0 * (bx * cy - by * cx));
            normal[0][lane] = nx;
            normal[1][lane] = ny;
            normal[2][lane] = nz;
            distance[lane] = nx * ax + ny * ay + nz * az;
        }
        let w = bundle.axes[2];
        for (term, function) in functions.planes.iter_mut().enumerate() {
            // A line with direction d and moment m meets the plane n . p = c at (n x m + c d) / n . d.
            let (turned, along) = (bundle.moments[term].cross(w), bundle.directions[term].dot(w));
            for lane in 0..LANES {
                let by_moment = normal[0][lane] * turned.x + normal[1][lane] * turned.y + normal[2][lane] * turned.z;
                function[lane] = by_moment + distance[lane] * along;
            }
        }
        functions
    }

    /// Which triangles may be met with the signs 1 and -1 of their edges somewhere within these distances (along u and
    /// v) of a place, one bit each.
    #[inline(always)]
    pub(in super::super) fn may_meet(&self, [u, v]: [f32; 2], [half_u, half_v]: [f32; 2]) -> [u32; 2] {
        let (mut plus, mut minus) = ([true; LANES], [true; LANES]);
        // No closures here: they would not be compiled for the caller's instruction set.
        for function in [&self.edges[0], &self.edges[1], &self.edges[2], &self.planes] {
            for lane in 0..LANES {
                let (c, cu, cv) = (function[0][lane], function[1][lane], function[2][lane]);
                let (cuu, cuv, cvv) = (function[3][lane], function[4][lane], function[5][lane]);
                let value = c + u * (cu + cuu * u + cuv * v) + v * (cv + cvv * v);
                let along_u = cu + 2.0 * cuu * u + cuv * v;
                let along_v = cv + 2.0 * cvv * v + cuv * u;
                let change = along_u.abs() * half_u
                    + along_v.abs() * half_v
                    + cuu.abs() * (half_u * half_u)
                    + cvv.abs() * (half_v * half_v)
                    + cuv.abs() * (half_u * half_v);
                plus[lane] &= value + change >= 0.0;
                minus[lane] &= change - value >= 0.0;
            }
        }
        [bits_of(plus).into(), bits_of(minus).into()]
    }

    /// The functions of one triangle: of its edges, and of its plane.
    #[inline(always)]
    pub(in super::super) fn of_lane(&self, lane: usize, sign: f32) -> [[f32; TERMS]; 4] {
        let mut functions = [[0.0; TERMS]; 4];
        for (of_lane, function) in
            functions.iter_mut().zip([&self.edges[0], &self.edges[1], &self.edges[2], &self.planes])
        {
            for term in 0..TERMS {
                of_lane[term] = function[term][lane] * sign;
            }
        }
        functions
    }
}
