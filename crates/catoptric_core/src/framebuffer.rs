//! Pictures: linear radiance in floating point, and their conversion to sRGB.

/// A picture of linear RGBA radiance, rows from the top, pixels from the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Framebuffer {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels: linear red, green, blue (unbounded, never negative), and coverage (0 to 1).
    pub pixels: Vec<[f32; 4]>,
}

impl Framebuffer {
    /// A black, fully covered picture.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0, 0.0, 0.0, 1.0]; width as usize * height as usize] }
    }

    /// The pixel in column `x` of row `y`.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// The picture as 8-bit sRGB, three bytes a pixel; values are clamped, no tone curve.
    pub fn to_srgb8(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|p| [p[0], p[1], p[2]].map(|c| (srgb_from_linear(c) * 255.0 + 0.5) as u8)).collect()
    }
}

/// The sRGB transfer function (IEC 61966-2-1); the argument is clamped to 0..1, NaN gives 0.
#[inline]
pub fn srgb_from_linear(linear: f32) -> f32 {
    let c = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_from_linear`] on 0..1.
#[inline]
pub fn linear_from_srgb(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trip() {
        for step in 0..=255u32 {
            let value = step as f32 / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(value)) - value).abs() < 1e-5, "{value}");
        }
        assert_eq!(srgb_from_linear(f32::NAN), 0.0);
        assert_eq!(srgb_from_linear(7.0), srgb_from_linear(1.0));
    }
}
