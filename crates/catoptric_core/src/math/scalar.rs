//! Functions written once and evaluated over numbers, dual numbers and intervals.

use num_dual::DualNum;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The number types of implicit functions: numbers, dual numbers (for derivatives) or intervals (for bounds).
pub trait Scalar:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A constant.
    fn constant(value: f64) -> Self;
    /// A number to represent it: the value without derivatives, the middle of an interval.
    fn representative(self) -> f64;
    /// A whole power.
    fn powi(self, exponent: i32) -> Self;
    /// A power of a value that is not negative.
    fn powf(self, exponent: f64) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// e to this power.
    fn exp(self) -> Self;
    /// The natural logarithm.
    fn ln(self) -> Self;
    /// The sine.
    fn sin(self) -> Self;
    /// The cosine.
    fn cos(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
}

/// A root or power; at zero, where derivatives of those are infinite and would come out as no numbers, with the
/// derivatives beside it: they come out large instead, or as the zero that multiplies them.
#[inline]
fn off_zero<D: DualNum<f64, Real = f64> + Copy>(value: D, at_zero: f64, function: impl Fn(D) -> D) -> D {
    if D::NDERIV > 0 && value.re() == 0.0 {
        let beside = function(value + 1e-30);
        return beside + (at_zero - beside.re());
    }
    function(value)
}

impl<D: DualNum<f64, Real = f64> + Copy> Scalar for D {
    fn constant(value: f64) -> Self {
        D::from(value)
    }
    fn representative(self) -> f64 {
        self.re()
    }
    fn powi(self, exponent: i32) -> Self {
        DualNum::powi(&self, exponent)
    }
    fn powf(self, exponent: f64) -> Self {
        off_zero(self, 0f64.powf(exponent), |value| DualNum::powf(&value, exponent))
    }
    fn sqrt(self) -> Self {
        off_zero(self, 0.0, |value| DualNum::sqrt(&value))
    }
    fn exp(self) -> Self {
        DualNum::exp(&self)
    }
    fn ln(self) -> Self {
        DualNum::ln(&self)
    }
    fn sin(self) -> Self {
        DualNum::sin(&self)
    }
    fn cos(self) -> Self {
        DualNum::cos(&self)
    }
    fn abs(self) -> Self {
        <D as num_traits::Signed>::abs(&self)
    }
}
