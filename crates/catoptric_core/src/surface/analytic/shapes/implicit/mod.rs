//! Surfaces where an expression of the user is zero.

mod expression;

use super::super::derivatives::{self, ImplicitFunction};
use super::super::implicit_shape::ImplicitShape;
use super::super::parameters::{SurfaceError, checked_bounds};
use super::super::ray::clip;
use super::super::tessellation::mesh::SurfaceMesh;
use super::super::tessellation::polygonise::{Field, polygonise};
use crate::math::interval::{Interval, IntervalDual};
use crate::math::roots::first_interval_root;
use crate::math::scalar::Scalar;
use crate::surface::taylor::{Taylor2, Taylor3};
pub use expression::{Expression, Instruction};
use glam::DVec3;
use num_dual::Dual64;
use std::sync::Arc;

/// The part within bounds of the surface where an expression of `x`, `y` and `z` is zero. The outer side is where it
/// is positive.
///
/// `g` is the expression times a constant that brings the length of its gradient near 1 on the surface. Where it has no
/// value (under a root of a negative number, say) there is no surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Implicit {
    text: Arc<str>,
    expression: Arc<Expression>,
    bounds: [DVec3; 2],
    /// The ratio of its size to the size as written.
    scale: f64,
    /// The factor on the expression, at the size in which it is written.
    factor: f64,
}

impl Implicit {
    /// The surface of an expression with numbers, `x`, `y`, `z`, `+ - * / ^`, parentheses and the functions `sqrt`,
    /// `exp`, `sin`, `cos` and `abs`, cut by a box whose corners are at most 1e9 from the origin. At most 2,000 bytes
    /// and 500 operations; errors name the character.
    pub fn new(text: &str, bounds_min: [f64; 3], bounds_max: [f64; 3]) -> Result<Self, SurfaceError> {
        let bounds = checked_bounds(bounds_min, bounds_max)?;
        let expression = Arc::new(Expression::parse(text)?);
        let mut surface = Self { text: text.into(), expression, bounds, scale: 1.0, factor: 1.0 };
        match surface.typical_slope() {
            Some(slope) => surface.factor = 1.0 / slope,
            None => return Err(SurfaceError::new("expression", "has no value anywhere in the bounds")),
        }
        Ok(surface)
    }

    /// The expression, as it was written.
    pub fn expression(&self) -> &str {
        &self.text
    }

    /// The program of `g`, for other evaluators: `g` is its value at the point over the first number, times the second
    /// one.
    pub fn program(&self) -> (&[Instruction], [f64; 2]) {
        (self.expression.steps(), [self.scale, self.factor * self.scale])
    }

    /// The most values that wait at once while a program runs.
    pub const MAX_DEPTH: usize = expression::MAX_DEPTH;

    pub(in super::super) fn scaled(&self, scale: f64) -> Self {
        let bounds = self.bounds.map(|corner| corner * scale);
        Self { bounds, scale: self.scale * scale, ..self.clone() }
    }

    /// The mean length of the gradient where the surface is near, estimated on a coarse grid; 1 where it is nowhere
    /// near. Returns `None` if the expression has no value at any point of the grid.
    fn typical_slope(&self) -> Option<f64> {
        const STEPS: u32 = 16;
        let [min, max] = self.bounds;
        let reach = (max - min).max_element() / STEPS as f64;
        let (mut sum, mut count, mut has_value) = (0.0, 0.0, false);
        for index in 0..(STEPS + 1).pow(3) {
            let at = [index % (STEPS + 1), index / (STEPS + 1) % (STEPS + 1), index / (STEPS + 1).pow(2)];
            let point = min + (max - min) * DVec3::from(at.map(|step| step as f64 / STEPS as f64));
            let (value, slope) = (Field::value(self, point), self.gradient(point).length());
            has_value |= value.is_finite();
            if value.is_finite() && slope.is_finite() && value.abs() <= reach * slope {
                sum += slope;
                count += 1.0;
            }
        }
        let mean = sum / count;
        has_value.then_some(if (1e-100..1e100).contains(&mean) { mean } else { 1.0 })
    }
}

impl Field for Implicit {
    fn value(&self, point: DVec3) -> f64 {
        ImplicitFunction::value(self, point.to_array())
    }

    fn value_and_slope(&self, point: DVec3, direction: DVec3) -> (f64, f64) {
        let dual = [0, 1, 2].map(|axis| Dual64::new(point[axis], direction[axis]));
        let dual = ImplicitFunction::value(self, dual);
        (dual.re, dual.eps)
    }

    fn gradient(&self, point: DVec3) -> DVec3 {
        let along = |axis: DVec3| self.value_and_slope(point, axis).1;
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    }
}

impl ImplicitFunction for Implicit {
    #[inline]
    fn value<S: Scalar>(&self, point: [S; 3]) -> S {
        if self.scale == 1.0 {
            return self.expression.evaluate(point) * S::constant(self.factor);
        }
        let shrink = S::constant(1.0 / self.scale);
        self.expression.evaluate(point.map(|x| x * shrink)) * S::constant(self.factor * self.scale)
    }
}

/// A value that is NaN or infinite stands for a place without surface: not zero, and without a gradient.
fn without_nonsense(taylor: Taylor2) -> Taylor2 {
    let is_finite = taylor.value.is_finite() && taylor.gradient.is_finite() && taylor.hessian.is_finite();
    if is_finite { taylor } else { Taylor2 { value: 1.0, ..Taylor2::default() } }
}

impl ImplicitShape for Implicit {
    fn corners(&self) -> [DVec3; 2] {
        self.bounds
    }

    fn taylor2(&self, point: DVec3) -> Taylor2 {
        without_nonsense(derivatives::taylor2(self, point))
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        let taylor = derivatives::taylor3(self, point);
        let lower = without_nonsense(taylor.lower);
        if taylor.third.iter().all(|third| third.is_finite()) {
            Taylor3 { lower, ..taylor }
        } else {
            derivatives::without_third(lower)
        }
    }

    fn outwards(&self, point: DVec3) -> DVec3 {
        self.gradient(point)
    }

    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        let (enter, leave) = clip(origin, direction, self.bounds, near, far)?;
        first_interval_root(
            |t| {
                ImplicitFunction::value(
                    self,
                    [0, 1, 2].map(|axis| {
                        let slope = Interval::constant(direction[axis]);
                        IntervalDual { value: Interval::constant(origin[axis]) + t * slope, slope }
                    }),
                )
            },
            |t| self.value_and_slope(origin + direction * t, direction),
            enter,
            leave,
        )
    }

    fn tessellate(&self, fineness: f64) -> SurfaceMesh {
        polygonise(self.bounds, fineness, self)
    }
}
