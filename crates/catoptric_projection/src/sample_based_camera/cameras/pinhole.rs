//! The paper's camera: a pinhole fitted to rays, and a quadratic map from its image plane to the first reflector
//! (Popescu, Sacks, Mei 2006, section IV). Bundles of parallel rays have an affine camera.

use super::camera_projection::CameraProjection;
use super::fit::{RIDGE, TESTED, solved};
use crate::sample_based_camera::layout::{PINHOLE_OUTPUTS, PINHOLE_TERMS, PinholeLeaf};
use crate::sample_based_camera::rays::grid_ray::GridRay;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::PreciseView;
use glam::{DMat3, DVec2, DVec3, Vec3};

/// Rays whose lines meet further away than this many times their tails' extent are taken for parallel. Chosen, not
/// measured.
const PARALLEL: f64 = 1e4;

/// Image planes stand at least this much across the mean direction (a cosine). Chosen, not measured.
const MIN_ACROSS: f64 = 0.2;

/// The frustum goes beyond tails and heads by this share of its extent. Chosen, not measured.
const LEEWAY: f64 = 0.05;

/// The frame of a camera.
#[derive(Clone, Copy, Debug)]
struct PinholeFrame {
    /// The centre of projection; none of an affine camera.
    center: Option<DVec3>,
    /// A point and the unit normal of the image plane, and its axes over the extent of the tails.
    origin: DVec3,
    normal: DVec3,
    axes: [DVec3; 2],
    /// The mean direction of the rays.
    direction: DVec3,
}

impl PinholeFrame {
    /// Intersection of the line of sight through a point with the image plane.
    fn image_of(&self, point: DVec3) -> DVec2 {
        let (from, along) = match self.center {
            Some(center) => (center, point - center),
            None => (point, self.direction),
        };
        let met = from + along * ((self.origin - from).dot(self.normal) / along.dot(self.normal));
        DVec2::new((met - self.origin).dot(self.axes[0]), (met - self.origin).dot(self.axes[1]))
    }
}

/// The directions across which points spread most and second most: power iteration on their covariance.
fn widest_axes(points: impl Iterator<Item = DVec3> + Clone, center: DVec3) -> [DVec3; 2] {
    let mut covariance = DMat3::ZERO;
    for point in points {
        let relative = point - center;
        covariance += DMat3::from_cols(relative * relative.x, relative * relative.y, relative * relative.z);
    }
    let principal =
        |matrix: &DMat3, start: DVec3| (0..24).fold(start, |axis, _| (*matrix * axis).try_normalize().unwrap_or(axis));
    // Starts that lie in no plane that mirrors lie in.
    let first = principal(&covariance, DVec3::new(0.62, 0.57, 0.54).normalize());
    let variance = first.dot(covariance * first);
    let rest = covariance - DMat3::from_cols(first * first.x, first * first.y, first * first.z) * variance;
    let start = DVec3::new(0.31, -0.74, 0.59).reject_from_normalized(first).try_normalize();
    let second = principal(&rest, start.unwrap_or(first.any_orthonormal_vector()));
    [first, second]
}

fn basis(image: DVec2) -> [f64; PINHOLE_TERMS] {
    let (u, v) = (image.x, image.y);
    [1.0, u, v, u * u, u * v, v * v]
}

/// The point nearest to all rays, from `origin`: the normal equations of `o x d = t x d`, which are `sum (I - d dT) o =
/// sum (I - d dT) t`. Not finite for parallel rays.
#[inline(always)]
fn center_from(rays: &[GridRay], origin: DVec3) -> DVec3 {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for ray in rays {
        let d = ray.direction;
        let across = DMat3::IDENTITY - DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        matrix += across;
        right += across * (ray.tail - origin);
    }
    matrix.inverse() * right
}

/// The camera of least squares for rays that go as far as `heads`; returns `None` if there are too few of them.
pub(in super::super) fn fit(rays: &[GridRay], heads: &[f32]) -> Option<PinholeLeaf> {
    let first = rays.first()?;
    if rays.len() < PINHOLE_TERMS {
        return None;
    }
    let count = rays.len() as f64;
    let origin = rays.iter().map(|ray| ray.tail).sum::<DVec3>() / count;
    let direction = rays.iter().map(|ray| ray.direction).sum::<DVec3>().try_normalize()?;
    let normal_of_first = rays.iter().map(|ray| ray.normal).sum::<DVec3>();
    let size = rays.iter().map(|ray| ray.tail.distance(origin)).fold(0.0, f64::max).max(1e-12);
    let center = center_from(rays, origin);
    let center = (center.is_finite() && center.length() < PARALLEL * size).then_some(origin + center);
    let [wide, narrow] = widest_axes(rays.iter().map(|ray| ray.tail), origin);
    let plane = wide.cross(narrow).try_normalize().filter(|normal| normal.dot(direction).abs() > MIN_ACROSS);
    let normal = plane.unwrap_or(direction);
    let u = wide.reject_from_normalized(normal).try_normalize().unwrap_or(normal.any_orthonormal_vector());
    let frame = PinholeFrame { center, origin, normal, axes: [u / size, normal.cross(u) / size], direction };
    let mut matrix = [[0.0; PINHOLE_TERMS]; PINHOLE_TERMS];
    let mut right = [[0.0; PINHOLE_OUTPUTS]; PINHOLE_TERMS];
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let outputs = |ray: &GridRay| {
        let first = ray.first - origin;
        [first.x, first.y, first.z, ray.length, (ray.tail - origin).dot(direction)]
    };
    let mut images = Vec::with_capacity(2 * rays.len());
    for (ray, head) in rays.iter().zip(heads) {
        for end in [ray.tail, ray.tail + ray.direction * f64::from(*head)] {
            let image = frame.image_of(end);
            if !image.is_finite() {
                return None;
            }
            (low, high) = (low.min(image), high.max(image));
            images.push((image, outputs(ray)));
        }
    }
    for (image, outputs) in &images {
        let terms = basis(*image);
        for i in 0..PINHOLE_TERMS {
            for j in 0..PINHOLE_TERMS {
                matrix[i][j] += terms[i] * terms[j];
            }
            for (sum, output) in right[i].iter_mut().zip(outputs) {
                *sum += terms[i] * output;
            }
        }
    }
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] += RIDGE * count;
    }
    let polynomials = solved(matrix, right, PINHOLE_TERMS)?;
    let left: f64 = images
        .iter()
        .map(|(image, outputs)| {
            let terms = basis(*image);
            let value =
                |output: usize| terms.iter().zip(&polynomials).map(|(term, row)| term * row[output]).sum::<f64>();
            (0..3).map(|axis| (value(axis) - outputs[axis]).powi(2)).sum::<f64>()
        })
        .sum();
    let leeway = (high - low) * LEEWAY;
    let single = |vector: DVec3| vector.as_vec3().to_array();
    // The side that is seen: the sign of the map's own normal.
    let (by_u, by_v) =
        ([1, 2].map(|term: usize| DVec3::new(polynomials[term][0], polynomials[term][1], polynomials[term][2]))).into();
    let side = if DVec3::cross(by_u, by_v).dot(normal_of_first) < 0.0 { -1.0 } else { 1.0 };
    Some(PinholeLeaf {
        center: single(center.unwrap_or_default()),
        is_affine: u32::from(center.is_none()),
        origin: single(origin),
        medium: first.medium as f32,
        normal: single(normal),
        side,
        direction: single(direction),
        first_error: (left / images.len() as f64).sqrt() as f32,
        axes: frame.axes.map(single),
        low: (low - leeway).as_vec2().to_array(),
        high: (high + leeway).as_vec2().to_array(),
        coefficients: std::array::from_fn(|output| polynomials.map(|row| row[output] as f32)),
    })
}

/// True if a camera projects points on all of `rays` within `accuracy_px` pixels of their places.
pub(in super::super) fn is_accurate(
    leaf: &PinholeLeaf,
    rays: &[GridRay],
    heads: &[f32],
    view: &PreciseView,
    accuracy_px: f64,
) -> bool {
    rays.iter().zip(heads).all(|(ray, head)| {
        let Some(truth) = view.place_of(ray.first) else { return true };
        TESTED.iter().all(|share| {
            let point = ray.tail + ray.direction * (share * f64::from(*head));
            let seen = ask(leaf, point.as_vec3()).and_then(|answer| view.place_of(answer.first));
            seen.is_some_and(|seen| (seen[0] - truth[0]).hypotenuse(seen[1] - truth[1]) <= accuracy_px)
        })
    })
}

/// Projects a point by a camera; returns `None` outside its frustum.
pub(in super::super) fn ask(leaf: &PinholeLeaf, point: Vec3) -> Option<CameraProjection> {
    let (origin, normal, direction) = (Vec3::from(leaf.origin), Vec3::from(leaf.normal), Vec3::from(leaf.direction));
    let axes = leaf.axes.map(Vec3::from);
    let center = Vec3::from(leaf.center);
    let affine = leaf.is_affine != 0;
    let along = if affine { direction } else { point - center };
    let from = if affine { point } else { center };
    let scale = (origin - from).dot(normal) / along.dot(normal);
    let met = from + along * scale - origin;
    let (u, v) = (met.dot(axes[0]), met.dot(axes[1]));
    let inside = |value: f32, axis: usize| value >= leaf.low[axis] && value <= leaf.high[axis];
    // Where the line of sight runs along the image plane this is not a number.
    if !(inside(u, 0) && inside(v, 1)) {
        return None;
    }
    let value = |c: &[f32; PINHOLE_TERMS]| c[0] + u * (c[1] + c[3] * u + c[4] * v) + v * (c[2] + c[5] * v);
    let by_u = |c: &[f32; PINHOLE_TERMS]| c[1] + 2.0 * c[3] * u + c[4] * v;
    let by_v = |c: &[f32; PINHOLE_TERMS]| c[2] + c[4] * u + 2.0 * c[5] * v;
    let c = &leaf.coefficients;
    let first = Vec3::new(value(&c[0]), value(&c[1]), value(&c[2]));
    let moves = [Vec3::new(by_u(&c[0]), by_u(&c[1]), by_u(&c[2])), Vec3::new(by_v(&c[0]), by_v(&c[1]), by_v(&c[2]))];
    let after = (point - origin).dot(direction) - value(&c[4]);
    let forward = along.normalize_or_zero().dot(direction).abs();
    if after <= 0.0 || forward <= 0.0 {
        return None;
    }
    let last_segment = after / forward;
    // A step along the line of sight moves nothing.
    let step_scale = if affine { 1.0 } else { scale };
    let lateral = axes.map(|axis| (axis - normal * (axis.dot(along) / along.dot(normal))) * step_scale);
    // If the centre lies in front of the tails, all rays have crossed beyond it.
    let crossed = !affine && (center - origin).dot(direction) > 0.0 && (point - center).dot(direction) > 0.0;
    let largest = moves[0].length().max(moves[1].length());
    Some(CameraProjection {
        first: origin.as_dvec3() + first.as_dvec3(),
        moves,
        lateral,
        normal: moves[0].cross(moves[1]) * leaf.side,
        focal_index: if crossed { 2 } else { 0 },
        length: value(&c[3]) + leaf.medium * last_segment,
        last_segment,
        lateral_error: if largest > 0.0 { leaf.first_error / largest } else { 0.0 },
    })
}
