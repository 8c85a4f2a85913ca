//! Our camera: a bundle of rays as polynomials in two surface coordinates.
//!
//! A pinhole is stigmatic, a reflected bundle is not. So a leaf holds, over tangent coordinates `z` about its centre,
//! the reflection point `x(z)` and the outgoing ray as offset `a(z)` and slope `b(z)` across its mean direction. A
//! point at depth `s` and lateral position `l` is on the ray with `a(z) + s b(z) = l`; its image is that of `x(z)`.

use super::answer::Answer;
use super::layout::{BundleLeaf, OUTPUTS, TERMS};
use crate::math::lanes::Lanes;
use glam::{DVec3, Vec3};

/// Steps of Newton's method for a point.
const MOST_STEPS: u32 = 8;

/// The step, in the leaf's size, with which they end: the next one would be about its square.
const LAST_STEP: f32 = 3e-4;

/// On the way coordinates may go further than the leaf's rays, by this in the leaf's size.
const OVERSHOOT: f32 = 0.5;

/// Coordinates of answers that are one differ less than this.
const SAME: f32 = 2e-3;

/// Sums of terms are at most this many times off by rounding.
const ROUNDING: f32 = 1.001;

/// Starts tried at once.
pub(super) const LANES: usize = 8;

/// What the polynomials give.
mod output {
    pub(super) const OFFSET: usize = 3;
    pub(super) const SLOPE: usize = 5;
    pub(super) const ALONG: usize = 7;
    pub(super) const LENGTH: usize = 8;
}

/// Starts of Newton's method in a leaf that folds over, over its extent: points may be on several of its rays.
const STARTS: [[f32; LANES]; 2] =
    [[0.0, -0.9, 0.9, -0.9, 0.9, 0.0, -0.8, 0.8], [0.0, -0.9, -0.9, 0.9, 0.9, -0.8, 0.0, 0.0]];

#[inline(always)]
fn starts(leaf: &BundleLeaf) -> [Lanes<LANES>; 2] {
    let axis = |axis: usize| {
        let (low, high) = (leaf.low[axis], leaf.high[axis]);
        Lanes(STARTS[axis]) * (0.5 * (high - low)) + 0.5 * (low + high)
    };
    [axis(0), axis(1)]
}

/// A polynomial of degree 3 with its changes.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f32; TERMS], [x, y]: [Lanes<N>; 2]) -> [Lanes<N>; 3] {
    let value_x = (x * c[6] + y * c[7] + c[3]) * x + (y * c[8] + c[4]) * y + c[1];
    let value_y = (y * c[9] + c[5]) * y + c[2];
    let by_x = (x * (3.0 * c[6]) + y * (2.0 * c[7]) + 2.0 * c[3]) * x + (y * c[8] + c[4]) * y + c[1];
    let by_y = (x * c[7] + y * (2.0 * c[8]) + c[4]) * x + (y * (3.0 * c[9]) + 2.0 * c[5]) * y + c[2];
    [x * value_x + y * value_y + c[0], by_x, by_y]
}

/// A leaf's rays at the depth of a point.
struct Slice<'a> {
    leaf: &'a BundleLeaf,
    depth: f32,
    /// Their lateral distance from the point: polynomials.
    lateral: [[f32; TERMS]; 2],
}

impl<'a> Slice<'a> {
    #[inline(always)]
    fn new(leaf: &'a BundleLeaf, point: Vec3) -> Self {
        let relative = point - Vec3::from(leaf.origin);
        let depth = relative.dot(leaf.direction.into());
        let mut lateral = [[0.0; TERMS]; 2];
        for (axis, sums) in lateral.iter_mut().enumerate() {
            let (offset, slope) = (&leaf.coefficients[output::OFFSET + axis], &leaf.coefficients[output::SLOPE + axis]);
            for (sum, (offset, slope)) in sums.iter_mut().zip(offset.iter().zip(slope)) {
                *sum = offset + depth * slope;
            }
            sums[0] -= relative.dot(leaf.across[axis].into());
        }
        Self { leaf, depth, lateral }
    }

    /// Whether a ray of the leaf may pass through the point: the polynomials have no larger values than the sums of
    /// their terms' largest.
    #[inline(always)]
    fn may_be_met(&self) -> bool {
        let [x, y] = [0, 1].map(|axis: usize| self.leaf.low[axis].abs().max(self.leaf.high[axis].abs()));
        let largest = [0.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
        self.lateral.iter().all(|sums| {
            let mut most = 0.0;
            for (sum, largest) in sums.iter().zip(largest).skip(1) {
                most += sum.abs() * largest;
            }
            sums[0].abs() <= most * ROUNDING
        })
    }

    /// Newton's method; the coordinates, and which of the lanes have got there.
    #[inline(always)]
    fn solved<const N: usize>(&self, mut z: [Lanes<N>; 2]) -> ([Lanes<N>; 2], [bool; N]) {
        let leaf = self.leaf;
        let (mut done, mut lost) = ([false; N], [false; N]);
        for _ in 0..MOST_STEPS {
            let [u, ux, uy] = polynomial(&self.lateral[0], z);
            let [v, vx, vy] = polynomial(&self.lateral[1], z);
            let determinant = ux * vy - uy * vx;
            let (right, down) = (uy * v - vy * u, vx * u - ux * v);
            let mut going = false;
            for lane in 0..N {
                // Not a number where the rays meet in a line.
                let inverse = 1.0 / determinant.0[lane];
                let (right, down) = (right.0[lane] * inverse, down.0[lane] * inverse);
                let length = right.abs().max(down.abs());
                let stays = done[lane] | lost[lane];
                let scale = if stays { 0.0 } else { 1.0 / length.max(1.0) };
                // What is lost may have no number.
                if !stays {
                    z[0].0[lane] += right * scale;
                    z[1].0[lane] += down * scale;
                }
                let (x, y) = (z[0].0[lane], z[1].0[lane]);
                let inside = (x >= leaf.low[0] - OVERSHOOT)
                    & (x <= leaf.high[0] + OVERSHOOT)
                    & (y >= leaf.low[1] - OVERSHOOT)
                    & (y <= leaf.high[1] + OVERSHOOT);
                lost[lane] |= !inside;
                done[lane] |= length < LAST_STEP;
                going |= !(done[lane] | lost[lane]);
            }
            if !going {
                break;
            }
        }
        for lane in 0..N {
            let within = |axis: usize| (leaf.low[axis]..=leaf.high[axis]).contains(&z[axis].0[lane]);
            done[lane] &= within(0) & within(1) & !lost[lane];
        }
        (z, done)
    }

    /// Whether the leaf's rays fold over at this depth: several of them may pass through the point.
    #[inline(always)]
    fn folds(&self) -> bool {
        let starts = starts(self.leaf);
        let [_, ux, uy] = polynomial(&self.lateral[0], starts);
        let [_, vx, vy] = polynomial(&self.lateral[1], starts);
        let determinant = ux * vy - uy * vx;
        let mut differs = false;
        for lane in 1..LANES {
            differs |= (determinant.0[lane] > 0.0) != (determinant.0[0] > 0.0);
        }
        differs
    }

    /// The ray with given coordinates, which passes through the point; none where it starts beyond it.
    #[inline(always)]
    fn answer(&self, x: f32, y: f32) -> Option<Answer> {
        let (leaf, depth) = (self.leaf, self.depth);
        let mut values = [[0.0; 3]; OUTPUTS];
        for (value, coefficients) in values.iter_mut().zip(&leaf.coefficients) {
            let [at, by_x, by_y] = polynomial(coefficients, [Lanes([x]), Lanes([y])]);
            *value = [at.0[0], by_x.0[0], by_y.0[0]];
        }
        let vector = |change: usize| Vec3::new(values[0][change], values[1][change], values[2][change]);
        let changes = |first: usize| [0, 1].map(|axis: usize| [values[first + axis][1], values[first + axis][2]]);
        let (offset, slope) = (changes(output::OFFSET), changes(output::SLOPE));
        let along = values[output::ALONG][0];
        let [[a, b], [c, d]] =
            [0, 1].map(|axis: usize| [0, 1].map(|change: usize| offset[axis][change] + depth * slope[axis][change]));
        let inverse_determinant = 1.0 / (a * d - b * c);
        let after = depth - along;
        if after <= 0.0 || !inverse_determinant.is_finite() {
            return None;
        }
        let tangents = [vector(1), vector(2)];
        let moves = [
            (tangents[0] * d - tangents[1] * c) * inverse_determinant,
            (tangents[1] * a - tangents[0] * b) * inverse_determinant,
        ];
        let (right, up) = (values[output::SLOPE][0], values[output::SLOPE + 1][0]);
        // What moves a point along its ray moves nothing.
        let direction = Vec3::from(leaf.direction);
        let lateral = [Vec3::from(leaf.across[0]) - direction * right, Vec3::from(leaf.across[1]) - direction * up];
        let last_segment = after * Vec3::new(right, up, 1.0).length();
        Some(Answer {
            first: Vec3::from(leaf.center).as_dvec3() + vector(0).as_dvec3(),
            moves,
            lateral,
            normal: tangents[0].cross(tangents[1]),
            focal_index: focal_points(&offset, &slope, along, depth),
            length: values[output::LENGTH][0] + leaf.medium * last_segment,
            last_segment,
            lateral_error: leaf.offset_error + depth.abs() * leaf.slope_error,
        })
    }
}

/// How many focal points a ray has between two depths: roots of `det(a' + s b')`, a quadratic.
fn focal_points(offset: &[[f32; 2]; 2], slope: &[[f32; 2]; 2], from: f32, to: f32) -> u32 {
    let determinant = |m: &[[f32; 2]; 2], n: &[[f32; 2]; 2]| m[0][0] * n[1][1] - m[0][1] * n[1][0];
    let constant = determinant(offset, offset);
    let linear = determinant(offset, slope) + determinant(slope, offset);
    let square = determinant(slope, slope);
    let at = |depth: f32| constant + depth * (linear + depth * square);
    let (start, end) = (at(from), at(to));
    if start * end < 0.0 {
        return 1;
    }
    let turn = -linear / (2.0 * square);
    if turn > from && turn < to && at(turn) * start < 0.0 { 2 } else { 0 }
}

/// Asks a leaf for a point, wherever on it.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
pub(super) fn ask(leaf: &BundleLeaf, point: Vec3, found: &mut Vec<Answer>) {
    let slice = Slice::new(leaf, point);
    if !slice.may_be_met() {
        return;
    }
    if !slice.folds() {
        let middle = [0, 1].map(|axis: usize| Lanes([0.5 * (leaf.low[axis] + leaf.high[axis])]));
        let (z, done) = slice.solved(middle);
        if done[0] {
            found.extend(slice.answer(z[0].0[0], z[1].0[0]));
        }
        return;
    }
    let (z, done) = slice.solved(starts(leaf));
    for lane in 0..LANES {
        let (x, y) = (z[0].0[lane], z[1].0[lane]);
        let same = |other: usize| done[other] && (z[0].0[other] - x).abs().max((z[1].0[other] - y).abs()) < SAME;
        if done[lane] && !(0..lane).any(same) {
            found.extend(slice.answer(x, y));
        }
    }
}

/// Asks a leaf for the appearance of a point near a first bounce point.
pub(super) fn ask_near(leaf: &BundleLeaf, point: Vec3, first: DVec3) -> Option<Answer> {
    let slice = Slice::new(leaf, point);
    let relative = (first - Vec3::from(leaf.center).as_dvec3()).as_vec3();
    let (z, done) = slice.solved(leaf.tangents.map(|tangent| Lanes([relative.dot(tangent.into())])));
    if done[0] { slice.answer(z[0].0[0], z[1].0[0]) } else { None }
}
