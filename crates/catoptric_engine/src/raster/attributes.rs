//! Barycentric coordinates and their derivatives at a picture position, from the picture points alone.
//!
//! The 2-D homogeneous method (Olano and Greer 1997): a picture position is a weighted sum of the corners'
//! homogeneous points, and the weights, divided by their sum, are the barycentric coordinates in space. It needs no
//! division by w, so it serves triangles that cross the near plane or pass behind the eye.

use catoptric_core::math::lanes::{LANES, Lanes};
use catoptric_core::scene::PicturePoint;
use catoptric_core::scene::shade::Barycentrics;
use glam::Vec2;

/// Corners of eight triangles, each with the position at which it is shaded.
#[derive(Clone, Debug, Default)]
pub(super) struct CornerLanes {
    x: [Lanes; 3],
    y: [Lanes; 3],
    w: [Lanes; 3],
    at_x: Lanes,
    at_y: Lanes,
    /// The greatest distance of a position outside the triangle, as a share of its size.
    leeway: Lanes,
}

impl CornerLanes {
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, points: [&PicturePoint; 3], leeway: f32) {
        self.leeway[lane] = leeway;
        for (corner, point) in points.into_iter().enumerate() {
            self.x[corner][lane] = point.xy.x;
            self.y[corner][lane] = point.xy.y;
            self.w[corner][lane] = point.w;
        }
    }

    /// Gives all lanes the same triangle.
    #[inline(always)]
    pub(super) fn set_all(&mut self, points: [&PicturePoint; 3], leeway: f32) {
        self.leeway = Lanes::splat(leeway);
        for (corner, point) in points.into_iter().enumerate() {
            self.x[corner] = Lanes::splat(point.xy.x);
            self.y[corner] = Lanes::splat(point.xy.y);
            self.w[corner] = Lanes::splat(point.w);
        }
    }

    #[inline(always)]
    pub(super) fn set_position(&mut self, lane: usize, at: Vec2) {
        (self.at_x[lane], self.at_y[lane]) = (at.x, at.y);
    }
}

/// Weights of the second and third corner, their change along x, and along y: eight of each.
pub(super) type Weights = [Lanes; 6];

/// The barycentric coordinates of eight triangles.
///
/// Positions outside by more than the leeway (samples lie inside the *snapped* triangle, a hair outside this one) are
/// moved to where it ends. A triangle that is exactly edge-on gives its middle, without change.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of many arrays, for the vectoriser
pub(super) fn weights(corners: &CornerLanes, out: &mut Weights) {
    // All loads come first and nothing branches, so that the loop becomes vector instructions.
    for i in 0..LANES {
        let (px, py) = (corners.at_x[i], corners.at_y[i]);
        let [xa, xb, xc] = [corners.x[0][i], corners.x[1][i], corners.x[2][i]];
        let [ya, yb, yc] = [corners.y[0][i], corners.y[1][i], corners.y[2][i]];
        let [wa, wb, wc] = [corners.w[0][i], corners.w[1][i], corners.w[2][i]];
        let leeway = corners.leeway[i];
        // All weights change alike with the size of the points: a power of two keeps products within range. The
        // largest number has the largest bits.
        let size = |value: f32| value.to_bits() & 0x7fff_ffff;
        let of_x = size(xa).max(size(xb)).max(size(xc));
        let of_y = size(ya).max(size(yb)).max(size(yc));
        let of_w = size(wa).max(size(wb)).max(size(wc));
        let exponent = (of_x.max(of_y).max(of_w) & 0x7f80_0000).min(0x7e80_0000);
        let scale = f32::from_bits(0x7f00_0000 - exponent);
        let (wa, wb, wc) = (wa * scale, wb * scale, wc * scale);
        // From the position: differences of large products would lose the small triangles.
        let (xa, xb, xc) = (xa * scale - px * wa, xb * scale - px * wb, xc * scale - px * wc);
        let (ya, yb, yc) = (ya * scale - py * wa, yb * scale - py * wb, yc * scale - py * wc);
        let (na, nb, nc) = (xb * yc - xc * yb, xc * ya - xa * yc, xa * yb - xb * ya);
        let (na_dx, nb_dx, nc_dx) = (yb * wc - yc * wb, yc * wa - ya * wc, ya * wb - yb * wa);
        let (na_dy, nb_dy, nc_dy) = (xc * wb - xb * wc, xa * wc - xc * wa, xb * wa - xa * wb);
        let inverse = 1.0 / (na + nb + nc);
        let (sum_dx, sum_dy) = (na_dx + nb_dx + nc_dx, na_dy + nb_dy + nc_dy);
        let (b, c) = (nb * inverse, nc * inverse);
        let (b_dx, c_dx) = ((nb_dx - b * sum_dx) * inverse, (nc_dx - c * sum_dx) * inverse);
        let (b_dy, c_dy) = ((nb_dy - b * sum_dy) * inverse, (nc_dy - c * sum_dy) * inverse);
        let total = b.abs() + c.abs() + b_dx.abs() + c_dx.abs() + b_dy.abs() + c_dy.abs();
        let usable = total < f32::MAX;
        let (b, c) = (clamp(b, -leeway, 1.0 + leeway), clamp(c, -leeway, 1.0 + leeway));
        // Keeps the sum at 1 when the first weight would be negative.
        let excess = (b + c - 1.0 - leeway) * 0.5;
        let excess = if excess > 0.0 { excess } else { 0.0 };
        let (b, c) = (b - excess, c - excess);
        let (b, c) = (if b > -leeway { b } else { -leeway }, if c > -leeway { c } else { -leeway });
        out[0][i] = if usable { b } else { 1.0 / 3.0 };
        out[1][i] = if usable { c } else { 1.0 / 3.0 };
        out[2][i] = if usable { b_dx } else { 0.0 };
        out[3][i] = if usable { c_dx } else { 0.0 };
        out[4][i] = if usable { b_dy } else { 0.0 };
        out[5][i] = if usable { c_dy } else { 0.0 };
    }
}

/// Brings a value into a range; the library's panics where the range is none, and is a branch.
#[inline(always)]
fn clamp(value: f32, low: f32, high: f32) -> f32 {
    let value = if value > low { value } else { low };
    if value < high { value } else { high }
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
#[inline(always)] // for the instructions of its caller
pub fn barycentrics(points: [&PicturePoint; 3], at: Vec2, leeway: f32) -> Barycentrics {
    let (mut corners, mut out) = (CornerLanes::default(), Weights::default());
    corners.set(0, points, leeway);
    corners.set_position(0, at);
    weights(&corners, &mut out);
    lane(&out, 0)
}
