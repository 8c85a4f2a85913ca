//! Functions written once and evaluated over numbers, dual numbers and intervals.

use super::portable::PortableMath;
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
fn off_zero<D: DualNum<Primitive = f64> + Copy>(value: D, at_zero: f64, function: impl Fn(D) -> D) -> D {
    if D::NDERIV > 0 && value.re() == 0.0 {
        let beside = function(value + 1e-30);
        return beside + (at_zero - beside.re());
    }
    function(value)
}

/// The most derivatives that numbers have.
const MAX_DERIVATIVES: usize = 3;

/// A function of a number by its derivatives there (the zeroth is its value): its Taylor polynomial, which is exact,
/// since the powers of what a dual number has beside its real part vanish beyond its derivatives. The library's own
/// functions are the system's, which differ in their last bits from machine to machine.
#[inline]
fn by_derivatives<D: DualNum<Primitive = f64> + Copy>(value: D, derivative: impl Fn(i32) -> f64) -> D {
    const FACTORIALS: [f64; MAX_DERIVATIVES + 1] = [1.0, 1.0, 2.0, 6.0];
    let mut sum = D::from(derivative(0));
    if D::NDERIV == 0 {
        return sum;
    }
    let beside = value - value.re();
    let mut power = beside;
    for (order, factorial) in (0..).zip(FACTORIALS).take(D::NDERIV + 1).skip(1) {
        sum += power * (derivative(order) / factorial);
        power *= beside;
    }
    sum
}

impl<D: DualNum<Primitive = f64> + Copy> Scalar for D {
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
        off_zero(self, 0f64.power(exponent), |value| {
            let (x, most) = (value.re(), D::NDERIV.min(MAX_DERIVATIVES) as i32);
            let exact = x.power(exponent);
            let lowest = if most > 0 { x.power(exponent - f64::from(most)) } else { exact };
            let falling = |order: i32| (0..order).map(|less| exponent - f64::from(less)).product::<f64>();
            let multiplied = |order: i32| (order..most).fold(lowest, |product, _| product * x);
            let derivative = |order: i32| match falling(order) {
                _ if order == 0 => exact,
                // Where the power is infinite, too.
                0.0 => 0.0,
                factor => factor * multiplied(order),
            };
            by_derivatives(value, derivative)
        })
    }
    fn sqrt(self) -> Self {
        off_zero(self, 0.0, |value| DualNum::sqrt(&value))
    }
    fn exp(self) -> Self {
        let value = self.re().exponential();
        by_derivatives(self, |_| value)
    }
    fn ln(self) -> Self {
        let x = self.re();
        by_derivatives(self, |order| match order {
            0 => x.logarithm(),
            1 => 1.0 / x,
            2 => -1.0 / (x * x),
            _ => 2.0 / (x * x * x),
        })
    }
    fn sin(self) -> Self {
        let (sine, cosine) = self.re().sine_cosine();
        by_derivatives(self, |order| [sine, cosine, -sine, -cosine][order as usize % 4])
    }
    fn cos(self) -> Self {
        let (sine, cosine) = self.re().sine_cosine();
        by_derivatives(self, |order| [cosine, -sine, -cosine, sine][order as usize % 4])
    }
    fn abs(self) -> Self {
        <D as num_traits::Signed>::abs(&self)
    }
}
