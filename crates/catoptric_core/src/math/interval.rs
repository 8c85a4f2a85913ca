//! Interval arithmetic: bounds of a function, and of its derivative, over a range of its argument.

use super::scalar::Scalar;
use crate::math::portable::PortableMath;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// All numbers from `low` to `high`, which may be infinite. Results hold every result of their operands' members: they
/// are widened by more than the rounding. Empty (outside the domain of a function) where the bounds are not numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The lower bound.
    pub low: f64,
    /// The upper bound.
    pub high: f64,
}

/// The relative widening of results: two units in the last place, which the functions of `std` keep.
const WIDENING: f64 = 2.0 * f64::EPSILON;

impl Interval {
    /// Everything.
    pub const ENTIRE: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };
    /// Nothing.
    pub const EMPTY: Self = Self { low: f64::NAN, high: f64::NAN };

    /// The numbers between two bounds, without widening.
    #[inline]
    pub fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    #[inline]
    fn widened(low: f64, high: f64) -> Self {
        let low = low - (low.abs() * WIDENING + f64::MIN_POSITIVE);
        let high = high + (high.abs() * WIDENING + f64::MIN_POSITIVE);
        // Infinity minus infinity: the operands were unbounded or empty.
        Self { low, high }
    }

    /// Returns true if it holds no number.
    #[inline]
    pub fn is_empty(self) -> bool {
        self.low.is_nan() || self.high.is_nan()
    }

    /// Returns true if zero is a member.
    #[inline]
    pub fn contains_zero(self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }

    /// Returns true if both bounds are finite.
    #[inline]
    pub fn is_bounded(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// The common members; of an empty and another one, nothing.
    #[inline]
    pub fn intersection(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    /// A function that rises everywhere.
    #[inline]
    fn rising(self, function: impl Fn(f64) -> f64) -> Self {
        Self::widened(function(self.low), function(self.high))
    }

    /// The cosine of `self` less that many quarter turns: cosine (0) or sine (1).
    #[inline]
    fn cosine(self, quarter_turns: f64) -> Self {
        let function = |x: f64| if quarter_turns == 0.0 { x.cosine() } else { x.sine() };
        if self.is_empty() {
            return self;
        }
        // Reductions of huge arguments lose the phase.
        if !(self.high - self.low < TAU && self.low.abs().max(self.high.abs()) < 1e9) {
            return Self::new(-1.0, 1.0);
        }
        let (first, last) = (function(self.low), function(self.high));
        let (mut low, mut high) = (first.min(last), first.max(last));
        // True if the argument passes a maximum (whole turns) or a minimum (half turns), with room for rounding.
        let passes = |phase: f64| {
            let (from, to) = ((self.low - phase) / TAU - 1e-7, (self.high - phase) / TAU + 1e-7);
            to.floor() >= from.ceil()
        };
        if passes(quarter_turns * FRAC_PI_2) {
            high = 1.0;
        }
        if passes(quarter_turns * FRAC_PI_2 + 2.0 * FRAC_PI_2) {
            low = -1.0;
        }
        let Self { low, high } = Self::widened(low, high);
        Self { low: low.max(-1.0), high: high.min(1.0) }
    }
}

impl Add for Interval {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::widened(self.low + other.low, self.high + other.high)
    }
}

impl Sub for Interval {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::widened(self.low - other.high, self.high - other.low)
    }
}

impl Neg for Interval {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }
}

/// A product of bounds; zero times infinity is zero, as infinite bounds stand for large numbers.
#[inline]
fn product(a: f64, b: f64) -> f64 {
    let product = a * b;
    if product.is_nan() && !a.is_nan() && !b.is_nan() { 0.0 } else { product }
}

impl Mul for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        let (a, b) = (product(self.low, other.low), product(self.low, other.high));
        let (c, d) = (product(self.high, other.low), product(self.high, other.high));
        Self::widened(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }
}

impl Div for Interval {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        if other.contains_zero() {
            return Self::ENTIRE;
        }
        self * Self::widened(1.0 / other.high, 1.0 / other.low)
    }
}

impl Scalar for Interval {
    #[inline]
    fn constant(value: f64) -> Self {
        Self { low: value, high: value }
    }

    #[inline]
    fn representative(self) -> f64 {
        0.5 * (self.low + self.high)
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        if self.is_empty() || exponent == 1 {
            return self;
        }
        if exponent < 0 {
            return Self::constant(1.0) / Scalar::powi(self, exponent.saturating_neg());
        }
        // std's whole powers lose up to a unit in the last place a multiplication.
        let slack = |value: f64| value.abs() * (exponent as f64 * f64::EPSILON);
        let (a, b) = (self.low.powi(exponent), self.high.powi(exponent));
        let (low, high) = if exponent % 2 == 1 || self.low >= 0.0 {
            (a, b)
        } else if self.high <= 0.0 {
            (b, a)
        } else {
            (0.0, a.max(b))
        };
        Self::widened(low - slack(low), high + slack(high))
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        if self.is_empty() || self.high < 0.0 {
            return Self::EMPTY;
        }
        if exponent < 0.0 {
            return Self::constant(1.0) / self.powf(-exponent);
        }
        let clipped = Self { low: self.low.max(0.0), high: self.high };
        let Self { low, high } = clipped.rising(|x| x.power(exponent));
        Self { low: low.max(0.0), high }
    }

    #[inline]
    fn sqrt(self) -> Self {
        if self.is_empty() || self.high < 0.0 {
            return Self::EMPTY;
        }
        let Self { low, high } = Self { low: self.low.max(0.0), high: self.high }.rising(f64::sqrt);
        Self { low: low.max(0.0), high }
    }

    #[inline]
    fn exp(self) -> Self {
        let Self { low, high } = self.rising(f64::exponential);
        if low.is_nan() { Self::EMPTY } else { Self { low: low.max(0.0), high } }
    }

    #[inline]
    fn ln(self) -> Self {
        if self.is_empty() || self.high <= 0.0 {
            return Self::EMPTY;
        }
        Self { low: self.low.max(0.0), high: self.high }.rising(f64::logarithm)
    }

    #[inline]
    fn sin(self) -> Self {
        self.cosine(1.0)
    }

    #[inline]
    fn cos(self) -> Self {
        self.cosine(0.0)
    }

    #[inline]
    fn abs(self) -> Self {
        if self.low >= 0.0 {
            self
        } else if self.high <= 0.0 {
            -self
        } else {
            // Empty stays empty: no comparison holds, and the maximum is NaN.
            let high = if self.is_empty() { f64::NAN } else { self.high.max(-self.low) };
            Self { low: high.min(0.0), high }
        }
    }
}

/// Bounds of a function and of its derivative by one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntervalDual {
    /// Bounds of the value.
    pub value: Interval,
    /// Bounds of the derivative.
    pub slope: Interval,
}

impl IntervalDual {
    #[inline]
    fn chain(self, value: Interval, derivative: Interval) -> Self {
        Self { value, slope: derivative * self.slope }
    }
}

impl Add for IntervalDual {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

impl Sub for IntervalDual {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, slope: self.slope - other.slope }
    }
}

impl Neg for IntervalDual {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, slope: -self.slope }
    }
}

impl Mul for IntervalDual {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, slope: self.slope * other.value + self.value * other.slope }
    }
}

impl Div for IntervalDual {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self { value, slope: (self.slope - value * other.slope) / other.value }
    }
}

impl Scalar for IntervalDual {
    #[inline]
    fn constant(value: f64) -> Self {
        Self { value: Interval::constant(value), slope: Interval::constant(0.0) }
    }

    #[inline]
    fn representative(self) -> f64 {
        self.value.representative()
    }

    #[inline]
    fn powi(self, exponent: i32) -> Self {
        if exponent == 0 {
            return Self::constant(1.0);
        }
        let derivative = Interval::constant(exponent as f64) * Scalar::powi(self.value, exponent - 1);
        self.chain(Scalar::powi(self.value, exponent), derivative)
    }

    #[inline]
    fn powf(self, exponent: f64) -> Self {
        let derivative = Interval::constant(exponent) * self.value.powf(exponent - 1.0);
        self.chain(self.value.powf(exponent), derivative)
    }

    #[inline]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, Interval::constant(0.5) / root)
    }

    #[inline]
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }

    #[inline]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), Interval::constant(1.0) / self.value)
    }

    #[inline]
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    #[inline]
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    #[inline]
    fn abs(self) -> Self {
        let sign = if self.value.low > 0.0 {
            Interval::constant(1.0)
        } else if self.value.high < 0.0 {
            Interval::constant(-1.0)
        } else {
            Interval::new(-1.0, 1.0)
        };
        self.chain(self.value.abs(), sign)
    }
}
