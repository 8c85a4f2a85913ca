//! Our camera: a bundle of rays as polynomials in two surface coordinates.
//!
//! A pinhole is stigmatic, a reflected bundle is not. So a leaf holds, over tangent coordinates `z` about its centre,
//! the reflection point `x(z)` and the outgoing ray as offset `a(z)` and slope `b(z)` across its mean direction. A
//! point at depth `s` and lateral position `l` is on the ray with `a(z) + s b(z) = l`; its image is that of `x(z)`.

use super::camera_projection::CameraProjection;
use crate::sample_based_camera::layout::{BundleLeaf, OUTPUTS, TERMS};
use catoptric_core::math::lanes::{LANES, Lanes};
use glam::{DVec3, Vec3};

/// Steps of Newton's method for a point. A bound on time; chosen, not measured.
const MAX_STEPS: u32 = 8;

/// The step, in the leaf's size, with which they end: the next one would be about its square. That is the rounding of
/// single precision.
const LAST_STEP: f32 = 3e-4;

/// The distance that coordinates may leave a leaf's rays on the way to a solution, in the leaf's size. Chosen, not
/// measured.
const OVERSHOOT: f32 = 0.5;

/// Coordinates of answers that are one differ less than this. Chosen, not measured.
const SAME: f32 = 2e-3;

/// Sums of terms are at most this many times off by rounding. Chosen well above rounding, not measured.
const ROUNDING: f32 = 1.001;

/// Values of the polynomials.
mod output {
    pub(in super::super) const OFFSET: usize = 3;
    pub(in super::super) const SLOPE: usize = 5;
    pub(in super::super) const ALONG: usize = 7;
    pub(in super::super) const LENGTH: usize = 8;
}

/// The middles of the boxes that a leaf's coordinates are cut into, four along one axis and two along the other, and
/// the boxes' sizes, as shares of half the leaf's extent.
const ALONG: Lanes = Lanes([-0.75, -0.25, 0.25, 0.75, -0.75, -0.25, 0.25, 0.75]);
const ACROSS: Lanes = Lanes([-0.5, -0.5, -0.5, -0.5, 0.5, 0.5, 0.5, 0.5]);
const ALONG_SIZE: f32 = 0.25;
const ACROSS_SIZE: f32 = 0.5;

/// A polynomial of degree 3 with its changes.
#[inline(always)]
fn polynomial<const N: usize>(c: &[f32; TERMS], [x, y]: [Lanes<N>; 2]) -> [Lanes<N>; 3] {
    let value_x = (x * c[6] + y * c[7] + c[3]) * x + (y * c[8] + c[4]) * y + c[1];
    let value_y = (y * c[9] + c[5]) * y + c[2];
    let by_x = (x * (3.0 * c[6]) + y * (2.0 * c[7]) + 2.0 * c[3]) * x + (y * c[8] + c[4]) * y + c[1];
    let by_y = (x * c[7] + y * (2.0 * c[8]) + c[4]) * x + (y * (3.0 * c[9]) + 2.0 * c[5]) * y + c[2];
    [x * value_x + y * value_y + c[0], by_x, by_y]
}

/// Parts of a leaf's coordinates.
struct Boxes {
    middles: [Lanes; 2],
    /// The step from each middle to the expected coordinates of the ray through the point.
    steps: [Lanes; 2],
    /// 1 for those in which there may be a ray through the point.
    may: [u32; LANES],
    /// True if there may be in any.
    any: bool,
    /// True if the leaf's rays fold over at this depth: several of them may pass through the point.
    folds: bool,
}

impl Boxes {
    /// The expected coordinates of the ray through the point, from the box that is nearest to them.
    #[inline(always)]
    fn nearest(&self) -> [Lanes<1>; 2] {
        let (mut nearest, mut best) = (f32::INFINITY, [Lanes([0.0]); 2]);
        for lane in 0..LANES {
            let [right, down] = [self.steps[0][lane], self.steps[1][lane]];
            let length = right.abs().max(down.abs());
            if self.may[lane] == 1 && length < nearest {
                nearest = length;
                best = [Lanes([self.middles[0][lane] + right]), Lanes([self.middles[1][lane] + down])];
            }
        }
        best
    }
}

/// A bound of the difference between a polynomial and its expansion to first order, within `size` of anywhere in a leaf
/// whose coordinates are at most `most`.
#[inline(always)]
fn rest(c: &[f32; TERMS], most: [f32; 2], size: [f32; 2]) -> f32 {
    let xx = c[3].abs() + 3.0 * c[6].abs() * most[0] + c[7].abs() * most[1];
    let xy = c[4].abs() + 2.0 * c[7].abs() * most[0] + 2.0 * c[8].abs() * most[1];
    let yy = c[5].abs() + c[8].abs() * most[0] + 3.0 * c[9].abs() * most[1];
    xx * size[0] * size[0] + xy * size[0] * size[1] + yy * size[1] * size[1]
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
        for (term, row) in leaf.coefficients.iter().enumerate() {
            for (axis, sums) in lateral.iter_mut().enumerate() {
                sums[term] = row[output::OFFSET + axis] + depth * row[output::SLOPE + axis];
            }
        }
        for (sums, across) in lateral.iter_mut().zip(&leaf.across) {
            sums[0] -= relative.dot(Vec3::from(*across));
        }
        Self { leaf, depth, lateral }
    }

    /// The boxes of coordinates in which rays through the point may be.
    ///
    /// In a box the lateral distance is its first-order expansion about the middle but for terms of higher order, which
    /// are no larger than the sums of their largest values. This bounds it in any direction: along its two components,
    /// and across the images of the coordinates' axes.
    #[inline(always)]
    fn boxes(&self) -> Boxes {
        let [u, v] = &self.lateral;
        let (low, high) = (&self.leaf.low, &self.leaf.high);
        let half = [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])];
        let most = [low[0].abs().max(high[0].abs()), low[1].abs().max(high[1].abs())];
        // The axis that bends more is cut into more boxes.
        let bends = |term: usize, axis: usize| u[term].abs().max(v[term].abs()) * half[axis] * half[axis];
        let axis = usize::from(bends(5, 1) > bends(3, 0));
        let mut middles = [Lanes::ZERO; 2];
        middles[axis] = ALONG * half[axis] + 0.5 * (low[axis] + high[axis]);
        middles[1 - axis] = ACROSS * half[1 - axis] + 0.5 * (low[1 - axis] + high[1 - axis]);
        let mut size = [0.0; 2];
        size[axis] = half[axis] * ALONG_SIZE;
        size[1 - axis] = half[1 - axis] * ACROSS_SIZE;
        // The remainders along the components, and across the images of the axes in the middle of the leaf: near a
        // caustic, where these images are about parallel, that is much less.
        let (mut right, mut down) = ([0.0; TERMS], [0.0; TERMS]);
        for term in 3..TERMS {
            right[term] = u[2] * v[term] - v[2] * u[term];
            down[term] = v[1] * u[term] - u[1] * v[term];
        }
        let left = [rest(u, most, size), rest(v, most, size), rest(&right, most, size), rest(&down, most, size)];
        let gradients = [u[1], u[2], v[1], v[2]];
        let [u, ux, uy] = polynomial(u, middles);
        let [v, vx, vy] = polynomial(v, middles);
        let determinant = ux * vy - uy * vx;
        let (mut right, mut down) = (uy * v - vy * u, vx * u - ux * v);
        let mut may = [0u32; LANES];
        let (mut any, mut folds) = (0, 0);
        for (lane, may) in may.iter_mut().enumerate() {
            let (a, b) = (ux[lane], uy[lane]);
            let (c, d) = (vx[lane], vy[lane]);
            let area = determinant[lane].abs();
            let most = [
                a.abs() * size[0] + b.abs() * size[1] + left[0],
                c.abs() * size[0] + d.abs() * size[1] + left[1],
                area * size[0] + left[2] + (d - gradients[3]).abs() * left[0] + (b - gradients[1]).abs() * left[1],
                area * size[1] + left[3] + (c - gradients[2]).abs() * left[0] + (a - gradients[0]).abs() * left[1],
            ];
            let met = u32::from(u[lane].abs() <= ROUNDING * most[0])
                & u32::from(v[lane].abs() <= ROUNDING * most[1])
                & u32::from(right[lane].abs() <= ROUNDING * most[2])
                & u32::from(down[lane].abs() <= ROUNDING * most[3]);
            *may = met;
            let inverse = 1.0 / determinant[lane];
            right[lane] *= inverse;
            down[lane] *= inverse;
            any |= met;
            folds |= u32::from((determinant[lane] > 0.0) != (determinant[0] > 0.0));
        }
        Boxes { middles, steps: [right, down], may, any: any == 1, folds: folds == 1 }
    }

    /// Newton's method in the lanes that are `going` (1: numbers, for vector instructions); the coordinates, and which
    /// of the lanes have got there.
    #[inline(always)]
    fn solved<const N: usize>(&self, mut z: [Lanes<N>; 2], mut going: [u32; N]) -> ([Lanes<N>; 2], [bool; N]) {
        let leaf = self.leaf;
        let mut done = [0u32; N];
        for _ in 0..MAX_STEPS {
            let [u, ux, uy] = polynomial(&self.lateral[0], z);
            let [v, vx, vy] = polynomial(&self.lateral[1], z);
            let determinant = ux * vy - uy * vx;
            let (right, down) = (uy * v - vy * u, vx * u - ux * v);
            let mut any = 0;
            for lane in 0..N {
                // Where the rays meet in a line this is not a number.
                let inverse = 1.0 / determinant[lane];
                let (right, down) = (right[lane] * inverse, down[lane] * inverse);
                let length = right.abs().max(down.abs());
                let scale = 1.0 / length.max(1.0);
                let (x, y) = (z[0][lane] + right * scale, z[1][lane] + down * scale);
                let inside = u32::from(x >= leaf.low[0] - OVERSHOOT)
                    & u32::from(x <= leaf.high[0] + OVERSHOOT)
                    & u32::from(y >= leaf.low[1] - OVERSHOOT)
                    & u32::from(y <= leaf.high[1] + OVERSHOOT);
                let steps = going[lane] & inside;
                // Lost lanes may not be numbers.
                z[0][lane] = if steps == 1 { x } else { z[0][lane] };
                z[1][lane] = if steps == 1 { y } else { z[1][lane] };
                let arrives = steps & u32::from(length < LAST_STEP);
                done[lane] |= arrives;
                going[lane] = steps & (1 - arrives);
                any |= going[lane];
            }
            if any == 0 {
                break;
            }
        }
        let mut found = [false; N];
        for lane in 0..N {
            let (x, y) = (z[0][lane], z[1][lane]);
            let within = (x >= leaf.low[0]) & (x <= leaf.high[0]) & (y >= leaf.low[1]) & (y <= leaf.high[1]);
            found[lane] = done[lane] == 1 && within;
        }
        (z, found)
    }

    /// The ray with given coordinates, which passes through the point; returns `None` if it starts beyond it.
    #[inline(always)]
    fn answer(&self, x: f32, y: f32) -> Option<CameraProjection> {
        let (leaf, depth) = (self.leaf, self.depth);
        let basis = [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
        let by_x = [0.0, 1.0, 0.0, 2.0 * x, y, 0.0, 3.0 * x * x, 2.0 * x * y, y * y, 0.0];
        let by_y = [0.0, 0.0, 1.0, 0.0, x, 2.0 * y, 0.0, x * x, 2.0 * x * y, 3.0 * y * y];
        // The values of all outputs, and their changes.
        let mut values = [[0.0; OUTPUTS]; 3];
        for (term, row) in leaf.coefficients.iter().enumerate() {
            for output in 0..OUTPUTS {
                values[0][output] += basis[term] * row[output];
                values[1][output] += by_x[term] * row[output];
                values[2][output] += by_y[term] * row[output];
            }
        }
        let vector = |change: usize| Vec3::new(values[change][0], values[change][1], values[change][2]);
        let changes = |output: usize| [values[1][output], values[2][output]];
        let offset = [changes(output::OFFSET), changes(output::OFFSET + 1)];
        let slope = [changes(output::SLOPE), changes(output::SLOPE + 1)];
        let along = values[0][output::ALONG];
        let (a, b) = (offset[0][0] + depth * slope[0][0], offset[0][1] + depth * slope[0][1]);
        let (c, d) = (offset[1][0] + depth * slope[1][0], offset[1][1] + depth * slope[1][1]);
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
        let (right, up) = (values[0][output::SLOPE], values[0][output::SLOPE + 1]);
        // A step of the point along its ray moves nothing.
        let direction = Vec3::from(leaf.direction);
        let lateral = [Vec3::from(leaf.across[0]) - direction * right, Vec3::from(leaf.across[1]) - direction * up];
        let last_segment = after * Vec3::new(right, up, 1.0).length();
        Some(CameraProjection {
            first: Vec3::from(leaf.center).as_dvec3() + vector(0).as_dvec3(),
            moves,
            lateral,
            normal: tangents[0].cross(tangents[1]),
            focal_index: focal_points(&offset, &slope, along, depth),
            length: values[0][output::LENGTH] + leaf.medium * last_segment,
            last_segment,
            lateral_error: leaf.offset_error + depth.abs() * leaf.slope_error,
        })
    }
}

/// Number of focal points of a ray between two depths: roots of `det(a' + s b')`, a quadratic.
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
pub(in super::super) fn ask(leaf: &BundleLeaf, point: Vec3, found: &mut Vec<CameraProjection>) {
    let slice = Slice::new(leaf, point);
    let boxes = slice.boxes();
    if !boxes.any {
        return;
    }
    if !boxes.folds {
        let (z, done) = slice.solved(boxes.nearest(), [1]);
        if done[0] {
            found.extend(slice.answer(z[0][0], z[1][0]));
        }
        return;
    }
    let (z, done) = slice.solved(boxes.middles, boxes.may);
    for lane in 0..LANES {
        let (x, y) = (z[0][lane], z[1][lane]);
        let same = |other: usize| done[other] && (z[0][other] - x).abs().max((z[1][other] - y).abs()) < SAME;
        if done[lane] && !(0..lane).any(same) {
            found.extend(slice.answer(x, y));
        }
    }
}

/// Asks a leaf for the appearance of a point near a first bounce point.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
pub(in super::super) fn ask_near(leaf: &BundleLeaf, point: Vec3, first: DVec3) -> Option<CameraProjection> {
    let slice = Slice::new(leaf, point);
    let relative = (first - Vec3::from(leaf.center).as_dvec3()).as_vec3();
    let start = [Lanes([relative.dot(leaf.tangents[0].into())]), Lanes([relative.dot(leaf.tangents[1].into())])];
    let (z, done) = slice.solved(start, [1]);
    if done[0] { slice.answer(z[0][0], z[1][0]) } else { None }
}
