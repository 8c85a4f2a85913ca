//! Rounding and logarithms that compilers make vector instructions of on every machine.

/// 1.5 * 2^23: added to a number within +-2^22, it leaves the number's nearest integer in the lowest bits.
const ROUNDER: f32 = 12_582_912.0;

/// Rounds a number within +-2^22 towards negative infinity. The library's is a call on machines without SSE 4.1.
#[inline(always)]
pub fn floor(value: f32) -> f32 {
    let rounded = (value + ROUNDER) - ROUNDER;
    if rounded > value { rounded - 1.0 } else { rounded }
}

/// A whole number of at least 0 and below 2^22 as an index.
#[inline(always)]
pub fn index(value: f32) -> u32 {
    (value + ROUNDER).to_bits() & 0x3f_ffff
}

/// The binary logarithm of a positive, normal number, to 1e-6. The library's is a call.
#[inline(always)]
pub fn log2(value: f32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let bits = value.to_bits();
    let exponent = (bits.wrapping_sub(SQRT_HALF_BITS) as i32) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub((exponent << 23) as u32));
    // ln m = 2 artanh t.
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let t2 = t * t;
    let series = 1.0 + t2 * (1.0 / 3.0 + t2 * (1.0 / 5.0 + t2 * (1.0 / 7.0 + t2 * (1.0 / 9.0))));
    exponent as f32 + 2.0 * std::f32::consts::LOG2_E * t * series
}
