//! Four neighbouring texels: where between them does the normal agree with the half vector?

use super::image::Texel;
use super::law::Law;
use crate::methods::projection::virtual_objects::outer;
use glam::{Mat2, Mat3, Vec2, Vec3};

/// Newton's method on the bilinear form.
pub(super) const STEPS: u32 = 3;

/// A place this far outside a cell (of side 1) means little.
pub(super) const FAR: f32 = 1.5;

/// A corner of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    pub(super) position: Vec3,
    /// The unit normal on the side that is met.
    pub(super) normal: Vec3,
    /// The half vector less the normal.
    pub(super) miss: Vec3,
}

/// Texels side by side, component by component: the compiler makes vector instructions of loops over them.
pub(super) struct Ends<const LANES: usize> {
    pub(super) position: [[f32; LANES]; 3],
    /// On the side that is met.
    pub(super) normal: [[f32; LANES]; 3],
    pub(super) origin: [[f32; LANES]; 3],
}

impl<const LANES: usize> Default for Ends<LANES> {
    fn default() -> Self {
        let zero = [[0.0; LANES]; 3];
        Self { position: zero, normal: zero, origin: zero }
    }
}

impl<const LANES: usize> Ends<LANES> {
    /// Takes a texel, and where the ray comes from that arrives there.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn set(&mut self, lane: usize, texel: &Texel, side: f32, origin: Vec3) {
        for axis in 0..3 {
            self.position[axis][lane] = texel.position[axis];
            self.normal[axis][lane] = texel.normal[axis] * side;
            self.origin[axis][lane] = origin[axis];
        }
    }

    /// The half vectors to points less the normals: what [`Law::half`] says.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn misses(&self, law: &Law, points: &[[f32; LANES]; 3]) -> [[f32; LANES]; 3] {
        let mut miss = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let [p, n, o, to] =
                [&self.position, &self.normal, &self.origin, points].map(|of| [of[0][lane], of[1][lane], of[2][lane]]);
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
    pub(super) fn corners(&self, law: &Law, point: Vec3) -> [Corner; 4] {
        let miss = self.misses(law, &point.to_array().map(|along| [along; 4]));
        let at = |of: &[[f32; 4]; 3], lane: usize| Vec3::new(of[0][lane], of[1][lane], of[2][lane]);
        let corner =
            |lane| Corner { position: at(&self.position, lane), normal: at(&self.normal, lane), miss: at(&miss, lane) };
        [corner(0), corner(1), corner(2), corner(3)]
    }
}

/// Four neighbouring texels, row by row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) corners: [Corner; 4],
    /// The face and the low corner.
    pub(super) face: u32,
    pub(super) low: Vec2,
    /// Where the misses are zero, from the low corner; may lie outside.
    pub(super) zero: Vec2,
    /// Whether the misses turn the other way round than places do.
    pub(super) turns: bool,
    /// The sum of the squared misses.
    pub(super) miss: f32,
}

/// What a cell says about a place in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    pub(super) position_change: Mat3,
    pub(super) normal_change: Mat3,
    /// How far the normal is from the half vector.
    pub(super) tilt: f32,
}

/// What is bilinear between four corners, and its changes to the right and down.
#[inline]
fn between(values: [Vec3; 4], at: Vec2) -> [Vec3; 3] {
    let [a, b, c, d] = values;
    let (right, down, twist) = (b - a, c - a, d - c - (b - a));
    [a + right * at.x + down * at.y + twist * (at.x * at.y), right + twist * at.y, down + twist * at.x]
}

impl Cell {
    /// The cell of four corners; `None` where its misses say nothing.
    #[inline]
    pub(super) fn new(face: u32, low: Vec2, corners: [Corner; 4]) -> Option<Self> {
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
            // Further out the bilinear form bends to nonsense: the first step says the direction.
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

    /// How far normals are apart in the cell.
    pub(super) fn bend(&self) -> f32 {
        let first = self.corners[0].normal;
        self.corners.iter().map(|corner| corner.normal.distance(first)).fold(0.0, f32::max)
    }

    /// What lies at a place, from the low corner; `toward` says where a ray to a position comes from.
    pub(super) fn spot(&self, at: Vec2, law: &Law, point: Vec3, toward: impl Fn(Vec3) -> Vec3) -> Spot {
        let [position, right, down] = between(self.corners.map(|corner| corner.position), at);
        let [raw, turn_right, turn_down] = between(self.corners.map(|corner| corner.normal), at);
        let scale = raw.length().recip();
        let normal = raw * scale;
        let half = law.half(position, toward(position), point);
        // The zero stays zero: what moves with the point is made good by moving in the cell.
        let tangents = self.tangents();
        let misses = between(self.corners.map(|corner| corner.miss), at);
        let of = |change: Vec3| Vec2::new(change.dot(tangents[0]), change.dot(tangents[1]));
        let inverse = Mat2::from_cols(of(misses[1]), of(misses[2])).inverse();
        let [first, second] = tangents.map(|tangent| law.change(&half, tangent));
        let moves_right = -(first * inverse.x_axis.x + second * inverse.y_axis.x);
        let moves_down = -(first * inverse.x_axis.y + second * inverse.y_axis.y);
        let bend = (outer(turn_right, moves_right) + outer(turn_down, moves_down)) * scale;
        Spot {
            position,
            normal,
            position_change: outer(right, moves_right) + outer(down, moves_down),
            // Of a unit normal: across it.
            normal_change: bend - outer(normal, bend.transpose() * normal),
            tilt: half.unit.distance(normal),
        }
    }
}
