//! Textures: linear 16-bit texels with mip levels, glTF samplers, and filtered look-ups.

use crate::framebuffer::linear_from_srgb;
use glam::{Vec2, Vec4};

/// What happens beyond the edges of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The edge texel goes on.
    ClampToEdge,
    /// Every second copy is mirrored.
    MirroredRepeat,
    /// Copies side by side.
    Repeat,
}

/// How texels between mip levels are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipFilter {
    /// The finest level always.
    None,
    /// The nearest level.
    Nearest,
    /// The two nearest levels, blended.
    Linear,
}

/// How a texture is read; the fields are those of glTF's samplers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Beyond the left and right edges.
    pub wrap_u: Wrap,
    /// Beyond the top and bottom edges.
    pub wrap_v: Wrap,
    /// Blend texels where the texture is magnified.
    pub magnify_linear: bool,
    /// Blend texels where it is minified.
    pub minify_linear: bool,
    /// How mip levels are used where it is minified.
    pub mip_filter: MipFilter,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            magnify_linear: true,
            minify_linear: true,
            mip_filter: MipFilter::Linear,
        }
    }
}

/// The change of texture coordinates from a pixel to its right and lower neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UvFootprint {
    /// Change with the pixel's column.
    pub dx: Vec2,
    /// Change with the pixel's row.
    pub dy: Vec2,
}

/// The largest ratio of the footprint's axes that is resolved by several look-ups; beyond it the result is blurred.
const MAX_ANISOTROPY: f32 = 8.0;

#[derive(Clone, Debug, PartialEq)]
struct Level {
    width: u32,
    height: u32,
    /// Linear RGBA, 65535 for 1.
    texels: Vec<[u16; 4]>,
}

/// An image with its mip levels and sampler. Values are linear, alpha is not premultiplied.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The image's name or file, for messages.
    pub name: String,
    sampler: Sampler,
    levels: Vec<Level>,
}

impl Texture {
    /// A texture of 8-bit sRGB colour with linear alpha, rows from the top; all mip levels are made here.
    ///
    /// `rgba` must hold `width * height` texels, both at least 1; missing texels are white.
    pub fn from_srgb8(name: &str, width: u32, height: u32, rgba: &[[u8; 4]], sampler: Sampler) -> Self {
        let decode: Vec<u16> =
            (0..256).map(|value| (linear_from_srgb(value as f32 / 255.0) * 65535.0 + 0.5) as u16).collect();
        let texels = rgba
            .iter()
            .map(|t| [decode[t[0] as usize], decode[t[1] as usize], decode[t[2] as usize], t[3] as u16 * 257])
            .collect();
        Self::from_linear16(name, width, height, texels, sampler)
    }

    /// A texture of linear 16-bit texels, rows from the top; all mip levels are made here.
    pub fn from_linear16(name: &str, width: u32, height: u32, mut texels: Vec<[u16; 4]>, sampler: Sampler) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        texels.resize(width as usize * height as usize, [u16::MAX; 4]);
        let mut levels = vec![Level { width, height, texels }];
        if sampler.mip_filter != MipFilter::None {
            while let Some(next) = levels.last().and_then(Level::halved) {
                levels.push(next);
            }
        }
        Self { name: name.into(), sampler, levels }
    }

    /// Width and height of the finest level, in texels.
    pub fn size(&self) -> (u32, u32) {
        (self.levels[0].width, self.levels[0].height)
    }

    /// The memory that the texels take.
    pub fn byte_count(&self) -> usize {
        self.levels.iter().map(|level| level.texels.len() * 8).sum()
    }

    /// The filtered value at `uv` (0..1 over the image, v down) for a footprint of that size.
    ///
    /// Anisotropic footprints take up to eight trilinear look-ups along their longer axis.
    #[inline(always)]
    pub fn sample(&self, uv: Vec2, footprint: &UvFootprint) -> Vec4 {
        if !uv.is_finite() {
            return Vec4::ONE;
        }
        let base = &self.levels[0];
        let scale = Vec2::new(base.width as f32, base.height as f32);
        let (dx, dy) = (footprint.dx * scale, footprint.dy * scale);
        let (x2, y2) = (dx.length_squared(), dy.length_squared());
        let (major2, minor2, axis) = if x2 >= y2 { (x2, y2, footprint.dx) } else { (y2, x2, footprint.dy) };
        // Not a number, infinite or tiny footprints are magnification.
        if !(major2 > 1.0 && major2.is_finite()) {
            return base.filtered(uv, self.sampler, self.sampler.magnify_linear);
        }
        if self.sampler.mip_filter == MipFilter::None {
            return base.filtered(uv, self.sampler, self.sampler.minify_linear);
        }
        let probes = (major2 / minor2.max(1e-20)).min(MAX_ANISOTROPY * MAX_ANISOTROPY).min(major2).sqrt();
        // Rounded up; at least 1.
        let probes = probes as u32 + u32::from(probes > (probes as u32) as f32);
        let inverse = 1.0 / probes as f32;
        let (index, blend) = self.level(0.5 * log2(major2 * inverse * inverse));
        let fine = &self.levels[index];
        let coarse = &self.levels[index + usize::from(blend > 0.0)];
        let mut sum = Vec4::ZERO;
        for probe in 0..probes {
            let at = uv + axis * ((probe as f32 + 0.5) * inverse - 0.5);
            let value = fine.filtered(at, self.sampler, self.sampler.minify_linear);
            sum += value;
            if blend > 0.0 {
                sum += (coarse.filtered(at, self.sampler, self.sampler.minify_linear) - value) * blend;
            }
        }
        sum * inverse
    }

    /// The mip level to read, and how much of the next one is blended in.
    #[inline]
    fn level(&self, level: f32) -> (usize, f32) {
        let last = self.levels.len() - 1;
        if level <= 0.0 {
            return (0, 0.0);
        }
        match self.sampler.mip_filter {
            MipFilter::Linear if level < last as f32 => (level as usize, level - (level as usize) as f32),
            _ => (((level + 0.5) as usize).min(last), 0.0),
        }
    }
}

/// The binary logarithm of a positive, normal number, to 1e-6. The library's would not be inlined.
#[inline]
fn log2(value: f32) -> f32 {
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

/// Rounds a number of any size towards negative infinity.
#[inline]
fn floor_of_any(value: f32) -> f32 {
    // From 2^23 on all numbers are whole.
    if value.abs() < 8_388_608.0 { floor(value).1 } else { value }
}

/// Rounds towards negative infinity. `value` is within +-2^30; the library's would not be inlined everywhere.
#[inline]
fn floor(value: f32) -> (i32, f32) {
    let truncated = value as i32;
    let floor = truncated - i32::from(truncated as f32 > value);
    (floor, floor as f32)
}

/// The index of a texel beyond the edges. `texel` is within +-2^30 of zero.
#[inline]
fn wrapped(texel: i32, size: i32, wrap: Wrap) -> i32 {
    if (texel as u32) < size as u32 {
        return texel; // the common case costs no division
    }
    match wrap {
        Wrap::ClampToEdge => texel.clamp(0, size - 1),
        Wrap::Repeat => texel.rem_euclid(size),
        Wrap::MirroredRepeat => {
            let t = texel.rem_euclid(2 * size);
            if t < size { t } else { 2 * size - 1 - t }
        }
    }
}

impl Level {
    fn halved(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            let (top, bottom) = span(y, height, self.height);
            for x in 0..width {
                let (left, right) = span(x, width, self.width);
                let (mut sum, mut count) = ([0u64; 4], 0u64);
                for row in top..bottom {
                    for column in left..right {
                        let texel = self.texels[row as usize * self.width as usize + column as usize];
                        for channel in 0..4 {
                            sum[channel] += texel[channel] as u64;
                        }
                        count += 1;
                    }
                }
                texels.push(sum.map(|value| ((value + count / 2) / count) as u16));
            }
        }
        Some(Self { width, height, texels })
    }

    #[inline]
    fn texel(&self, x: i32, y: i32) -> Vec4 {
        let t = self.texels[y as usize * self.width as usize + x as usize];
        Vec4::new(t[0] as f32, t[1] as f32, t[2] as f32, t[3] as f32)
    }

    /// The texels of a row at two columns.
    #[inline(always)]
    fn pair(&self, x0: i32, x1: i32, y: i32) -> [f32; 8] {
        let row = y as usize * self.width as usize;
        if x1 == x0 + 1 {
            // Neighbours in memory are read at once.
            let first = row + x0 as usize;
            if let Some(pair) = self.texels[first..first + 2].as_flattened().first_chunk::<8>() {
                return pair.map(|value| value as f32);
            }
        }
        let (a, b) = (self.texels[row + x0 as usize], self.texels[row + x1 as usize]);
        std::array::from_fn(|i| if i < 4 { a[i] } else { b[i - 4] } as f32)
    }

    #[inline(always)]
    fn filtered(&self, uv: Vec2, sampler: Sampler, linear: bool) -> Vec4 {
        const SCALE: f32 = 1.0 / 65535.0;
        const LIMIT: f32 = (1 << 30) as f32;
        let (width, height) = (self.width as i32, self.height as i32);
        // Whole repeats are taken off before the scaling, so that far coordinates keep their fraction.
        let reduced = |t: f32, wrap| match wrap {
            Wrap::ClampToEdge => t.clamp(-1.0, 2.0),
            Wrap::Repeat if !(0.0..1.0).contains(&t) => t - floor_of_any(t),
            Wrap::MirroredRepeat if !(0.0..1.0).contains(&t) => t - 2.0 * floor_of_any(t * 0.5),
            _ => t,
        };
        let x = (reduced(uv.x, sampler.wrap_u) * width as f32).clamp(-LIMIT, LIMIT);
        let y = (reduced(uv.y, sampler.wrap_v) * height as f32).clamp(-LIMIT, LIMIT);
        if !linear {
            let column = wrapped(floor(x).0, width, sampler.wrap_u);
            let row = wrapped(floor(y).0, height, sampler.wrap_v);
            return self.texel(column, row) * SCALE;
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let ((left, left_x), (top, top_y)) = (floor(x), floor(y));
        let (fx, fy) = (x - left_x, y - top_y);
        let (x0, x1) = (wrapped(left, width, sampler.wrap_u), wrapped(left + 1, width, sampler.wrap_u));
        let (y0, y1) = (wrapped(top, height, sampler.wrap_v), wrapped(top + 1, height, sampler.wrap_v));
        let (upper, lower) = (self.pair(x0, x1, y0), self.pair(x0, x1, y1));
        let (scaled, other) = (fy * SCALE, (1.0 - fy) * SCALE);
        let both: [f32; 8] = std::array::from_fn(|i| upper[i] * other + lower[i] * scaled);
        let half = |first: usize| Vec4::new(both[first], both[first + 1], both[first + 2], both[first + 3]);
        half(0) * (1.0 - fx) + half(4) * fx
    }
}

/// The texels of a level of `from` texels that texel `index` of the next level (`to` texels) averages.
fn span(index: u32, to: u32, from: u32) -> (u32, u32) {
    let begin = (index as u64 * from as u64 / to as u64) as u32;
    let end = ((index as u64 + 1) * from as u64).div_ceil(to as u64) as u32;
    (begin, end.min(from).max(begin + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker(sampler: Sampler) -> Texture {
        let texels: Vec<[u8; 4]> =
            (0..64).map(|i| if (i % 8 + i / 8) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }).collect();
        Texture::from_srgb8("checker", 8, 8, &texels, sampler)
    }

    #[test]
    fn nearest_and_wraps() {
        let nearest = Sampler { magnify_linear: false, ..Sampler::default() };
        let still = UvFootprint::default();
        let texture = checker(nearest);
        assert_eq!(texture.sample(Vec2::new(0.05, 0.05), &still).x, 1.0);
        assert_eq!(texture.sample(Vec2::new(0.15, 0.05), &still).x, 0.0);
        assert_eq!(texture.sample(Vec2::new(-0.05, 0.05), &still).x, 0.0); // repeat: the eighth texel
        let mirrored = checker(Sampler { wrap_u: Wrap::MirroredRepeat, ..nearest });
        assert_eq!(mirrored.sample(Vec2::new(-0.05, 0.05), &still).x, 1.0);
        let clamped = checker(Sampler { wrap_u: Wrap::ClampToEdge, ..nearest });
        assert_eq!(clamped.sample(Vec2::new(7.3, 0.05), &still).x, 0.0);
        assert!(clamped.sample(Vec2::new(f32::NAN, f32::INFINITY), &still).is_finite());
    }

    #[test]
    fn minification_averages() {
        let texture = checker(Sampler::default());
        let wide = UvFootprint { dx: Vec2::new(1.0, 0.0), dy: Vec2::new(0.0, 1.0) };
        let value = texture.sample(Vec2::new(0.3, 0.7), &wide);
        assert!((value.x - 0.5).abs() < 1e-3, "{value}");
    }

    #[test]
    fn anisotropic_footprints_blur_along_their_axis_only() {
        // Columns of alternating pairs: blurring down the columns must not blur across them.
        let texels: Vec<[u8; 4]> =
            (0..64 * 64).map(|i| if (i % 64) / 8 % 2 == 0 { [255; 4] } else { [0; 4] }).collect();
        let texture = Texture::from_srgb8("columns", 64, 64, &texels, Sampler::default());
        let tall = UvFootprint { dx: Vec2::new(1.0 / 64.0, 0.0), dy: Vec2::new(0.0, 8.0 / 64.0) };
        assert!(texture.sample(Vec2::new(4.0 / 64.0, 0.5), &tall).x > 0.99);
        assert!(texture.sample(Vec2::new(12.0 / 64.0, 0.5), &tall).x < 0.01);
    }
}
