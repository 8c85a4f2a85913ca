//! Barycentric coordinates and their derivatives at a picture position, from the picture points alone.
//!
//! The 2-D homogeneous method (Olano and Greer 1997): a picture position is a weighted sum of the corners'
//! homogeneous points, and the weights, divided by their sum, are the barycentric coordinates in space. It needs no
//! division by w, so it serves triangles that cross the near plane or pass behind the eye.

use super::samples::LANES;
use crate::scene::PicturePoint;
use crate::scene::shade::Barycentrics;
use glam::Vec2;

/// Corners of eight triangles, each with the position at which it is shaded.
#[derive(Clone, Debug, Default)]
pub(super) struct Corners {
    x: [[f32; LANES]; 3],
    y: [[f32; LANES]; 3],
    w: [[f32; LANES]; 3],
    at_x: [f32; LANES],
    at_y: [f32; LANES],
    /// How far outside the triangle the position may count, as a share of its size.
    leeway: [f32; LANES],
}

impl Corners {
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, points: [&PicturePoint; 3], at: Vec2, leeway: f32) {
        self.leeway[lane] = leeway;
        for (corner, point) in points.into_iter().enumerate() {
            self.x[corner][lane] = point.xy.x;
            self.y[corner][lane] = point.xy.y;
            self.w[corner][lane] = point.w;
        }
        self.at_x[lane] = at.x;
        self.at_y[lane] = at.y;
    }
}

/// Weights of the second and third corner, their change along x, and along y: eight of each.
pub(super) type Weights = [[f32; LANES]; 6];

/// The barycentric coordinates of eight triangles.
///
/// Positions outside by more than the leeway (samples lie inside the *snapped* triangle, a hair outside this one) are
/// moved to where it ends. A triangle that is
/// seen exactly edge-on gives its middle, without change.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of many arrays, for the vectoriser
pub(super) fn weights(corners: &Corners, out: &mut Weights) {
    for i in 0..LANES {
        let (px, py) = (corners.at_x[i], corners.at_y[i]);
        // All weights change alike with the size of the points: a power of two keeps products within range.
        let mut largest = 0.0f32;
        for corner in 0..3 {
            largest = largest.max(corners.x[corner][i].abs());
            largest = largest.max(corners.y[corner][i].abs());
            largest = largest.max(corners.w[corner][i].abs());
        }
        let exponent = (largest.to_bits() & 0x7f80_0000).min(0x7e80_0000);
        let scale = f32::from_bits(0x7f00_0000 - exponent);
        let [wa, wb, wc] = [corners.w[0][i] * scale, corners.w[1][i] * scale, corners.w[2][i] * scale];
        // From the position: differences of large products would lose the small triangles.
        let from_position =
            |corner: usize, w: f32| (corners.x[corner][i] * scale - px * w, corners.y[corner][i] * scale - py * w);
        let ((xa, ya), (xb, yb), (xc, yc)) = (from_position(0, wa), from_position(1, wb), from_position(2, wc));
        let (na, nb, nc) = (xb * yc - xc * yb, xc * ya - xa * yc, xa * yb - xb * ya);
        let (na_dx, nb_dx, nc_dx) = (yb * wc - yc * wb, yc * wa - ya * wc, ya * wb - yb * wa);
        let (na_dy, nb_dy, nc_dy) = (xc * wb - xb * wc, xa * wc - xc * wa, xb * wa - xa * wb);
        let inverse = 1.0 / (na + nb + nc);
        let (sum_dx, sum_dy) = (na_dx + nb_dx + nc_dx, na_dy + nb_dy + nc_dy);
        let (b, c) = (nb * inverse, nc * inverse);
        let values = [
            b,
            c,
            (nb_dx - b * sum_dx) * inverse,
            (nc_dx - c * sum_dx) * inverse,
            (nb_dy - b * sum_dy) * inverse,
            (nc_dy - c * sum_dy) * inverse,
        ];
        let mut size = 0.0;
        for value in values {
            size += value.abs();
        }
        let usable = size < f32::MAX;
        let leeway = corners.leeway[i];
        let (b, c) = (b.clamp(-leeway, 1.0 + leeway), c.clamp(-leeway, 1.0 + leeway));
        // Keeps the sum at 1 when the first weight would be negative.
        let excess = ((b + c - 1.0 - leeway) * 0.5).max(0.0);
        let inside = [(b - excess).max(-leeway), (c - excess).max(-leeway)];
        for (index, value) in values.into_iter().enumerate() {
            let value = if index < 2 { inside[index] } else { value };
            let otherwise = if index < 2 { 1.0 / 3.0 } else { 0.0 };
            out[index][i] = if usable { value } else { otherwise };
        }
    }
}

/// One lane of [`weights`].
#[inline(always)]
pub(super) fn lane(weights: &Weights, lane: usize) -> Barycentrics {
    Barycentrics {
        value: Vec2::new(weights[0][lane], weights[1][lane]),
        dx: Vec2::new(weights[2][lane], weights[3][lane]),
        dy: Vec2::new(weights[4][lane], weights[5][lane]),
        samples: 1,
    }
}

/// Coordinates in a piece of a triangle as coordinates in the triangle, by those of the piece's corners; on its border
/// where the position lies outside.
#[inline(always)]
pub(super) fn in_source(piece: &Barycentrics, corners: &[Vec2; 3]) -> Barycentrics {
    let (second, third) = (corners[1] - corners[0], corners[2] - corners[0]);
    let change = |d: Vec2| second * d.x + third * d.y;
    let value = (corners[0] + change(piece.value)).clamp(Vec2::ZERO, Vec2::ONE);
    let excess = ((value.x + value.y - 1.0) * 0.5).max(0.0);
    Barycentrics {
        value: (value - excess).max(Vec2::ZERO),
        dx: change(piece.dx),
        dy: change(piece.dy),
        samples: piece.samples,
    }
}

/// The depth of a triangle's plane at a picture position (in pixels), beyond the triangle too; not finite where the
/// plane is seen edge-on.
pub(super) fn depth_at(points: [&PicturePoint; 3], at: Vec2) -> f32 {
    let [a, b, c] = points.map(|point| point.xy - at * point.w);
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let sum = weights[0] + weights[1] + weights[2];
    (weights[0] * points[0].depth + weights[1] * points[1].depth + weights[2] * points[2].depth) / sum
}

/// The barycentric coordinates of one triangle at a picture position (in pixels).
pub(super) fn barycentrics(points: [&PicturePoint; 3], at: Vec2) -> Barycentrics {
    let (mut corners, mut out) = (Corners::default(), Weights::default());
    corners.set(0, points, at, 0.0);
    weights(&corners, &mut out);
    lane(&out, 0)
}
