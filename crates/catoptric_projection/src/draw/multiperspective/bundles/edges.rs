//! Edge functions of triangles in a bundle: where in the picture its rays pass on which side of an edge, and how deep.

use super::bundle::RayBundle;
use super::coverage::RayModel;
use super::least_squares::TERMS;
use catoptric_core::math::lanes::{LANES, bits_of};
use catoptric_engine::light::wide_hierarchy::TriangleBlock;

/// A function of eight triangles.
type Function = [[f32; LANES]; TERMS];

/// Functions of eight triangles over a tile.
///
/// The first three are the Plücker products of the rays with the edges opposite to the first, second and third corner,
/// doubled. Where all three have one sign the ray meets the triangle; with their sum they are the corners' weights. The
/// fourth, divided by that sum, is the depth where the ray meets the triangle's plane.
#[derive(Clone, Copy, Debug)]
pub struct EdgeFunctions {
    /// Coefficients by a line's direction and moment about the tile's origin.
    lines: [Function; 4],
    /// Coefficients of 1, u, v, u², uv, v² for the rays of the bundle.
    pub quadratics: [Function; 4],
    /// The greatest change of the functions by the rays' differences from the bundle.
    slack: [[f32; LANES]; 4],
}

impl EdgeFunctions {
    /// The functions of a block's triangles, for rays that differ from the bundle's by so much in each coordinate.
    ///
    /// Neighbours get the same function with the opposite sign for their common edge, to the bit: every step is odd in
    /// the edge's direction.
    #[inline(always)]
    pub fn new(bundle: &RayBundle, missed: Option<&[f32; TERMS]>, block: &TriangleBlock) -> Self {
        let none = [[0.0; LANES]; TERMS];
        let mut functions = Self { lines: [none; 4], quadratics: [none; 4], slack: [[0.0; LANES]; 4] };
        let origin = bundle.origin.to_array();
        let mut from = [[0.0f32; LANES]; 9];
        for (coordinate, (from, corner)) in from.iter_mut().zip(&block.corners).enumerate() {
            for lane in 0..LANES {
                from[lane] = corner[lane] - origin[coordinate % 3];
            }
        }
        for (edge, line) in functions.lines.iter_mut().enumerate().take(3) {
            let (p, q) = (((edge + 1) % 3) * 3, ((edge + 2) % 3) * 3);
            for lane in 0..LANES {
                let (px, py, pz) = (from[p][lane], from[p + 1][lane], from[p + 2][lane]);
                let (qx, qy, qz) = (from[q][lane], from[q + 1][lane], from[q + 2][lane]);
                let (ex, ey, ez) = (qx - px, qy - py, qz - pz);
                let (sx, sy, sz) = (px + qx, py + qy, pz + qz);
                line[0][lane] = sy * ez - sz * ey;
                line[1][lane] = sz * ex - sx * ez;
                line[2][lane] = sx * ey - sy * ex;
                line[3][lane] = ex + ex;
                line[4][lane] = ey + ey;
                line[5][lane] = ez + ez;
            }
        }
        let w = bundle.axes[2];
        let plane = &mut functions.lines[3];
        for lane in 0..LANES {
            let (ax, ay, az) = (from[0][lane], from[1][lane], from[2][lane]);
            let (bx, by, bz) = (from[3][lane] - ax, from[4][lane] - ay, from[5][lane] - az);
            let (cx, cy, cz) = (from[6][lane] - ax, from[7][lane] - ay, from[8][lane] - az);
            let (nx, ny, nz) = (2.0 * (by * cz - bz * cy), 2.0 * (bz * cx - bx * cz), 2.0 * (bx * cy - by * cx));
            let distance = nx * ax + ny * ay + nz * az;
            // A line with direction d and moment m meets the plane n . p = c at (n x m + c d) / n . d.
            plane[0][lane] = distance * w.x;
            plane[1][lane] = distance * w.y;
            plane[2][lane] = distance * w.z;
            plane[3][lane] = w.y * nz - w.z * ny;
            plane[4][lane] = w.z * nx - w.x * nz;
            plane[5][lane] = w.x * ny - w.y * nx;
        }
        for (line, quadratic) in functions.lines.iter().zip(&mut functions.quadratics) {
            for (term, function) in quadratic.iter_mut().enumerate() {
                let (d, m) = (bundle.directions[term], bundle.moments[term]);
                for lane in 0..LANES {
                    let by_direction = line[0][lane] * d.x + line[1][lane] * d.y + line[2][lane] * d.z;
                    let by_moment = line[3][lane] * m.x + line[4][lane] * m.y + line[5][lane] * m.z;
                    function[lane] = by_direction + by_moment;
                }
            }
        }
        if let Some(missed) = missed {
            for (line, slack) in functions.lines.iter().zip(&mut functions.slack) {
                for (coefficients, missed) in line.iter().zip(missed) {
                    for lane in 0..LANES {
                        slack[lane] += coefficients[lane].abs() * missed;
                    }
                }
            }
        }
        functions
    }

    /// The triangles that may be met with the signs 1 and -1 of their edges somewhere within these distances (along u
    /// and v) of a place, one bit each.
    #[inline(always)]
    pub(in super::super) fn may_meet(&self, [u, v]: [f32; 2], [half_u, half_v]: [f32; 2]) -> [u32; 2] {
        let (mut plus, mut minus) = ([true; LANES], [true; LANES]);
        // Without closures, which would not be compiled for the caller's instruction set.
        for (function, slack) in self.quadratics.iter().zip(&self.slack) {
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
                    + cuv.abs() * (half_u * half_v)
                    + slack[lane];
                plus[lane] &= value + change >= 0.0;
                minus[lane] &= change - value >= 0.0;
            }
        }
        [bits_of(plus).into(), bits_of(minus).into()]
    }

    /// The functions of one triangle, as a model of rays takes them.
    #[inline(always)]
    pub fn of_lane<M: RayModel>(&self, lane: usize, sign: f32) -> [[f32; TERMS]; 4] {
        let all = if M::OF_LINES { &self.lines } else { &self.quadratics };
        let mut functions = [[0.0; TERMS]; 4];
        for (of_lane, function) in functions.iter_mut().zip(all) {
            for term in 0..TERMS {
                of_lane[term] = function[term][lane] * sign;
            }
        }
        functions
    }
}
