//! Numbers and vectors of several rays or samples side by side: arrays that compilers make vector instructions of.
//!
//! An operator is a loop of its own, and compilers do not join loops. So operators are for [`LANES`], where loops are
//! unrolled and temporaries stay in registers; with [`MANY_LANES`] a formula is one loop that reads and writes single
//! lanes by index. Such loops stay loops, while longer formulas over eight lanes are unrolled before they are made
//! vector instructions of, become a tangle and take up to twice as long.

use glam::Vec3;
use std::ops::{Add, AddAssign, Deref, DerefMut, Mul, MulAssign, Sub, SubAssign};

/// The number of `f32` in a vector register of 256 bits.
pub const LANES: usize = 8;

/// The number of rays looked up side by side.
pub const MANY_LANES: usize = 32;

/// `N` numbers, each calculated with on its own.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Lanes<const N: usize = LANES>(pub [f32; N]);

impl<const N: usize> Lanes<N> {
    /// Zero in all lanes.
    pub const ZERO: Self = Self([0.0; N]);

    /// The same number in all lanes.
    #[inline(always)]
    pub const fn splat(value: f32) -> Self {
        Self([value; N])
    }
}

impl<const N: usize> Default for Lanes<N> {
    #[inline(always)]
    fn default() -> Self {
        Self::ZERO
    }
}

impl<const N: usize> Deref for Lanes<N> {
    type Target = [f32; N];
    #[inline(always)]
    fn deref(&self) -> &[f32; N] {
        &self.0
    }
}

impl<const N: usize> DerefMut for Lanes<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f32; N] {
        &mut self.0
    }
}

/// Operators between lanes, and between lanes and one number.
macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assign_method:ident $symbol:tt)*) => {$(
        impl<const N: usize> $assign for Lanes<N> {
            #[inline(always)]
            fn $assign_method(&mut self, other: Self) {
                for lane in 0..N {
                    self.0[lane] $symbol other.0[lane];
                }
            }
        }

        impl<const N: usize> $assign<f32> for Lanes<N> {
            #[inline(always)]
            fn $assign_method(&mut self, other: f32) {
                for lane in 0..N {
                    self.0[lane] $symbol other;
                }
            }
        }

        impl<const N: usize> $operator for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                self $symbol other;
                self
            }
        }

        impl<const N: usize> $operator<f32> for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: f32) -> Self {
                self $symbol other;
                self
            }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign +=
    Sub sub SubAssign sub_assign -=
    Mul mul MulAssign mul_assign *=
}

/// `N` vectors, component by component.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(transparent)]
pub struct Vec3Lanes<const N: usize = LANES>(pub [Lanes<N>; 3]);

impl<const N: usize> Vec3Lanes<N> {
    /// The zero vector in all lanes.
    pub const ZERO: Self = Self([Lanes::ZERO; 3]);

    /// The same vector in all lanes.
    #[inline(always)]
    pub fn splat(vector: Vec3) -> Self {
        Self(vector.to_array().map(Lanes::splat))
    }

    /// One vector a lane.
    #[inline(always)]
    pub fn new(vectors: &[Vec3; N]) -> Self {
        let mut lanes = Self::ZERO;
        for (lane, vector) in vectors.iter().enumerate() {
            lanes.set(lane, *vector);
        }
        lanes
    }

    /// The vector of a lane.
    #[inline(always)]
    pub fn vector(&self, lane: usize) -> Vec3 {
        Vec3::from_array(self.components(lane))
    }

    /// The components of the vector of a lane.
    #[inline(always)]
    pub fn components(&self, lane: usize) -> [f32; 3] {
        [self[0][lane], self[1][lane], self[2][lane]]
    }

    /// Sets the vector of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, vector: Vec3) {
        (self[0][lane], self[1][lane], self[2][lane]) = (vector.x, vector.y, vector.z);
    }

    /// Dot products.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> Lanes<N> {
        let mut sum = Lanes::ZERO;
        for lane in 0..N {
            let ([ax, ay, az], [bx, by, bz]) = (self.components(lane), other.components(lane));
            sum[lane] = ax * bx + ay * by + az * bz;
        }
        sum
    }
}

impl<const N: usize> Deref for Vec3Lanes<N> {
    type Target = [Lanes<N>; 3];
    #[inline(always)]
    fn deref(&self) -> &[Lanes<N>; 3] {
        &self.0
    }
}

impl<const N: usize> DerefMut for Vec3Lanes<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Lanes<N>; 3] {
        &mut self.0
    }
}

impl<const N: usize> Sub for Vec3Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for axis in 0..3 {
            self[axis] -= other[axis];
        }
        self
    }
}

impl<const N: usize> Sub<Vec3> for Vec3Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Vec3) -> Self {
        self - Self::splat(other)
    }
}

impl<const N: usize> Mul<Lanes<N>> for Vec3Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, factors: Lanes<N>) -> Self {
        for axis in 0..3 {
            self[axis] *= factors;
        }
        self
    }
}

impl Vec3Lanes<1> {
    /// A vector alone.
    #[inline(always)]
    pub fn one(vector: Vec3) -> Self {
        Self::splat(vector)
    }
}

/// A whole number from 0 on: a cast of numbers with a fraction takes several instructions.
#[inline(always)]
pub fn whole(number: f32) -> u32 {
    // From 2^23 on the lowest bits of the mantissa count ones.
    const ONES: f32 = 8_388_608.0;
    (number + ONES).to_bits() & 0x007F_FFFF
}

/// One bit a lane, the first one's lowest.
#[inline(always)]
pub fn bits_of(lanes: [bool; LANES]) -> u8 {
    // Every byte is 0 or 1: the product has their sum, each shifted to its own bit, in its highest byte.
    let bytes = u64::from_le_bytes([
        u8::from(lanes[0]),
        u8::from(lanes[1]),
        u8::from(lanes[2]),
        u8::from(lanes[3]),
        u8::from(lanes[4]),
        u8::from(lanes[5]),
        u8::from(lanes[6]),
        u8::from(lanes[7]),
    ]);
    (bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}
