//! Quadrics.

use super::super::derivatives::without_third;
use super::super::implicit_shape::ImplicitShape;
use super::super::parameters::{SurfaceError, checked_bounds};
use super::super::ray::clip;
use super::super::tessellation::mesh::SurfaceMesh;
use super::super::tessellation::polygonise::{Field, polygonise};
use crate::math::roots::first_bernstein_root;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3};

/// The part of a quadric within bounds: `g` is the polynomial, divided by the largest length of its gradient within
/// the bounds. The outer side is where the polynomial is positive.
#[derive(Clone, Debug, PartialEq)]
pub struct Quadric {
    coefficients: [f64; 10],
    bounds: [DVec3; 2],
    /// `g = p^T curved p / 2 + straight p + offset`.
    curved: DMat3,
    straight: DVec3,
    offset: f64,
}

impl Quadric {
    /// The surface where `xx x^2 + yy y^2 + zz z^2 + xy x y + yz y z + zx z x + x x + y y + z z + 1` is 0, for the
    /// coefficients `[xx, yy, zz, xy, yz, zx, x, y, z, 1]`, cut by a box. Bounds are at most 1e9 from the origin.
    pub fn new(coefficients: [f64; 10], bounds_min: [f64; 3], bounds_max: [f64; 3]) -> Result<Self, SurfaceError> {
        let bounds = checked_bounds(bounds_min, bounds_max)?;
        let wrong = |problem: &str| Err(SurfaceError::new("coefficients", format!("{coefficients:?}; {problem}")));
        let largest = coefficients.iter().fold(0f64, |largest, c| largest.max(c.abs()));
        if coefficients.iter().any(|c| !c.is_finite()) || !(largest == 0.0 || (1e-100..1e100).contains(&largest)) {
            return wrong("the largest must be from 1e-100 to 1e100");
        }
        if coefficients[..9].iter().all(|c| *c == 0.0) {
            return wrong("one besides the last must not be 0");
        }
        match Self::scaled_to_bounds(coefficients, bounds) {
            Some(quadric) => Ok(quadric),
            None => wrong("the gradient must not vanish throughout the bounds"),
        }
    }

    /// The polynomial over the largest length of its gradient; returns `None` if that is 0.
    fn scaled_to_bounds(coefficients: [f64; 10], bounds: [DVec3; 2]) -> Option<Self> {
        let [xx, yy, zz, xy, yz, zx, x, y, z, one] = coefficients;
        let curved =
            DMat3::from_cols(DVec3::new(2.0 * xx, xy, zx), DVec3::new(xy, 2.0 * yy, yz), DVec3::new(zx, yz, 2.0 * zz));
        let straight = DVec3::new(x, y, z);
        // The gradient is linear: it is longest in a corner.
        let corner = |bits: usize| {
            let pick = |axis: usize| bounds[(bits >> axis) & 1][axis];
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let longest = (0..8).map(|bits| (curved * corner(bits) + straight).length()).fold(0.0, f64::max);
        let inverse = 1.0 / longest;
        (longest > 0.0 && inverse.is_finite()).then(|| Self {
            coefficients,
            bounds,
            curved: curved * inverse,
            straight: straight * inverse,
            offset: one * inverse,
        })
    }

    /// The coefficients as they were given (and scaled).
    pub fn coefficients(&self) -> [f64; 10] {
        self.coefficients
    }

    pub(in super::super) fn scaled(&self, scale: f64) -> Self {
        let mut coefficients = self.coefficients;
        let (second, lower) = coefficients.split_at_mut(6);
        second.iter_mut().for_each(|c| *c /= scale * scale);
        lower[..3].iter_mut().for_each(|c| *c /= scale);
        let bounds = self.bounds.map(|corner| corner * scale);
        Self {
            coefficients,
            bounds,
            curved: self.curved * (1.0 / scale),
            straight: self.straight,
            offset: self.offset * scale,
        }
    }

    /// The polynomial's polar form: symmetric, linear in each point, and `g` where both are the same.
    fn blossom(&self, p: DVec3, q: DVec3) -> f64 {
        0.5 * (p.dot(self.curved * q) + self.straight.dot(p + q)) + self.offset
    }
}

impl Field for Quadric {
    fn value(&self, point: DVec3) -> f64 {
        self.blossom(point, point)
    }

    fn value_and_slope(&self, point: DVec3, direction: DVec3) -> (f64, f64) {
        (self.value(point), self.gradient(point).dot(direction))
    }

    #[inline]
    fn gradient(&self, point: DVec3) -> DVec3 {
        self.curved * point + self.straight
    }
}

impl ImplicitShape for Quadric {
    fn corners(&self) -> [DVec3; 2] {
        self.bounds
    }

    #[inline]
    fn taylor2(&self, point: DVec3) -> Taylor2 {
        Taylor2 { value: self.blossom(point, point), gradient: self.gradient(point), hessian: self.curved }
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        without_third(self.taylor2(point))
    }

    #[inline]
    fn outwards(&self, point: DVec3) -> DVec3 {
        self.gradient(point)
    }

    #[inline]
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        let (enter, leave) = clip(origin, direction, self.bounds, near, far)?;
        let (p, q) = (origin + direction * enter, origin + direction * leave);
        let coefficients = [self.blossom(p, p), self.blossom(p, q), self.blossom(q, q)];
        let share = first_bernstein_root(&coefficients)?;
        Some(enter + share * (leave - enter))
    }

    fn tessellate(&self, fineness: f64) -> SurfaceMesh {
        polygonise(self.bounds, fineness, self)
    }
}
