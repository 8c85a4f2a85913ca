//! Scalars and vectors as polynomials of second degree in two variables: arithmetic that carries first and second
//! derivatives along.

use glam::DVec3;
use std::ops::{Add, Mul, Neg, Sub};

/// The pairs of variables that second derivatives are stored for, in order.
pub const PAIRS: [(usize, usize); 3] = [(0, 0), (0, 1), (1, 1)];

/// A number or vector with its first derivatives and its second ones (uu, uv, vv).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet<T> {
    /// The number or vector.
    pub value: T,
    /// First derivatives.
    pub first: [T; 2],
    /// Second derivatives: uu, uv, vv.
    pub second: [T; 3],
}

/// A number with its derivatives.
pub type ScalarJet = Jet<f64>;

/// A vector with its derivatives.
pub type VectorJet = Jet<DVec3>;

impl<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>> Jet<T> {
    /// A constant.
    pub fn constant(value: T) -> Self {
        Self { value, ..Self::default() }
    }

    /// The product with a scalar, by the rule of Leibniz.
    pub fn scaled(&self, factor: &ScalarJet) -> Self {
        Self {
            value: self.value * factor.value,
            first: std::array::from_fn(|a| self.first[a] * factor.value + self.value * factor.first[a]),
            second: std::array::from_fn(|k| {
                let (a, b) = PAIRS[k];
                self.second[k] * factor.value
                    + self.first[a] * factor.first[b]
                    + self.first[b] * factor.first[a]
                    + self.value * factor.second[k]
            }),
        }
    }
}

impl ScalarJet {
    /// A function of this number, from the function's value and its first two derivatives.
    #[inline]
    pub fn chain(self, value: f64, slope: f64, bend: f64) -> Self {
        Self {
            value,
            first: self.first.map(|d| slope * d),
            second: std::array::from_fn(|k| {
                let (a, b) = PAIRS[k];
                slope * self.second[k] + bend * self.first[a] * self.first[b]
            }),
        }
    }

    /// The square root; the number must be above 0.
    #[inline]
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root, -0.25 / (root * self.value))
    }

    /// One over the number.
    #[inline]
    pub fn recip(self) -> Self {
        let inverse = 1.0 / self.value;
        self.chain(inverse, -inverse * inverse, 2.0 * inverse * inverse * inverse)
    }
}

impl<T: Copy + Add<Output = T>> Add for Jet<T> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: std::array::from_fn(|a| self.first[a] + other.first[a]),
            second: std::array::from_fn(|k| self.second[k] + other.second[k]),
        }
    }
}

impl<T: Copy + Mul<f64, Output = T>> Mul<f64> for Jet<T> {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            first: self.first.map(|d| d * factor),
            second: self.second.map(|d| d * factor),
        }
    }
}

impl<T: Copy + Mul<f64, Output = T>> Neg for Jet<T> {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<T: Copy + Add<Output = T> + Mul<f64, Output = T>> Sub for Jet<T> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for ScalarJet {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        self.scaled(&other)
    }
}

impl VectorJet {
    /// The scalar product.
    #[inline]
    pub fn dot(&self, other: &Self) -> ScalarJet {
        ScalarJet {
            value: self.value.dot(other.value),
            first: std::array::from_fn(|a| self.first[a].dot(other.value) + self.value.dot(other.first[a])),
            second: std::array::from_fn(|k| {
                let (a, b) = PAIRS[k];
                self.second[k].dot(other.value)
                    + self.first[a].dot(other.first[b])
                    + self.first[b].dot(other.first[a])
                    + self.value.dot(other.second[k])
            }),
        }
    }

    /// The vector at unit length; it must not vanish.
    #[inline]
    pub fn normalized(&self) -> Self {
        self.scaled(&self.dot(self).sqrt().recip())
    }

    /// This function of two variables at other variables `u`, which are functions themselves.
    ///
    /// `u` must be 0 in its value: the expansion is about the same point.
    #[inline]
    pub fn composed(&self, u: &[ScalarJet; 2]) -> Self {
        Self {
            value: self.value,
            first: std::array::from_fn(|a| self.first[0] * u[0].first[a] + self.first[1] * u[1].first[a]),
            second: std::array::from_fn(|k| {
                let (a, b) = PAIRS[k];
                let mixed = u[0].first[a] * u[1].first[b] + u[1].first[a] * u[0].first[b];
                self.first[0] * u[0].second[k]
                    + self.first[1] * u[1].second[k]
                    + self.second[0] * (u[0].first[a] * u[0].first[b])
                    + self.second[1] * mixed
                    + self.second[2] * (u[1].first[a] * u[1].first[b])
            }),
        }
    }

    /// Returns true if every number is finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.value.is_finite() && self.first.iter().chain(&self.second).all(|vector| vector.is_finite())
    }
}
