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

/// Starts tried at once.
pub(super) const LANES: usize = 8;

/// What the polynomials give.
mod output {
    pub(super) const FIRST: usize = 0;
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
    [0, 1].map(|axis: usize| {
        let (low, high) = (leaf.low[axis], leaf.high[axis]);
        Lanes(STARTS[axis]).map(|share| 0.5 * (low + high) + 0.5 * share * (high - low))
    })
}

/// A polynomial of degree 3 with its changes.
#[inline(always)]
fn polynomial<const N: usize>(c: &[Lanes<N>; TERMS], [x, y]: [Lanes<N>; 2]) -> [Lanes<N>; 3] {
    let value = c[0]
        + x * (c[1] + x * (c[3] + c[6] * x + c[7] * y) + y * (c[4] + c[8] * y))
        + y * (c[2] + y * (c[5] + c[9] * y));
    let by_x = c[1] + x * (c[3] * 2.0 + c[6] * 3.0 * x + c[7] * 2.0 * y) + y * (c[4] + c[8] * y);
    let by_y = c[2] + x * (c[4] + c[7] * x + c[8] * 2.0 * y) + y * (c[5] * 2.0 + c[9] * 3.0 * y);
    [value, by_x, by_y]
}

/// Points relative to a leaf.
struct Slice<const N: usize> {
    depth: Lanes<N>,
    /// Lateral distance of the leaf's rays, at the points' depths, from the points: polynomials.
    lateral: [[Lanes<N>; TERMS]; 2],
}

impl<const N: usize> Slice<N> {
    #[inline(always)]
    fn new(leaf: &BundleLeaf, point: [Lanes<N>; 3]) -> Self {
        let relative = [0, 1, 2].map(|axis: usize| point[axis].map(|value| value - leaf.origin[axis]));
        let dot = |axis: &[f32; 3]| relative[0] * axis[0] + relative[1] * axis[1] + relative[2] * axis[2];
        let depth = dot(&leaf.direction);
        let lateral = [0, 1].map(|axis: usize| {
            let (offset, slope) = (&leaf.coefficients[output::OFFSET + axis], &leaf.coefficients[output::SLOPE + axis]);
            let mut sums: [Lanes<N>; TERMS] =
                std::array::from_fn(|term| depth.map(|depth| offset[term] + depth * slope[term]));
            sums[0] = sums[0] - dot(&leaf.across[axis]);
            sums
        });
        Self { depth, lateral }
    }

    /// Whether a ray of the leaf may pass through one of the points: the polynomials have no larger values than the
    /// sums of their terms' largest.
    #[inline(always)]
    fn may_be_met(&self, leaf: &BundleLeaf) -> bool {
        let extent = [0, 1].map(|axis: usize| leaf.low[axis].abs().max(leaf.high[axis].abs()));
        let [x, y] = extent;
        let largest = [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
        (0..N).any(|lane| {
            self.lateral.iter().all(|sums| {
                let most: f32 = (1..TERMS).map(|term| sums[term].0[lane].abs() * largest[term]).sum();
                sums[0].0[lane].abs() <= most * 1.001
            })
        })
    }

    /// Newton's method; the coordinates, and which of the lanes have got there.
    #[inline(always)]
    fn solved(&self, leaf: &BundleLeaf, mut z: [Lanes<N>; 2]) -> ([Lanes<N>; 2], [bool; N]) {
        let mut done = [false; N];
        let mut lost = [false; N];
        for _ in 0..MOST_STEPS {
            let [u, ux, uy] = polynomial(&self.lateral[0], z);
            let [v, vx, vy] = polynomial(&self.lateral[1], z);
            let determinant = ux * vy - uy * vx;
            let right = (uy * v - vy * u).zip(determinant, |step, determinant| step / determinant);
            let down = (vx * u - ux * v).zip(determinant, |step, determinant| step / determinant);
            let mut going = false;
            for lane in 0..N {
                let (right, down) = (right.0[lane], down.0[lane]);
                let length = right.abs().max(down.abs());
                // Not a number where the rays meet in a line.
                let shorter = if length > 1.0 { 1.0 / length } else { 1.0 };
                if !(done[lane] | lost[lane]) {
                    z[0].0[lane] += right * shorter;
                    z[1].0[lane] += down * shorter;
                }
                let outside = (0..2).any(|axis| {
                    let value = z[axis].0[lane];
                    !(value >= leaf.low[axis] - OVERSHOOT && value <= leaf.high[axis] + OVERSHOOT)
                });
                lost[lane] |= outside;
                done[lane] |= length < LAST_STEP;
                going |= !(done[lane] | lost[lane]);
            }
            if !going {
                break;
            }
        }
        for lane in 0..N {
            let within = (0..2).all(|axis| (leaf.low[axis]..=leaf.high[axis]).contains(&z[axis].0[lane]));
            done[lane] &= within & !lost[lane];
        }
        (z, done)
    }

    /// Whether the leaf's rays fold over at the first point's depth: several of them may pass through it.
    #[inline(always)]
    fn folds(&self, leaf: &BundleLeaf) -> bool {
        let first = self.lateral.map(|sums| sums.map(|sum| Lanes::<LANES>::splat(sum.0[0])));
        let starts = starts(leaf);
        let [_, ux, uy] = polynomial(&first[0], starts);
        let [_, vx, vy] = polynomial(&first[1], starts);
        let determinant = ux * vy - uy * vx;
        determinant.0.iter().any(|other| (*other > 0.0) != (determinant.0[0] > 0.0))
    }
}

/// The rays of a leaf that pass through its points.
#[inline(always)]
fn evaluated<const N: usize>(
    leaf: &BundleLeaf,
    slice: &Slice<N>,
    z: [Lanes<N>; 2],
    done: [bool; N],
    mut found: impl FnMut(usize, Answer),
) {
    if !done.contains(&true) {
        return;
    }
    let values: [[Lanes<N>; 3]; OUTPUTS] =
        std::array::from_fn(|output| polynomial(&leaf.coefficients[output].map(Lanes::splat), z));
    for lane in 0..N {
        if done[lane] {
            let at = |output: usize, change: usize| values[output][change].0[lane];
            let tangent = |change: usize| {
                Vec3::new(at(output::FIRST, change), at(output::FIRST + 1, change), at(output::FIRST + 2, change))
            };
            let offset = [0, 1].map(|axis: usize| [1, 2].map(|change| at(output::OFFSET + axis, change)));
            let slope = [0, 1].map(|axis: usize| [1, 2].map(|change| at(output::SLOPE + axis, change)));
            let depth = slice.depth.0[lane];
            let along = at(output::ALONG, 0);
            let matrix: [[f32; 2]; 2] = [0, 1]
                .map(|axis: usize| [0, 1].map(|change: usize| offset[axis][change] + depth * slope[axis][change]));
            let [[a, b], [c, d]] = matrix;
            let inverse_determinant = 1.0 / (a * d - b * c);
            let after = depth - along;
            if after <= 0.0 || !inverse_determinant.is_finite() {
                continue;
            }
            let tangents = [tangent(1), tangent(2)];
            let moves = [
                (tangents[0] * d - tangents[1] * c) * inverse_determinant,
                (tangents[1] * a - tangents[0] * b) * inverse_determinant,
            ];
            let (right, up) = (at(output::SLOPE, 0), at(output::SLOPE + 1, 0));
            // What moves a point along its ray moves nothing.
            let direction = Vec3::from(leaf.direction);
            let lateral = [Vec3::from(leaf.across[0]) - direction * right, Vec3::from(leaf.across[1]) - direction * up];
            let last_segment = after * Vec3::new(right, up, 1.0).length();
            found(
                lane,
                Answer {
                    first: Vec3::from(leaf.center).as_dvec3() + tangent(0).as_dvec3(),
                    moves,
                    lateral,
                    normal: tangents[0].cross(tangents[1]),
                    focal_index: focal_points(&offset, &slope, along, depth),
                    length: at(output::LENGTH, 0) + leaf.medium * last_segment,
                    last_segment,
                    lateral_error: leaf.offset_error + depth.abs() * leaf.slope_error,
                },
            );
        }
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
    let slice = Slice::<1>::new(leaf, point.to_array().map(|value| Lanes([value])));
    if !slice.may_be_met(leaf) {
        return;
    }
    if slice.folds(leaf) {
        let all = Slice::<LANES> {
            depth: Lanes::splat(slice.depth.0[0]),
            lateral: slice.lateral.map(|sums| sums.map(|sum| Lanes::splat(sum.0[0]))),
        };
        let (z, done) = all.solved(leaf, starts(leaf));
        let start = found.len();
        evaluated(leaf, &all, z, done, |_, answer| {
            let same = |other: &Answer| {
                other.focal_index == answer.focal_index
                    && other.first.distance(answer.first) < 1e-3 * f64::from(leaf.size)
            };
            if !found[start..].iter().any(same) {
                found.push(answer);
            }
        });
    } else {
        let (z, done) = slice.solved(leaf, [Lanes([0.0]); 2]);
        evaluated(leaf, &slice, z, done, |_, answer| found.push(answer));
    }
}

/// Asks a leaf for the appearance of a point near a first bounce point.
pub(super) fn ask_near(leaf: &BundleLeaf, point: Vec3, first: DVec3) -> Option<Answer> {
    let slice = Slice::<1>::new(leaf, point.to_array().map(|value| Lanes([value])));
    let relative = (first - Vec3::from(leaf.center).as_dvec3()).as_vec3();
    let start = leaf.tangents.map(|tangent| Lanes([relative.dot(tangent.into())]));
    let (z, done) = slice.solved(leaf, start);
    let mut answer = None;
    evaluated(leaf, &slice, z, done, |_, found| answer = Some(found));
    answer
}
