//! Least-squares fits of ray bundles, and how accurate they are.

use crate::sample_based_camera::layout::{BundleLeaf, OUTPUTS, TERMS};
use crate::sample_based_camera::rays::grid_ray::GridRay;
use catoptric_core::scene::PreciseView;
use glam::{DVec2, DVec3};

/// Terms of a polynomial that are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum FitTerms {
    Linear,
    /// Linear terms, and the product of the coordinates: four rays are met exactly.
    Bilinear,
    Quadratic,
    Cubic,
}

impl FitTerms {
    pub(in super::super) fn terms(self) -> &'static [usize] {
        match self {
            Self::Linear => &[0, 1, 2],
            Self::Bilinear => &[0, 1, 2, 4],
            Self::Quadratic => &[0, 1, 2, 3, 4, 5],
            Self::Cubic => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9],
        }
    }

    /// True if rays on so many columns and rows test its accuracy between them.
    pub(in super::super) fn is_tested_by(self, lines: [u32; 2]) -> bool {
        let (fewer, more) = (lines[0].min(lines[1]), lines[0].max(lines[1]));
        match self {
            Self::Linear | Self::Bilinear => fewer >= 2 && more >= 3,
            Self::Quadratic => fewer >= 3,
            Self::Cubic => fewer >= 4,
        }
    }

    /// Number of rays that test its accuracy: an exact fit is unbounded between its rays.
    fn least_rays(self) -> usize {
        match self {
            Self::Bilinear => 4,
            Self::Linear => 3,
            Self::Quadratic => 9,
            Self::Cubic => 20,
        }
    }
}

/// The places at which a ray is tested, as shares of its way through the scene: near its tail, at its head, and
/// between. (At the very tail the error of the tail itself would decide whether the point is before or behind it.) The
/// shares themselves are chosen, not measured.
pub(in super::super) const TESTED: [f64; 3] = [0.02, 0.25, 1.0];

/// Weight of the coefficients' own size in the least squares, against rays on a line. Chosen well above rounding, not
/// measured.
pub(in super::super) const RIDGE: f64 = 1e-12;

/// Rays of a bundle are at most this far from its mean direction (a cosine). Chosen, not measured.
const WIDEST: f64 = 0.1;

/// Axes of coordinates are too near to each other for a frame at this sine of the angle between them. Chosen, not
/// measured.
const PARALLEL: f64 = 1e-4;

/// Leaves are at least this share of their length wide. Chosen, not measured.
const THINNEST: f64 = 1e-6;

/// The distance that coordinates may go beyond those of the leaf's rays, as a share of their extent. Chosen, not
/// measured.
const LEEWAY: f64 = 0.1;

/// Like [`LEEWAY`], for leaves that only interpolate: their projections may be off by about the spacing of rays.
/// Chosen, not measured.
const LEEWAY_OF_LISTS: f64 = 0.35;

/// Spacing of the rays of a leaf.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct FitSpan {
    /// Spacing, in cells.
    pub(in super::super) apart: f32,
    /// True if the leaf only interpolates between them.
    pub(in super::super) interpolates: bool,
}

/// The surface whose points a leaf's coordinates belong to.
///
/// Where the last mirror ends for the eye, beside its silhouette in the one before, it moves as the root of the way on
/// the first: there polynomials over the first do not get near it, and those over the last do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Over {
    First,
    Last,
}

impl Over {
    const BOTH: [Self; 2] = [Self::First, Self::Last];

    /// The surfaces that differ for some rays.
    fn all(rays: &[GridRay]) -> &'static [Self] {
        let is_one = rays.first().is_none_or(|ray| ray.first == ray.tail);
        if is_one { &Self::BOTH[..1] } else { &Self::BOTH }
    }

    fn point(self, ray: &GridRay) -> DVec3 {
        match self {
            Self::First => ray.first,
            Self::Last => ray.tail,
        }
    }
}

/// The frame of a leaf, and its polynomials.
#[derive(Clone, Debug)]
pub(in super::super) struct Fit {
    /// The middle of the first bounce points.
    center: DVec3,
    over: Over,
    /// Gradients of the coordinates, which are zero at the centre of the points that they are those of.
    gradients: [DVec3; 2],
    /// Approximate gradients of the coordinates with respect to the first bounce points.
    tangents: [DVec3; 2],
    origin: DVec3,
    direction: DVec3,
    across: [DVec3; 2],
    medium: f64,
    /// Root mean squares of the residuals of offsets and slopes.
    offset_error: f64,
    slope_error: f64,
    coefficients: [[f64; OUTPUTS]; TERMS],
}

impl Fit {
    /// The least-squares fits to rays, over each surface; none if there are too few of these, or they fan out too
    /// widely.
    pub(in super::super) fn all(rays: &[GridRay], shape: FitTerms) -> impl Iterator<Item = Self> {
        Over::all(rays).iter().filter_map(move |&over| Self::new(rays, shape, over))
    }

    /// The nearest of them.
    pub(in super::super) fn nearest(rays: &[GridRay], shape: FitTerms) -> Option<Self> {
        Self::all(rays, shape).min_by(|a, b| a.slope_error.total_cmp(&b.slope_error))
    }

    fn new(rays: &[GridRay], shape: FitTerms, over: Over) -> Option<Self> {
        let terms = shape.terms();
        let first = rays.first()?;
        if rays.len() < shape.least_rays() {
            return None;
        }
        let count = rays.len() as f64;
        let center = rays.iter().map(|ray| ray.first).sum::<DVec3>() / count;
        let origin = rays.iter().map(|ray| ray.tail).sum::<DVec3>() / count;
        let normal = rays.iter().map(|ray| ray.normal).sum::<DVec3>().try_normalize()?;
        let direction = rays.iter().map(|ray| ray.direction).sum::<DVec3>().try_normalize()?;
        if rays.iter().any(|ray| ray.direction.dot(direction) < WIDEST) {
            return None;
        }
        let gradients = coordinate_gradients(rays, (center, normal), over)?;
        let (right, up) = direction.any_orthonormal_pair();
        let mut fit = Self {
            center,
            over,
            gradients,
            tangents: gradients,
            origin,
            direction,
            across: [right, up],
            medium: first.medium,
            offset_error: 0.0,
            slope_error: 0.0,
            coefficients: [[0.0; OUTPUTS]; TERMS],
        };
        let mut matrix = [[0.0; TERMS]; TERMS];
        let mut right = [[0.0; OUTPUTS]; TERMS];
        for ray in rays {
            let all = basis(fit.coordinates(ray));
            let outputs = fit.outputs(ray);
            for (i, &term) in terms.iter().enumerate() {
                for (sum, &other) in matrix[i].iter_mut().zip(&terms[..=i]) {
                    *sum += all[term] * all[other];
                }
                for (sum, output) in right[i].iter_mut().zip(outputs) {
                    *sum += all[term] * output;
                }
            }
        }
        for (i, row) in matrix.iter_mut().enumerate().take(terms.len()) {
            row[i] += RIDGE * count;
        }
        let solved = solved(matrix, right, terms.len())?;
        for (&term, row) in terms.iter().zip(solved) {
            fit.coefficients[term] = row;
        }
        let (mut offset, mut slope) = (0.0, 0.0);
        for ray in rays {
            let all = basis(fit.coordinates(ray));
            let truth = fit.outputs(ray);
            let left = |output: usize| {
                let value: f64 = terms.iter().map(|&term| all[term] * fit.coefficients[term][output]).sum();
                (value - truth[output]).powi(2)
            };
            offset += left(3) + left(4);
            slope += left(5) + left(6);
        }
        (fit.offset_error, fit.slope_error) = ((offset / count).sqrt(), (slope / count).sqrt());
        if over == Over::Last {
            fit.tangents = fit.coordinates_by_first()?;
        }
        Some(fit)
    }

    /// The gradients of the coordinates with respect to the first bounce points in the middle: the inverse of the
    /// derivatives of these with respect to the coordinates.
    fn coordinates_by_first(&self) -> Option<[DVec3; 2]> {
        let [right, down] = [1, 2].map(|term: usize| DVec3::from_slice(&self.coefficients[term][..3]));
        let normal = right.cross(down);
        let scale = normal.length_squared().recip();
        let gradients = [down.cross(normal) * scale, normal.cross(right) * scale];
        gradients.iter().all(|gradient| gradient.is_finite()).then_some(gradients)
    }

    /// The interpolation between a few rays: bilinear if there are four. Returns `None` if they are on a line.
    pub(in super::super) fn interpolating(rays: &[GridRay]) -> Option<Self> {
        let linear = Self::nearest(rays, FitTerms::Linear);
        let over = linear.as_ref().map_or(Over::First, |linear| linear.over);
        match (Self::new(rays, FitTerms::Bilinear, over), linear) {
            // An exact fit has no residual to estimate its error from; the residual of the linear fit is about that.
            (Some(bilinear), Some(linear)) => {
                Some(Self { offset_error: linear.offset_error, slope_error: linear.slope_error, ..bilinear })
            }
            (bilinear, linear) => bilinear.or(linear),
        }
    }

    /// The coordinates of a ray.
    #[inline(always)]
    fn coordinates(&self, ray: &GridRay) -> DVec2 {
        let relative = match self.over {
            Over::First => ray.first - self.center,
            Over::Last => ray.tail - self.origin,
        };
        DVec2::new(relative.dot(self.gradients[0]), relative.dot(self.gradients[1]))
    }

    /// Values that a ray fits the polynomials to.
    #[inline(always)]
    fn outputs(&self, ray: &GridRay) -> [f64; OUTPUTS] {
        let first = ray.first - self.center;
        let tail = ray.tail - self.origin;
        let along = tail.dot(self.direction);
        let forward = 1.0 / ray.direction.dot(self.direction);
        let slope = self.across.map(|axis| axis.dot(ray.direction) * forward);
        let offset = [0, 1].map(|i: usize| self.across[i].dot(tail) - along * slope[i]);
        [first.x, first.y, first.z, offset[0], offset[1], slope[0], slope[1], along, ray.length, 0.0, 0.0, 0.0]
    }

    /// The record of the leaf, for the coordinates of all of `rays`, which lie between two places.
    pub(in super::super) fn leaf<'a>(
        &self,
        rays: impl Iterator<Item = &'a GridRay>,
        piece: u32,
        places: [[f32; 2]; 2],
        span: FitSpan,
    ) -> BundleLeaf {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for ray in rays {
            let coordinates = self.coordinates(ray);
            (low, high) = (low.min(coordinates), high.max(coordinates));
        }
        let leeway = (high - low) * if span.interpolates { LEEWAY_OF_LISTS } else { LEEWAY };
        let single = |vector: DVec3| vector.as_vec3().to_array();
        BundleLeaf {
            center: single(self.center),
            origin: single(self.origin),
            medium: self.medium as f32,
            direction: single(self.direction),
            piece,
            offset_error: self.offset_error as f32,
            slope_error: self.slope_error as f32,
            across: self.across.map(single),
            tangents: self.tangents.map(single),
            low: (low - leeway).as_vec2().to_array(),
            high: (high + leeway).as_vec2().to_array(),
            interpolates: u32::from(span.interpolates),
            low_place: places[0],
            high_place: places[1],
            apart: span.apart,
            coefficients: self.coefficients.map(|row| row.map(|coefficient| coefficient as f32)),
        }
    }
}

/// Gradients of the coordinates of a leaf around the middle of its points: about -1 to 1 over its rays, the first along
/// the rows of the map and the second down its columns.
///
/// The box of coordinates is then no larger than it need be; towards silhouettes, where blocks become slivers on the
/// surface, a box along other axes would hold much more than its rays.
fn coordinate_gradients(rays: &[GridRay], (first, normal): (DVec3, DVec3), over: Over) -> Option<[DVec3; 2]> {
    let frame = |[right, down]: [DVec3; 2], normal: DVec3| {
        let right = right.try_normalize().unwrap_or(normal.any_orthonormal_vector());
        let apart = |down: &DVec3| down.cross(right).length() > PARALLEL;
        [right, down.try_normalize().filter(apart).unwrap_or(normal.cross(right))]
    };
    let [right, down] = frame(moves_with_place(rays, Over::First, first, Some(normal)), normal);
    // Their normal is to be that of the first surface.
    let is_turned = right.cross(down).dot(normal) < 0.0;
    let middle = rays.iter().map(|ray| over.point(ray)).sum::<DVec3>() / rays.len() as f64;
    let size = rays.iter().map(|ray| over.point(ray).distance_squared(middle)).fold(0.0, f64::max).sqrt().max(1e-12);
    let ([right, down], normal) = match over {
        Over::First => ([right, down], normal),
        Over::Last => {
            let moves = moves_with_place(rays, over, middle, None);
            let normal = moves[0].cross(moves[1]).try_normalize()?;
            (frame(moves, normal), normal)
        }
    };
    let down = if is_turned { -down } else { down };
    let across = [down.cross(normal), normal.cross(right)];
    let gradients = [across[0] / across[0].dot(right), across[1] / across[1].dot(down)];
    let scaled = |gradient: DVec3| {
        let most = rays.iter().map(|ray| (over.point(ray) - middle).dot(gradient).abs()).fold(0.0, f64::max);
        gradient / most.max(size * THINNEST)
    };
    let gradients = gradients.map(scaled);
    gradients.iter().all(|gradient| gradient.is_finite()).then_some(gradients)
}

/// The derivatives of points with respect to the place in the map, by least squares, up to a common factor; only across
/// the normal, if that is known.
fn moves_with_place(rays: &[GridRay], over: Over, center: DVec3, normal: Option<DVec3>) -> [DVec3; 2] {
    let place = |ray: &GridRay| DVec2::new(ray.place[0].into(), ray.place[1].into());
    let middle = rays.iter().map(place).sum::<DVec2>() / rays.len() as f64;
    let (mut spread, mut moves) = ([0.0; 3], [DVec3::ZERO; 2]);
    for ray in rays {
        let (step, way) = (place(ray) - middle, over.point(ray) - center);
        let way = normal.map_or(way, |normal| way.reject_from_normalized(normal));
        spread[0] += step.x * step.x;
        spread[1] += step.x * step.y;
        spread[2] += step.y * step.y;
        moves[0] += way * step.x;
        moves[1] += way * step.y;
    }
    [moves[0] * spread[2] - moves[1] * spread[1], moves[1] * spread[0] - moves[0] * spread[1]]
}

/// True if a fit projects points on all of `rays` within `accuracy_px` pixels of their places, to first order.
///
/// `heads` is how far each of the rays goes.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
pub(in super::super) fn is_accurate(
    fit: &Fit,
    rays: &[GridRay],
    heads: &[f32],
    view: &PreciseView,
    accuracy_px: f64,
) -> bool {
    let most = accuracy_px * accuracy_px;
    rays.iter().zip(heads).all(|(ray, head)| {
        let z = fit.coordinates(ray);
        let (x, y) = (z.x, z.y);
        let basis = basis(z);
        let by_x = [0.0, 1.0, 0.0, 2.0 * x, y, 0.0, 3.0 * x * x, 2.0 * x * y, y * y, 0.0];
        let by_y = [0.0, 0.0, 1.0, 0.0, x, 2.0 * y, 0.0, x * x, 2.0 * x * y, 3.0 * y * y];
        let (mut value, mut right, mut down) = ([0.0; OUTPUTS], [0.0; OUTPUTS], [0.0; OUTPUTS]);
        for (term, row) in fit.coefficients.iter().enumerate() {
            for output in 0..OUTPUTS {
                value[output] += basis[term] * row[output];
                right[output] += by_x[term] * row[output];
                down[output] += by_y[term] * row[output];
            }
        }
        let truth = fit.outputs(ray);
        let vector = |from: &[f64; OUTPUTS]| DVec3::new(from[0], from[1], from[2]);
        let off = vector(&value) - vector(&truth);
        let gradients = view.place_change(ray.first);
        let [off, right_px, down_px] =
            [off, vector(&right), vector(&down)].map(|step| DVec2::new(gradients[0].dot(step), gradients[1].dot(step)));
        // The ray's step along the mean direction for a unit length.
        let forward = ray.direction.dot(fit.direction);
        TESTED.iter().all(|share| {
            let depth = truth[7] + share * f64::from(*head) * forward;
            let miss = [3, 4].map(|i: usize| value[i] - truth[i] + depth * (value[i + 2] - truth[i + 2]));
            let [[a, b], [c, d]] =
                [3, 4].map(|i: usize| [right[i] + depth * right[i + 2], down[i] + depth * down[i + 2]]);
            let determinant = a * d - b * c;
            let step = [(b * miss[1] - d * miss[0]) / determinant, (c * miss[0] - a * miss[1]) / determinant];
            // False if it is not a number, too.
            (off + right_px * step[0] + down_px * step[1]).length_squared() <= most
        })
    })
}

#[inline(always)]
fn basis(z: DVec2) -> [f64; TERMS] {
    let (x, y) = (z.x, z.y);
    [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
}

/// Cholesky's method, in place: fits are too many for a library that allocates. Returns `None` if the matrix (its lower
/// half) is not positive definite.
pub(in super::super) fn solved<const TERMS: usize, const OUTPUTS: usize>(
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
