//! Four neighbouring texels: where between them does the normal agree with the half vector?

use super::law::Law;
use crate::find::virtual_objects::outer;
use crate::reflector_search::image::SurfaceTexel;
use catoptric_core::math::lanes::Vec3Lanes;
use glam::{Mat2, Mat3, Vec2, Vec3};

/// Newton's method on the bilinear form. Chosen, not measured.
pub(in super::super) const STEPS: u32 = 3;

/// A place this far outside a cell (of side 1) means little. Chosen, not measured.
pub(in super::super) const FAR: f32 = 1.5;

/// A corner of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct TexelCorner {
    pub(in super::super) position: Vec3,
    /// The unit normal on the side that is met.
    pub(in super::super) normal: Vec3,
    /// The half vector less the normal.
    pub(in super::super) miss: Vec3,
}

/// Texels side by side, component by component: the compiler makes vector instructions of loops over them.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Ends<const LANES: usize> {
    pub(in super::super) position: Vec3Lanes<LANES>,
    /// The normals on the side that is met.
    pub(in super::super) normal: Vec3Lanes<LANES>,
    pub(in super::super) origin: Vec3Lanes<LANES>,
}

impl<const LANES: usize> Ends<LANES> {
    /// Takes a texel, and where the ray comes from that arrives there.
    #[inline(always)] // for the instructions of its caller
    pub(in super::super) fn set(&mut self, lane: usize, texel: &SurfaceTexel, side: f32, origin: Vec3) {
        self.position.set(lane, texel.position);
        self.normal.set(lane, texel.normal * side);
        self.origin.set(lane, origin);
    }

    /// Differences of half vectors to points, as of [`Law::half`], and normals.
    #[inline(always)] // for the instructions of its caller
    pub(in super::super) fn misses(&self, law: &Law, points: &Vec3Lanes<LANES>) -> Vec3Lanes<LANES> {
        let mut miss = Vec3Lanes::ZERO;
        for lane in 0..LANES {
            let [p, n, o, to] = [&self.position, &self.normal, &self.origin, points].map(|of| of.components(lane));
            let (back, on) = ([o[0] - p[0], o[1] - p[1], o[2] - p[2]], [to[0] - p[0], to[1] - p[1], to[2] - p[2]]);
            let scale = |v: [f32; 3], by: f32| by / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            let (before, after) = (scale(back, law.eta), scale(on, 1.0));
            let sum = [0, 1, 2].map(|axis: usize| back[axis] * before + on[axis] * after);
            let unit = scale(sum, law.sign);
            for axis in 0..3 {
                miss[axis][lane] = sum[axis] * unit - n[axis];
            }
        }
        miss
    }
}

impl Ends<4> {
    /// The corners of a cell with their misses.
    #[inline]
    pub(in super::super) fn corners(&self, law: &Law, point: Vec3) -> [TexelCorner; 4] {
        let miss = self.misses(law, &Vec3Lanes::splat(point));
        let corner = |lane| TexelCorner {
            position: self.position.vector(lane),
            normal: self.normal.vector(lane),
            miss: miss.vector(lane),
        };
        [corner(0), corner(1), corner(2), corner(3)]
    }
}

/// Four neighbouring texels, row by row.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct TexelCell {
    pub(in super::super) corners: [TexelCorner; 4],
    /// The face and the low corner.
    pub(in super::super) face: u32,
    pub(in super::super) low: Vec2,
    /// The point where the misses are zero, from the low corner; it may lie outside.
    pub(in super::super) zero: Vec2,
    /// True if the misses turn the other way round than places do.
    pub(in super::super) turns: bool,
    /// The sum of the squared misses.
    pub(in super::super) miss: f32,
}

/// Interpolated surface and law at a place in a cell.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct CellSpot {
    pub(in super::super) position: Vec3,
    pub(in super::super) normal: Vec3,
    pub(in super::super) position_change: Mat3,
    pub(in super::super) normal_change: Mat3,
    /// The distance between the unit normal and the unit half vector.
    pub(in super::super) tilt: f32,
}

/// Bilinear values between four corners, and their changes to the right and down.
#[inline]
fn between(values: [Vec3; 4], at: Vec2) -> [Vec3; 3] {
    let [a, b, c, d] = values;
    let (right, down, twist) = (b - a, c - a, d - c - (b - a));
    [a + right * at.x + down * at.y + twist * (at.x * at.y), right + twist * at.y, down + twist * at.x]
}

impl TexelCell {
    /// The cell of four corners; returns `None` if its misses are not finite.
    #[inline]
    pub(in super::super) fn new(face: u32, low: Vec2, corners: [TexelCorner; 4]) -> Option<Self> {
        let miss: f32 = corners.iter().map(|corner| corner.miss.length_squared()).sum();
        let mut cell = Self { corners, face, low, zero: Vec2::splat(0.5), turns: false, miss };
        let [right, down] = cell.tangents();
        let form = corners.map(|corner| Vec2::new(corner.miss.dot(right), corner.miss.dot(down)));
        let [a, b, c, d] = form;
        let (to_right, to_down, twist) = (b - a, c - a, d - c - (b - a));
        for _ in 0..STEPS {
            let at = cell.zero;
            let value = a + to_right * at.x + to_down * at.y + twist * (at.x * at.y);
            let slope = Mat2::from_cols(to_right + twist * at.y, to_down + twist * at.x);
            let step = slope.inverse() * value;
            if !step.is_finite() {
                return None;
            }
            cell.zero -= step;
            cell.turns = slope.determinant() < 0.0;
            // Further out the bilinear form bends to nonsense: the first step has the direction.
            if (cell.zero - 0.5).abs().max_element() > FAR || step.length_squared() < 1e-8 {
                break;
            }
        }
        Some(cell)
    }

    /// Mean steps on the surface to the right and down.
    #[inline]
    fn tangents(&self) -> [Vec3; 2] {
        let [a, b, c, d] = self.corners.map(|corner| corner.position);
        [b - a + d - c, c - a + d - b]
    }

    /// The greatest distance of a corner's unit normal from the first one's.
    pub(in super::super) fn bend(&self) -> f32 {
        let first = self.corners[0].normal;
        self.corners.iter().map(|corner| corner.normal.distance(first)).fold(0.0, f32::max)
    }

    /// Surface at a place, from the low corner; `toward` gives the unit direction back along the ray to a position.
    pub(in super::super) fn spot(&self, at: Vec2, law: &Law, point: Vec3, toward: impl Fn(Vec3) -> Vec3) -> CellSpot {
        let [position, right, down] = between(self.corners.map(|corner| corner.position), at);
        let [raw, turn_right, turn_down] = between(self.corners.map(|corner| corner.normal), at);
        let scale = raw.length().recip();
        let normal = raw * scale;
        let half = law.half(position, toward(position), point);
        // The miss stays zero: its change with the point is compensated by a move in the cell.
        let tangents = self.tangents();
        let misses = between(self.corners.map(|corner| corner.miss), at);
        let of = |change: Vec3| Vec2::new(change.dot(tangents[0]), change.dot(tangents[1]));
        let inverse = Mat2::from_cols(of(misses[1]), of(misses[2])).inverse();
        let [first, second] = tangents.map(|tangent| law.change(&half, tangent));
        let moves_right = -(first * inverse.x_axis.x + second * inverse.y_axis.x);
        let moves_down = -(first * inverse.x_axis.y + second * inverse.y_axis.y);
        let bend = (outer(turn_right, moves_right) + outer(turn_down, moves_down)) * scale;
        CellSpot {
            position,
            normal,
            position_change: outer(right, moves_right) + outer(down, moves_down),
            // The derivative of a unit normal is across it.
            normal_change: bend - outer(normal, bend.transpose() * normal),
            tilt: half.unit.distance(normal),
        }
    }
}
