//! A leaf of a sample-based camera: a bundle of rays as polynomials in two surface coordinates.
//!
//! A pinhole is stigmatic, a reflected bundle is not. So a leaf holds, over tangent coordinates `z` about its centre,
//! the reflection point `x(z)` and the outgoing ray as offset `a(z)` and slope `b(z)` across its mean direction. A
//! point at depth `s` and lateral position `l` is on the ray with `a(z) + s b(z) = l`; its image is that of `x(z)`.

use super::grid::GridRay;
use crate::scene::PreciseView;
use glam::{DMat2, DVec2, DVec3};

/// Terms of a polynomial of degree 3 in two variables.
const TERMS: usize = 10;

/// What is fitted: the first bounce point (3), offset (2), slope (2), where tails are along the mean direction (1), the
/// optical length to the tail (1).
const OUTPUTS: usize = 9;

/// Terms of a polynomial of degree 0, 1, 2 and 3.
const TERMS_OF_DEGREE: [usize; 4] = [1, 3, 6, 10];

/// Where a ray is tested first, as a share of its way through the scene: at its very tail the error of where tails are
/// would decide whether the point is before or behind it.
const NEAREST_HEAD: f64 = 0.02;

/// Steps of Newton's method for a point.
const MOST_STEPS: u32 = 8;

/// The step, in the leaf's size, below which they end.
const LEAST_STEP: f64 = 1e-10;

/// Coordinates may go so many cells of the ray map beyond the leaf's rays: to the next ray, and to silhouettes.
const CELLS_BEYOND: f64 = 2.0;

/// On the way they may go further, by this in the leaf's size.
const OVERSHOOT: f64 = 0.5;

/// Weight of the step's own size in the least squares of the fit, against rays on a line.
const RIDGE: f64 = 1e-12;

/// A bundle of rays.
#[derive(Clone, Debug)]
pub(super) struct Leaf {
    center: DVec3,
    /// Tangents over the leaf's size: coordinates are about -1 to 1.
    tangents: [DVec3; 2],
    origin: DVec3,
    direction: DVec3,
    across: [DVec3; 2],
    medium: f64,
    coefficients: [[f64; OUTPUTS]; TERMS],
    terms: usize,
    /// How large coordinates may be.
    farthest: f64,
}

/// Where a point is seen through a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    pub(super) first: DVec3,
    /// Change of the first bounce point with the scene point, row by row of the point's motion: `change . step` is
    /// `moves[0] (lateral[0] . step) + moves[1] (lateral[1] . step)`.
    pub(super) moves: [DVec3; 2],
    pub(super) lateral: [DVec3; 2],
    /// A normal of the first surface there, not of unit length, on the side from which the leaf's rays were seen.
    pub(super) normal: DVec3,
    /// Focal points between the tail and the point.
    pub(super) focal_index: u32,
    /// Optical length from the eye to the point, and the part from the tail on.
    pub(super) length: f64,
    pub(super) last_segment: f64,
}

/// Values and derivatives of the outputs.
struct Values {
    value: [f64; OUTPUTS],
    change: [[f64; OUTPUTS]; 2],
}

impl Leaf {
    /// The least-squares fit of `degree` to rays; none where there are too few of them, or they fan out too widely.
    ///
    /// `cells` is how many cells of the ray map the rays extend over in the longer direction.
    pub(super) fn fit(rays: &[GridRay], degree: usize, cells: u32) -> Option<Self> {
        let terms = TERMS_OF_DEGREE[degree];
        let first = rays.first()?;
        if rays.len() < terms {
            return None;
        }
        let count = rays.len() as f64;
        let center = rays.iter().map(|ray| ray.first).sum::<DVec3>() / count;
        let origin = rays.iter().map(|ray| ray.tail).sum::<DVec3>() / count;
        let normal = rays.iter().map(|ray| ray.normal).sum::<DVec3>().try_normalize()?;
        let direction = rays.iter().map(|ray| ray.direction).sum::<DVec3>().try_normalize()?;
        if rays.iter().any(|ray| ray.direction.dot(direction) < 0.1) {
            return None;
        }
        let size = rays.iter().map(|ray| ray.first.distance(center)).fold(0.0, f64::max).max(1e-12);
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let (right, up) = direction.any_orthonormal_pair();
        let mut leaf = Self {
            center,
            tangents: [u / size, v / size],
            origin,
            direction,
            across: [right, up],
            medium: first.medium,
            coefficients: [[0.0; OUTPUTS]; TERMS],
            terms,
            // The rays' coordinates are about -1 to 1.
            farthest: 1.0 + 2.0 * CELLS_BEYOND / f64::from(cells.max(1)),
        };
        let mut matrix = [[0.0; TERMS]; TERMS];
        let mut right = [[0.0; OUTPUTS]; TERMS];
        for ray in rays {
            let basis = basis(leaf.parameters(ray.first));
            let outputs = leaf.outputs(ray);
            for i in 0..terms {
                for j in 0..=i {
                    matrix[i][j] += basis[i] * basis[j];
                }
                for (sum, output) in right[i].iter_mut().zip(outputs) {
                    *sum += basis[i] * output;
                }
            }
        }
        for (i, row) in matrix.iter_mut().enumerate().take(terms) {
            row[i] += RIDGE * count;
        }
        leaf.coefficients = solved(matrix, right, terms)?;
        Some(leaf)
    }

    /// The coordinates of a first bounce point.
    pub(super) fn parameters(&self, first: DVec3) -> DVec2 {
        let relative = first - self.center;
        DVec2::new(relative.dot(self.tangents[0]), relative.dot(self.tangents[1]))
    }

    /// What a ray wants the polynomials to be.
    fn outputs(&self, ray: &GridRay) -> [f64; OUTPUTS] {
        let first = ray.first - self.center;
        let tail = ray.tail - self.origin;
        let along = tail.dot(self.direction);
        let forward = ray.direction.dot(self.direction);
        let slope = self.across.map(|axis| axis.dot(ray.direction) / forward);
        let offset = [0, 1].map(|i: usize| self.across[i].dot(tail) - along * slope[i]);
        [first.x, first.y, first.z, offset[0], offset[1], slope[0], slope[1], along, ray.length]
    }

    fn values(&self, z: DVec2) -> Values {
        let (x, y) = (z.x, z.y);
        let basis = basis(z);
        let by_x = [0.0, 1.0, 0.0, 2.0 * x, y, 0.0, 3.0 * x * x, 2.0 * x * y, y * y, 0.0];
        let by_y = [0.0, 0.0, 1.0, 0.0, x, 2.0 * y, 0.0, x * x, 2.0 * x * y, 3.0 * y * y];
        let mut values = Values { value: [0.0; OUTPUTS], change: [[0.0; OUTPUTS]; 2] };
        for (k, row) in self.coefficients.iter().enumerate().take(self.terms) {
            for (output, coefficient) in row.iter().enumerate() {
                values.value[output] += basis[k] * coefficient;
                values.change[0][output] += by_x[k] * coefficient;
                values.change[1][output] += by_y[k] * coefficient;
            }
        }
        values
    }

    /// The matrix `d(a + s b)/dz`.
    fn spread(values: &Values, depth: f64) -> DMat2 {
        let column = |row: &[f64; OUTPUTS]| DVec2::new(row[3] + depth * row[5], row[4] + depth * row[6]);
        DMat2::from_cols(column(&values.change[0]), column(&values.change[1]))
    }

    /// What Newton's method needs of the rays at one depth.
    pub(super) fn slice(&self, point: DVec3) -> Slice {
        let relative = point - self.origin;
        let depth = relative.dot(self.direction);
        let place = DVec2::new(relative.dot(self.across[0]), relative.dot(self.across[1]));
        let mut coefficients = [DVec2::ZERO; TERMS];
        for (sum, row) in coefficients.iter_mut().zip(&self.coefficients).take(self.terms) {
            *sum = DVec2::new(row[3] + depth * row[5], row[4] + depth * row[6]);
        }
        coefficients[0] -= place;
        Slice { depth, coefficients, terms: self.terms }
    }

    /// Where the point of a slice is seen, from a start in the leaf's coordinates; none where Newton's method leaves
    /// the leaf.
    pub(super) fn seen(&self, slice: &Slice, start: DVec2) -> Option<Answer> {
        let depth = slice.depth;
        let mut z = start;
        if self.terms > 1 {
            let mut steps = 0;
            loop {
                let (matrix, off) = slice.spread(z);
                let step = matrix.inverse() * -off;
                if !step.is_finite() || steps == MOST_STEPS {
                    return None;
                }
                z += step.clamp_length_max(1.0);
                if z.abs().max_element() > self.farthest + OVERSHOOT {
                    return None;
                }
                steps += 1;
                if step.length_squared() < LEAST_STEP * LEAST_STEP {
                    break;
                }
            }
            if z.abs().max_element() > self.farthest {
                return None;
            }
        }
        let values = self.values(z);
        let matrix = Self::spread(&values, depth);
        let inverse = if self.terms > 1 { matrix.inverse() } else { DMat2::ZERO };
        let [x, y, z, .., along, length] = values.value;
        let after = depth - along;
        if !inverse.is_finite() || after <= 0.0 {
            return None;
        }
        let tangent = |k: usize| DVec3::from_slice(&values.change[k][..3]);
        // d l / d point = across - slope direction: what moves the point along its ray moves nothing.
        let slope = [values.value[5], values.value[6]];
        let lateral = [0, 1].map(|i: usize| self.across[i] - self.direction * slope[i]);
        let moves = [0, 1].map(|i: usize| tangent(0) * inverse.col(i).x + tangent(1) * inverse.col(i).y);
        let last_segment = after * DVec3::new(slope[0], slope[1], 1.0).length();
        Some(Answer {
            first: self.center + DVec3::new(x, y, z),
            moves,
            lateral,
            normal: if self.terms > 1 {
                tangent(0).cross(tangent(1))
            } else {
                self.tangents[0].cross(self.tangents[1])
            },
            focal_index: Self::focal_points(&values, along, depth),
            length: length + self.medium * last_segment,
            last_segment,
        })
    }

    /// How many focal points a ray has between two depths: roots of `det(a' + s b')`, a quadratic.
    fn focal_points(values: &Values, from: f64, to: f64) -> u32 {
        let [near, middle, far] = [from, 0.5 * (from + to), to].map(|depth| Self::spread(values, depth));
        // Over 0..1 between the two: value at 0, at 1/2 and at 1.
        let [start, half, end] = [near, middle, far].map(|matrix| matrix.determinant());
        let (square, linear) = (2.0 * (start + end) - 4.0 * half, 4.0 * half - 3.0 * start - end);
        if start * end < 0.0 {
            return 1;
        }
        let turn = -linear / (2.0 * square);
        let lowest = start + 0.5 * linear * turn;
        if turn > 0.0 && turn < 1.0 && lowest * start < 0.0 { 2 } else { 0 }
    }

    /// The largest distance in pixels from where a ray's points belong to where the leaf sees them: at its tail, where
    /// it leaves the scene (`head` away) and between.
    pub(super) fn error_px(&self, ray: &GridRay, head: f64, view: &PreciseView) -> f64 {
        let Some(truth) = view.place_of(ray.first) else { return 0.0 };
        let start = if self.terms > 1 { self.parameters(ray.first) } else { DVec2::ZERO };
        let error = |distance: f64| {
            let seen = self.seen(&self.slice(ray.tail + ray.direction * distance), start);
            let place = seen.and_then(|seen| view.place_of(seen.first));
            place.map_or(f64::INFINITY, |place| (place[0] - truth[0]).hypot(place[1] - truth[1]))
        };
        [NEAREST_HEAD, 0.25, 1.0].into_iter().map(|share| error(share * head)).fold(0.0, f64::max)
    }
}

/// The lateral positions of a leaf's rays at one depth, relative to a point there: polynomials in its coordinates.
pub(super) struct Slice {
    depth: f64,
    coefficients: [DVec2; TERMS],
    terms: usize,
}

impl Slice {
    /// The change of the positions with the coordinates, and the position of the ray that has them.
    #[inline]
    fn spread(&self, z: DVec2) -> (DMat2, DVec2) {
        let (x, y) = (z.x, z.y);
        let c = &self.coefficients;
        let mut value = c[0] + c[1] * x + c[2] * y;
        let (mut by_x, mut by_y) = (c[1], c[2]);
        if self.terms > 3 {
            value += c[3] * (x * x) + c[4] * (x * y) + c[5] * (y * y);
            by_x += c[3] * (2.0 * x) + c[4] * y;
            by_y += c[4] * x + c[5] * (2.0 * y);
        }
        if self.terms > 6 {
            let (xx, xy, yy) = (x * x, x * y, y * y);
            value += c[6] * (xx * x) + c[7] * (xx * y) + c[8] * (x * yy) + c[9] * (yy * y);
            by_x += c[6] * (3.0 * xx) + c[7] * (2.0 * xy) + c[8] * yy;
            by_y += c[7] * xx + c[8] * (2.0 * xy) + c[9] * (3.0 * yy);
        }
        (DMat2::from_cols(by_x, by_y), value)
    }

    /// Whether the rays fold over at this depth: several of them may pass through one point.
    pub(super) fn folds(&self) -> bool {
        let sign = |x: f64, y: f64| self.spread(DVec2::new(x, y)).0.determinant() > 0.0;
        let middle = sign(0.0, 0.0);
        self.terms > 3
            && [(-0.7, -0.7), (0.7, -0.7), (-0.7, 0.7), (0.7, 0.7)].into_iter().any(|(x, y)| sign(x, y) != middle)
    }
}

fn basis(z: DVec2) -> [f64; TERMS] {
    let (x, y) = (z.x, z.y);
    [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
}

/// Cholesky's method, in place: fits are too many for a library that allocates. None where the matrix (its lower half)
/// is not positive definite.
fn solved(
    mut matrix: [[f64; TERMS]; TERMS],
    mut right: [[f64; OUTPUTS]; TERMS],
    terms: usize,
) -> Option<[[f64; OUTPUTS]; TERMS]> {
    for i in 0..terms {
        for j in 0..=i {
            let (row, other) = (matrix[i], matrix[j]);
            let known: f64 = row.iter().zip(other).take(j).map(|(a, b)| a * b).sum();
            let rest = row[j] - known;
            matrix[i][j] = match i == j {
                true if rest > 0.0 && rest.is_finite() => rest.sqrt(),
                true => return None,
                false => rest / other[j],
            };
        }
    }
    let subtract = |right: &mut [[f64; OUTPUTS]; TERMS], from: usize, row: usize, factor: f64| {
        let known = right[row];
        right[from].iter_mut().zip(known).for_each(|(sum, known)| *sum -= factor * known);
    };
    for (i, row) in matrix.iter().enumerate().take(terms) {
        for (k, factor) in row.iter().enumerate().take(i) {
            subtract(&mut right, i, k, *factor);
        }
        right[i].iter_mut().for_each(|sum| *sum /= row[i]);
    }
    for i in (0..terms).rev() {
        for (k, row) in matrix.iter().enumerate().take(terms).skip(i + 1) {
            subtract(&mut right, i, k, row[i]);
        }
        right[i].iter_mut().for_each(|sum| *sum /= matrix[i][i]);
    }
    Some(right)
}
