//! Pictures: linear radiance in floating point, and their conversion to sRGB.

use crate::math::portable::PortableMath;
use crate::parallel;
use glam::Vec3;
use std::sync::LazyLock;

/// A picture of linear RGBA radiance, rows from the top, pixels from the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Framebuffer {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels: linear red, green, blue (unbounded, never negative), and coverage (0 to 1).
    pub pixels: Vec<[f32; 4]>,
    /// The samples of pixels at edges, as far as they are known.
    pub edges: EdgeSamples,
}

/// Samples of those pixels whose samples differ, each pixel once: a screen limits each of them before they are
/// averaged, as it shows no more than white. So edges before bright grounds stay smooth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeSamples {
    /// Index of each pixel in the picture.
    pixels: Vec<u32>,
    /// All samples of the first pixel, then those of the next; linear.
    samples: Vec<Vec3>,
}

impl EdgeSamples {
    /// Samples that differ by less than this share of the brightest are none of an edge.
    const LEAST_DIFFERENCE: f32 = 0.125;

    /// Adds the samples of a pixel, as many as those of all others, if they differ.
    pub fn add(&mut self, pixel: u32, samples: &[Vec3]) {
        let (least, most) = samples
            .iter()
            .fold((Vec3::MAX, Vec3::ZERO), |(least, most), sample| (least.min(*sample), most.max(*sample)));
        if (most - least).cmpgt(most * Self::LEAST_DIFFERENCE).any() {
            self.pixels.push(pixel);
            self.samples.extend_from_slice(samples);
        }
    }

    /// Adds the pixels of a part of the picture, of which none is here.
    pub fn append(&mut self, mut other: Self) {
        self.pixels.append(&mut other.pixels);
        self.samples.append(&mut other.samples);
    }

    /// The pixels, by their index in the picture, and their samples.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[Vec3])> {
        let count = self.samples.len().checked_div(self.pixels.len()).unwrap_or(0).max(1);
        self.pixels.iter().copied().zip(self.samples.chunks_exact(count))
    }
}

impl Framebuffer {
    /// A black, fully covered picture.
    pub fn new(width: u32, height: u32) -> Self {
        Self::of_pixels(width, height, vec![[0.0, 0.0, 0.0, 1.0]; width as usize * height as usize])
    }

    /// A picture of so many pixels, nothing of whose samples is known.
    pub fn of_pixels(width: u32, height: u32, pixels: Vec<[f32; 4]>) -> Self {
        Self { width, height, pixels, edges: EdgeSamples::default() }
    }

    /// The pixel in column `x` of row `y`.
    #[inline]
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// The picture as 8-bit sRGB, three bytes a pixel; values are clamped, no tone curve.
    pub fn to_srgb8(&self) -> Vec<u8> {
        self.encoded(|[r, g, b, _], code| [code.of(r), code.of(g), code.of(b)])
    }

    /// The same with a fourth byte, which is 255: what windows and textures take.
    pub fn to_srgba8(&self) -> Vec<u8> {
        self.encoded(|[r, g, b, _], code| [code.of(r), code.of(g), code.of(b), 255])
    }

    fn encoded<const N: usize>(&self, encode: impl Fn([f32; 4], &Srgb8) -> [u8; N] + Sync + Send) -> Vec<u8> {
        let mut bytes = vec![0; self.pixels.len() * N];
        let code = &*SRGB8;
        parallel::for_each_chunk_mut(&mut bytes, CHUNK * N, |chunk, bytes| {
            for (pixel, bytes) in self.pixels[chunk * CHUNK..].iter().zip(bytes.chunks_exact_mut(N)) {
                bytes.copy_from_slice(&encode(*pixel, code));
            }
        });
        bytes
    }
}

/// Pixels that a thread encodes at once. A size for threads; chosen, not measured.
const CHUNK: usize = 4096;

/// 8-bit sRGB by tables, to the bit as [`srgb_from_linear`] rounds it.
struct Srgb8 {
    /// For the upper half of a value's bits the code of the least value that has them.
    codes: Vec<u8>,
    /// For each code but the first the least value that has it.
    least: [f32; 255],
}

static SRGB8: LazyLock<Srgb8> = LazyLock::new(Srgb8::new);

impl Srgb8 {
    fn new() -> Self {
        let code = |bits: u32| (srgb_from_linear(f32::from_bits(bits)) * 255.0 + 0.5) as u8;
        let one = 1f32.to_bits();
        let least = std::array::from_fn(|index| {
            // Bits of positive numbers rise with them, and so do codes.
            let (mut below, mut above) = (0, one);
            while above - below > 1 {
                let middle = below + (above - below) / 2;
                if usize::from(code(middle)) > index { above = middle } else { below = middle }
            }
            f32::from_bits(above)
        });
        Self { codes: (0..=one >> 16).map(|upper| code(upper << 16)).collect(), least }
    }

    /// The code of a linear value; NaN gives 0.
    #[inline]
    fn of(&self, linear: f32) -> u8 {
        let value = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
        let mut code = usize::from(self.codes[(value.to_bits() >> 16) as usize]);
        while code < self.least.len() && value >= self.least[code] {
            code += 1;
        }
        code as u8
    }
}

/// The sRGB transfer function (IEC 61966-2-1); the argument is clamped to 0..1, NaN gives 0.
#[inline]
pub fn srgb_from_linear(linear: f32) -> f32 {
    let c = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.power(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_from_linear`] on 0..1.
#[inline]
pub fn linear_from_srgb(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).power(2.4) }
}
