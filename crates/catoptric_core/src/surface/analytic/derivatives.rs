//! Derivatives of implicit functions by dual numbers.

use crate::math::scalar::Scalar;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3};
use num_dual::{HyperDual64, HyperHyperDual64};

/// A function of a point, written once for numbers, dual numbers and intervals.
pub(super) trait ImplicitFunction {
    /// The function's value.
    fn value<S: Scalar>(&self, point: [S; 3]) -> S;
}

/// Value, gradient and Hessian, exact to rounding, by hyper-dual numbers (Fike and Alonso 2011): six evaluations.
pub(super) fn taylor2(function: &impl ImplicitFunction, point: DVec3) -> Taylor2 {
    let mut taylor = Taylor2::default();
    for i in 0..3 {
        for j in i..3 {
            let seed = |axis: usize| {
                let one = |index: usize| if index == axis { 1.0 } else { 0.0 };
                HyperDual64::new(point[axis], one(i), one(j), 0.0)
            };
            let result = function.value([seed(0), seed(1), seed(2)]);
            taylor.value = result.re;
            taylor.gradient[i] = result.eps1;
            taylor.gradient[j] = result.eps2;
            set_symmetric(&mut taylor.hessian, i, j, result.eps1eps2);
        }
    }
    taylor
}

/// Value and all derivatives to third order, exact to rounding, by hyper-hyper-dual numbers: ten evaluations, one for
/// each third derivative.
pub(super) fn taylor3(function: &impl ImplicitFunction, point: DVec3) -> Taylor3 {
    let mut taylor = Taylor3::default();
    for i in 0..3 {
        for j in i..3 {
            for k in j..3 {
                let seed = |axis: usize| {
                    let one = |index: usize| if index == axis { 1.0 } else { 0.0 };
                    HyperHyperDual64::new(point[axis], one(i), one(j), one(k), 0.0, 0.0, 0.0, 0.0)
                };
                let result = function.value([seed(0), seed(1), seed(2)]);
                taylor.lower.value = result.re;
                taylor.lower.gradient[i] = result.eps1;
                taylor.lower.gradient[k] = result.eps3;
                set_symmetric(&mut taylor.lower.hessian, i, j, result.eps1eps2);
                set_symmetric(&mut taylor.lower.hessian, j, k, result.eps2eps3);
                set_symmetric(&mut taylor.lower.hessian, i, k, result.eps1eps3);
                let third = result.eps1eps2eps3;
                set_symmetric(&mut taylor.third[i], j, k, third);
                set_symmetric(&mut taylor.third[j], i, k, third);
                set_symmetric(&mut taylor.third[k], i, j, third);
            }
        }
    }
    taylor
}

fn set_symmetric(matrix: &mut DMat3, row: usize, column: usize, value: f64) {
    matrix.col_mut(column)[row] = value;
    matrix.col_mut(row)[column] = value;
}

/// The product `a b^T`.
#[inline]
pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// A function without third derivatives.
pub(super) fn without_third(lower: Taylor2) -> Taylor3 {
    Taylor3 { lower, third: [DMat3::ZERO; 3] }
}
