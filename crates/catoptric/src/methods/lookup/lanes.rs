//! Numbers and vectors of several rays side by side.
//!
//! Loops over the rays of [`AT_ONCE`] stay loops, and the compiler makes vector instructions of them; loops over eight are
//! unrolled first, become a tangle, and take twice as long. One ray alone is one lane: the same arithmetic.

use glam::Vec3;

/// As many rays as are looked up side by side.
pub(super) const AT_ONCE: usize = 32;

/// A number of each ray.
pub(super) type Lane<const LANES: usize> = [f32; LANES];

/// A vector of each ray, component by component.
pub(super) type Lanes<const LANES: usize> = [Lane<LANES>; 3];

/// Vectors component by component.
#[inline(always)] // for the instructions of its caller
pub(super) fn side_by_side<const LANES: usize>(vectors: &[Vec3; LANES]) -> Lanes<LANES> {
    let mut lanes = [[0.0; LANES]; 3];
    for (lane, vector) in vectors.iter().enumerate() {
        lanes[0][lane] = vector.x;
        lanes[1][lane] = vector.y;
        lanes[2][lane] = vector.z;
    }
    lanes
}

/// A vector as the only one.
#[inline(always)] // for the instructions of its caller
pub(super) fn one(vector: Vec3) -> Lanes<1> {
    side_by_side(&[vector])
}

/// The vector of one ray.
#[inline(always)] // for the instructions of its caller
pub(super) fn vector<const LANES: usize>(lanes: &Lanes<LANES>, lane: usize) -> Vec3 {
    Vec3::new(lanes[0][lane], lanes[1][lane], lanes[2][lane])
}

/// A whole number from 0 on: a cast of what can have a fraction takes several instructions.
#[inline(always)] // for the instructions of its caller
pub(super) fn whole(number: f32) -> u32 {
    // From 2^23 on the lowest bits of the mantissa count ones.
    const ONES: f32 = 8_388_608.0;
    (number + ONES).to_bits() & 0x007F_FFFF
}
