//! Radiance in four bytes, parallax in two, and views at all resolutions.

use glam::Vec3;

/// Bits of a mantissa, and the bias of exponents (OpenGL's `RGB9_E5`).
const MANTISSA_BITS: i32 = 9;
const BIAS: i32 = 15;

/// The greatest radiance that can be stored.
pub const LARGEST: f32 = (511.0 / 512.0) * 65536.0;

/// The greatest parallax that is stored: in units of the slope, from view to view along the longer spacing. Nearer
/// surfaces are out of sight of the next view anyway.
pub const MAX_PARALLAX: f32 = 2.0;

/// Radiance as three mantissas of nine bits with one exponent: an error of 1/512 of the largest component, or of 2^-25,
/// at the most. Values below 0 become 0, and those too large (above 65,408) the largest that can be stored.
#[inline]
pub fn packed(radiance: Vec3) -> u32 {
    // NaN is not above 0.
    let [r, g, b] = radiance.to_array().map(|value| if value > 0.0 { value.min(LARGEST) } else { 0.0 });
    let largest = r.max(g).max(b);
    let exponent = ((largest.to_bits() >> 23) as i32 - 127).max(-BIAS - 1) + 1 + BIAS;
    let scale = |exponent: i32| f32::from_bits(((MANTISSA_BITS + BIAS - exponent + 127) as u32) << 23);
    // Rounded up, the largest may need the next exponent.
    let exponent = if largest * scale(exponent) + 0.5 >= 512.0 { exponent + 1 } else { exponent };
    let [r, g, b] = [r, g, b].map(|value| (value * scale(exponent) + 0.5) as u32);
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

/// Bits of packed numbers' mantissas, and the factors by which these are larger, left there.
pub(crate) const MASKS: [u32; 3] = [511, 511 << 9, 511 << 18];
pub(crate) const SHIFTED: [f32; 3] = [1.0, 1.0 / 512.0, 1.0 / 262_144.0];

/// Factor of a packed number's mantissas.
#[inline(always)] // for the instructions of its caller
pub(crate) fn scale(bits: u32) -> f32 {
    f32::from_bits(((bits >> 27) + (127 - BIAS - MANTISSA_BITS) as u32) << 23)
}

/// The radiance of a packed number.
pub fn unpacked(bits: u32) -> Vec3 {
    let mantissa = |component: usize| (bits & MASKS[component]) as f32 * SHIFTED[component];
    Vec3::new(mantissa(0), mantissa(1), mantissa(2)) * scale(bits)
}

/// A parallax as it is stored.
pub fn stored(parallax: f32) -> i16 {
    // Casts saturate; values that are not numbers become 0.
    (parallax * (f32::from(i16::MAX) / MAX_PARALLAX)).round() as i16
}

/// The parallax that is stored so.
#[inline(always)] // for the instructions of its caller
pub fn restored(parallax: i16) -> f32 {
    f32::from(parallax) * (MAX_PARALLAX / f32::from(i16::MAX))
}

/// Levels of a view: the first texel of each, from the finest, and its pixels a side.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewLevels {
    /// The first texel of each level and its pixels a side.
    pub levels: Vec<(u32, u32)>,
    /// Texels of all levels.
    pub count: u32,
}

impl ViewLevels {
    /// Levels of views with `side` pixels a side: halves, without the last row and column of odd ones, down to 1.
    pub fn new(side: u32) -> Self {
        let (mut levels, mut count, mut side) = (Vec::new(), 0, side);
        while side > 0 {
            levels.push((count, side));
            count += side * side;
            side /= 2;
        }
        Self { levels, count }
    }

    /// Appends the coarser levels of a view to its finest.
    pub fn append(&self, view: &mut Vec<u32>) {
        let base = view.len() - (self.levels[0].1 * self.levels[0].1) as usize;
        for pair in self.levels.windows(2) {
            let [(fine, wide), (_, side)] = [pair[0], pair[1]];
            for y in 0..side {
                for x in 0..side {
                    let at = |dx: u32, dy: u32| base + (fine + (2 * y + dy) * wide + 2 * x + dx) as usize;
                    let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                    let sum: Vec3 = four.iter().map(|&texel| unpacked(view[texel])).sum();
                    view.push(packed(sum * 0.25));
                }
            }
        }
    }
}
