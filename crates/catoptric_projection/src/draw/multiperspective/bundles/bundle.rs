//! The rays of a tile as one family: every coordinate a quadratic in the place in the picture.

use super::least_squares::{LINEAR_VALUES, TERMS, fit_quadratics, terms};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::Ray;
use glam::{Mat2, Vec2, Vec3};

/// A ray's coordinates in a tile: direction and moment about the tile's origin, and the depth of its start.
pub(in super::super) const COORDINATES: usize = TERMS + 1;

/// Rays whose cosine to their mean is smaller than this are no bundle. Chosen, not measured.
const MIN_COSINE: f32 = 0.2;

/// A tile's plane of origins lies so far behind the rays' starts, as a share of their extent: depths are positive.
const BEHIND: f32 = 0.25;

/// The least distance of neighbouring rays that errors are divided by, as a share of their distance elsewhere: where
/// rays of a tile meet in a focus, errors in pixels would be infinite. Chosen, not measured.
const DAMPING: f32 = 0.1;

/// A ray of a tile.
#[derive(Clone, Copy, Debug)]
pub struct TileRay {
    /// Position in the picture, in pixels.
    pub at: Vec2,
    /// The ray; its origin lies on the last mirror.
    pub ray: Ray,
    /// The length that its direction counts with.
    pub length: f32,
}

/// A tile's rays as lines: direction and moment about `origin`, in the world's axes.
///
/// Directions are as long as the eye's rays are that reach the picture's plane at depth 1: in a flat mirror they and
/// their moments are then linear in the place, exactly.
#[derive(Clone, Copy, Debug)]
pub struct RayBundle {
    /// u and v are 0 here, in pixels of the picture.
    pub center: Vec2,
    /// Change of u and v a pixel.
    pub scale: f32,
    /// A point behind all starts of rays, from which depths are measured along the mean direction.
    pub origin: Vec3,
    /// Two axes of the plane of origins, and the mean direction.
    pub axes: [Vec3; 3],
    pub(in super::super) directions: [Vec3; TERMS],
    pub(in super::super) moments: [Vec3; TERMS],
    /// Depths at which rays start.
    pub(in super::super) starts: [f32; TERMS],
    /// The least and largest of them.
    pub(in super::super) start_range: [f32; 2],
    /// Changes of a ray's slope and origin a pixel, at the centre.
    slope_change: Mat2,
    origin_change: Mat2,
    /// Second-order terms (uu, uv, vv) of slopes and origins, a pixel for a unit of u or v.
    slope_bend: [Vec2; 3],
    origin_bend: [Vec2; 3],
}

/// The rays of a tile, and the bundle's errors of them.
#[derive(Debug, Default)]
pub struct BundleFit {
    rays: Vec<[f32; COORDINATES]>,
    basis: Vec<[f32; TERMS]>,
    /// Slopes and origins in the plane of origins, and the quadratics' errors of them.
    slopes: Vec<Vec2>,
    origins: Vec<Vec2>,
    missed_slopes: Vec<Vec2>,
    missed_origins: Vec<Vec2>,
    /// The largest error of a start.
    pub(in super::super) start_error: f32,
}

/// Slope and origin of a line in a plane through 0 that is normal to the last axis.
#[inline(always)]
fn in_plane([x, y, w]: &[Vec3; 3], (direction, moment): (Vec3, Vec3)) -> (Vec2, Vec2) {
    let inverse = 1.0 / direction.dot(*w);
    let slope = Vec2::new(direction.dot(*x), direction.dot(*y)) * inverse;
    (slope, Vec2::new(-moment.dot(*y), moment.dot(*x)) * inverse)
}

/// The coordinates of a ray in a tile with this origin and axis; its direction counts with a length.
#[inline(always)]
fn coordinates(origin: Vec3, axis: Vec3, ray: &Ray, length: f32) -> [f32; COORDINATES] {
    let from = ray.origin - origin;
    let direction = ray.direction * length;
    let moment = from.cross(direction);
    [direction.x, direction.y, direction.z, moment.x, moment.y, moment.z, from.dot(axis)]
}

/// Lines and the plane that they pass.
struct Plane<'a> {
    axes: [Vec3; 3],
    directions: &'a [Vec3; TERMS],
    moments: &'a [Vec3; TERMS],
}

impl Plane<'_> {
    /// The coefficients of slope and origin that belong to a term of directions and moments, to first order.
    #[inline(always)]
    fn along(&self, term: usize, scale: f32) -> (Vec2, Vec2) {
        let (slope, origin) = in_plane(&self.axes, (self.directions[0], self.moments[0]));
        let [x, y, w] = self.axes;
        let factor = scale / self.directions[0].dot(w);
        let (direction, moment) = (self.directions[term], self.moments[term]);
        let length = direction.dot(w);
        let slope = Vec2::new(direction.dot(x), direction.dot(y)) - slope * length;
        let origin = Vec2::new(-moment.dot(y), moment.dot(x)) - origin * length;
        (slope * factor, origin * factor)
    }

    /// The changes of slopes and origins a pixel, at the centre.
    #[inline(always)]
    fn changes(&self, scale: f32) -> Option<(Mat2, Mat2)> {
        let ((slope_u, origin_u), (slope_v, origin_v)) = (self.along(1, scale), self.along(2, scale));
        let changes = (Mat2::from_cols(slope_u, slope_v), Mat2::from_cols(origin_u, origin_v));
        (changes.0.is_finite() && changes.1.is_finite()).then_some(changes)
    }
}

impl RayBundle {
    /// Fits a bundle to the rays of a tile about a place; `half` is half the tile's side in pixels. `None` if they are
    /// too few or too far apart.
    #[inline(always)]
    pub fn fit(rays: &[TileRay], center: Vec2, half: f32, fit: &mut BundleFit) -> Option<Self> {
        if rays.len() < LINEAR_VALUES {
            return None;
        }
        let count = rays.len() as f32;
        let mean = rays.iter().map(|ray| ray.ray.direction).sum::<Vec3>().try_normalize()?;
        let middle = rays.iter().map(|ray| ray.ray.origin).sum::<Vec3>() / count;
        let x = mean.any_orthonormal_vector();
        let axes = [x, mean.cross(x), mean];
        let (mut lowest, mut reach) = (0.0f32, 0.0f32);
        for TileRay { ray, .. } in rays {
            if ray.direction.dot(mean) < MIN_COSINE {
                return None;
            }
            let from = ray.origin - middle;
            lowest = lowest.min(from.dot(mean));
            reach = reach.max(from.length_squared());
        }
        let behind = BEHIND * reach.sqrt() + 1e-6 * middle.abs().max_element() - lowest;
        let origin = middle - mean * behind;
        let scale = 1.0 / half;
        fit.clear();
        let mut start_range = [f32::INFINITY, 0.0];
        for TileRay { at, ray, length } in rays {
            let place = (*at - center) * scale;
            let own = coordinates(origin, mean, ray, *length);
            start_range = [start_range[0].min(own[TERMS]), start_range[1].max(own[TERMS])];
            fit.rays.push(own);
            fit.basis.push(terms(place.x, place.y));
        }
        let solved = fit_quadratics(&fit.basis, &fit.rays)?;
        let vector = |first: usize, term: usize| Vec3::from_array([0, 1, 2].map(|axis| solved[first + axis][term]));
        let directions = std::array::from_fn(|term| vector(0, term));
        let moments = std::array::from_fn(|term| vector(3, term));
        let lines = Plane { axes, directions: &directions, moments: &moments };
        let (slope_change, origin_change) = lines.changes(scale)?;
        let bends = [3, 4, 5].map(|term| lines.along(term, scale));
        let bundle = Self {
            center,
            scale,
            origin,
            axes,
            directions,
            moments,
            starts: solved[6],
            start_range,
            slope_change,
            origin_change,
            slope_bend: bends.map(|(slope, _)| slope),
            origin_bend: bends.map(|(_, origin)| origin),
        };
        fit.find_missed(&bundle).then_some(bundle)
    }

    /// A ray's coordinates in the bundle's tile.
    #[inline(always)]
    pub fn coordinates(&self, ray: &Ray, length: f32) -> [f32; COORDINATES] {
        coordinates(self.origin, self.axes[2], ray, length)
    }

    /// A coordinate (of direction, then of moment) as a function of the place.
    #[inline(always)]
    pub(in super::super) fn coordinate(&self, coordinate: usize) -> [f32; TERMS] {
        let vectors = if coordinate < 3 { &self.directions } else { &self.moments };
        let mut function = [0.0; TERMS];
        for (term, vector) in function.iter_mut().zip(vectors) {
            *term = vector[coordinate % 3];
        }
        function
    }

    /// A function of lines as one of the place.
    #[inline(always)]
    pub(in super::super) fn quadratic(&self, line: &[f32; TERMS]) -> [f32; TERMS] {
        let [x, y, z, mx, my, mz] = *line;
        let (direction, moment) = (Vec3::new(x, y, z), Vec3::new(mx, my, mz));
        let mut function = [0.0; TERMS];
        for (term, value) in function.iter_mut().enumerate() {
            *value = direction.dot(self.directions[term]) + moment.dot(self.moments[term]);
        }
        function
    }

    /// Change a pixel of the place where rays are at a depth, in the tile's plane.
    #[inline(always)]
    fn footprint(&self, depth: f32) -> Mat2 {
        self.origin_change + self.slope_change * depth
    }

    /// A bound of the change of the rays' places at a depth along a row, a pixel in both directions together,
    /// anywhere in the tile.
    #[inline(always)]
    fn largest_change(&self, row: Vec2, depth: f32) -> f32 {
        let footprint = self.footprint(depth);
        let bent = self.origin_bend.iter().zip(&self.slope_bend);
        let [uu, uv, vv] = {
            let mut sizes = [0.0; 3];
            for (size, (origin, slope)) in sizes.iter_mut().zip(bent) {
                *size = row.dot(*origin + *slope * depth).abs();
            }
            sizes
        };
        row.dot(footprint.x_axis).abs() + row.dot(footprint.y_axis).abs() + 2.0 * (uu + uv + vv)
    }

    /// The inverse footprint: from places in the plane at a depth to pixels, damped near foci.
    #[inline(always)]
    pub(in super::super) fn pixels_from_plane(&self, depth: f32) -> Mat2 {
        let footprint = self.footprint(depth);
        let square = |m: &Mat2| m.x_axis.length_squared() + m.y_axis.length_squared();
        // The footprint if no rays met at this depth.
        let apart = 0.5 * (square(&self.origin_change) + depth * depth * square(&self.slope_change));
        let damping = DAMPING * DAMPING * apart + f32::MIN_POSITIVE;
        let normal = footprint * footprint.transpose() + Mat2::from_diagonal(Vec2::splat(damping));
        footprint.transpose() * normal.inverse()
    }

    /// The largest error of the bundle at its rays between two depths, in pixels.
    #[inline(always)]
    pub fn error_px(&self, fit: &BundleFit, [near, far]: [f32; 2]) -> f32 {
        let ratio = (far / near).max(1.0);
        let mut worst = 0.0f32;
        for depth in [near, near * ratio.cube_root(), near * (ratio * ratio).cube_root(), near * ratio] {
            let pixels = self.pixels_from_plane(depth);
            for (slope, origin) in fit.missed_slopes.iter().zip(&fit.missed_origins) {
                worst = worst.max((pixels * (*origin + *slope * depth)).length_squared());
            }
        }
        worst.sqrt()
    }

    /// The bounds of the rays at a depth along a row of [`Self::pixels_from_plane`], with a margin of so many pixels,
    /// and of the bundle's error of the rays between.
    #[inline(always)]
    pub(in super::super) fn bounds_at(&self, fit: &BundleFit, row: Vec2, depth: f32, margin_px: f32) -> [f32; 2] {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for (slope, origin) in fit.slopes.iter().zip(&fit.origins) {
            let at = row.dot(*origin + *slope * depth);
            low = low.min(at);
            high = high.max(at);
        }
        let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
        for (slope, origin) in fit.missed_slopes.iter().zip(&fit.missed_origins) {
            let missed = row.dot(*origin + *slope * depth);
            least = least.min(missed);
            most = most.max(missed);
        }
        let margin = margin_px * self.largest_change(row, depth) + (most - least);
        [low - margin, high + margin]
    }
}

impl BundleFit {
    fn clear(&mut self) {
        self.rays.clear();
        self.basis.clear();
    }

    /// Compares the bundle with the rays; false where it has none of their directions.
    #[inline(always)]
    fn find_missed(&mut self, bundle: &RayBundle) -> bool {
        self.slopes.clear();
        self.origins.clear();
        self.missed_slopes.clear();
        self.missed_origins.clear();
        self.start_error = 0.0;
        for (index, basis) in self.basis.iter().enumerate() {
            let of = |vectors: &[Vec3; TERMS]| vectors.iter().zip(basis).map(|(c, b)| *c * *b).sum::<Vec3>();
            let line = (of(&bundle.directions), of(&bundle.moments));
            let along = line.0.dot(bundle.axes[2]);
            if along <= 0.0 || along.is_nan() {
                return false;
            }
            let [x, y, z, mx, my, mz, own_start] = self.rays[index];
            let own = (Vec3::new(x, y, z), Vec3::new(mx, my, mz));
            let ((slope, origin), found) = (in_plane(&bundle.axes, own), in_plane(&bundle.axes, line));
            self.slopes.push(slope);
            self.origins.push(origin);
            self.missed_slopes.push(found.0 - slope);
            self.missed_origins.push(found.1 - origin);
            let start = bundle.starts.iter().zip(basis).map(|(c, b)| c * b).sum::<f32>();
            self.start_error = self.start_error.max((start - own_start).abs());
        }
        true
    }
}
