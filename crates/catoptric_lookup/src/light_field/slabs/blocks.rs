//! Views in blocks of 4 x 4 pixels, as GPUs read them.

use super::texels::{packed, unpacked};
use crate::light_field::settings::Compression;
use block_compression::decode::{decode_block_bc1, decode_block_bc6h, decode_block_bc7};
use block_compression::encode::{compress_rgba8, compress_rgba16};
use block_compression::half::f16;
use block_compression::{BC6HSettings, BC7Settings, CompressionVariant};
use catoptric_core::math::portable::PortableMath;
use glam::Vec3;
use std::sync::LazyLock;

/// The radiance that eight bits a component reach. Chosen, not measured.
const BRIGHTEST: f32 = 64.0;

/// How steeply eight bits rise in the dark, where the eye sees small steps. About that of sRGB.
const GAMMA: f32 = 2.2;

/// The kind of blocks; returns `None` if views are not compressed.
fn variant(compression: Compression) -> Option<CompressionVariant> {
    match compression {
        Compression::None => None,
        Compression::Bc1 => Some(CompressionVariant::BC1),
        Compression::Bc6h => Some(CompressionVariant::BC6H(BC6HSettings::fast())),
        Compression::Bc7 => Some(CompressionVariant::BC7(BC7Settings::opaque_very_fast())),
    }
}

/// Whole blocks.
pub(crate) fn padded(side: u32) -> u32 {
    side.next_multiple_of(4)
}

/// Bytes of a view of `side` pixels a side; returns `None` if views are not compressed.
pub(crate) fn byte_count(compression: Compression, side: u32) -> Option<usize> {
    variant(compression).map(|variant| variant.blocks_byte_size(padded(side), padded(side)))
}

/// Appends the blocks of a view: `side` pixels a side of packed radiance, row by row. Appends nothing where views are
/// not compressed.
pub(crate) fn compress(compression: Compression, side: u32, view: &[u32], bytes: &mut Vec<u8>) {
    let Some(variant) = variant(compression) else { return };
    let (wide, last) = (padded(side), side - 1);
    // Blocks that reach over the view repeat its last pixels.
    let places = (0..wide * wide).map(|pixel| (pixel % wide).min(last) + (pixel / wide).min(last) * side);
    let radiance = places.map(|place| unpacked(view[place as usize]));
    let start = bytes.len();
    bytes.resize(start + variant.blocks_byte_size(wide, wide), 0);
    let blocks = &mut bytes[start..];
    if compression == Compression::Bc6h {
        let half = |radiance: Vec3| radiance.extend(1.0).to_array().map(f16::from_f32);
        let pixels: Vec<f16> = radiance.flat_map(half).collect();
        compress_rgba16(variant, &pixels, blocks, wide, wide, 4 * wide);
    } else {
        let pixels: Vec<u8> = radiance.flat_map(bits8).collect();
        compress_rgba8(variant, &pixels, blocks, wide, wide, 4 * wide);
    }
}

/// Appends the packed radiance of a view's blocks, of which there must be as many as [`byte_count`] says. Appends
/// nothing where views are not compressed.
pub(crate) fn decompress(compression: Compression, side: u32, blocks: &[u8], texels: &mut Vec<u32>) {
    let Some(bytes) = byte_count(compression, 4) else { return };
    let (first, across) = (texels.len(), padded(side) as usize / 4);
    let side = side as usize;
    texels.resize(first + side * side, 0);
    let view = &mut texels[first..];
    let mut pixels = BlockPixels::default();
    for (number, block) in blocks.chunks_exact(bytes).enumerate() {
        pixels.decode(compression, block);
        let (left, top) = (number % across * 4, number / across * 4);
        for y in top..(top + 4).min(side) {
            let (from, count) = (4 * (y - top), (side - left).min(4));
            let row = &mut view[y * side + left..][..count];
            let radiance = (from..).map(|pixel| pixels.radiance(compression, pixel));
            row.iter_mut().zip(radiance).for_each(|(texel, radiance)| *texel = packed(radiance));
        }
    }
}

/// A block's pixels, row by row.
pub(crate) struct BlockPixels {
    /// Four bytes each.
    bits: [u8; 64],
    /// Of BC6H, three each.
    halves: [f16; 48],
}

impl Default for BlockPixels {
    fn default() -> Self {
        Self { bits: [0; 64], halves: [f16::ZERO; 48] }
    }
}

impl BlockPixels {
    /// Reads a block, which has the bytes of one.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn decode(&mut self, compression: Compression, block: &[u8]) {
        match compression {
            Compression::None => {}
            Compression::Bc1 => decode_block_bc1(block, &mut self.bits, 16),
            Compression::Bc7 => decode_block_bc7(block, &mut self.bits, 16),
            Compression::Bc6h => decode_block_bc6h(block, &mut self.halves, 12, false),
        }
    }

    /// The radiance of one of its 16 pixels.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn radiance(&self, compression: Compression, pixel: usize) -> Vec3 {
        match compression {
            Compression::None => Vec3::ZERO,
            Compression::Bc6h => Vec3::from([0, 1, 2].map(|k| self.halves[3 * pixel + k].to_f32())),
            Compression::Bc1 | Compression::Bc7 => from_bits8([0, 1, 2, 3].map(|k| self.bits[4 * pixel + k])),
        }
    }
}

/// Radiance from 0 to [`BRIGHTEST`] in eight bits a component: compressed as x / (1 + x) (Reinhard, Stark, Shirley,
/// Ferwerda 2002, equation 3), then by a gamma. Steps are 2 to 3 % from 0.1 to 2, and 35 % at the bright end.
fn bits8(radiance: Vec3) -> [u8; 4] {
    let [r, g, b] = radiance.to_array().map(|x| {
        let share = x * (1.0 + 1.0 / BRIGHTEST) / (1.0 + x);
        // Casts saturate.
        (255.0 * share.power(1.0 / GAMMA)).round() as u8
    });
    [r, g, b, 255]
}

/// The radiance of all eight bits: powers are slow, and pixels many.
static RADIANCE: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|bits| {
        let share = (bits as f32 / 255.0).power(GAMMA);
        share / (1.0 + 1.0 / BRIGHTEST - share)
    })
});

fn from_bits8([r, g, b, _]: [u8; 4]) -> Vec3 {
    Vec3::from([r, g, b].map(|bits| RADIANCE[usize::from(bits)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_core::math::random::Stream;

    const ALL: [Compression; 3] = [Compression::Bc1, Compression::Bc6h, Compression::Bc7];

    fn restored(compression: Compression, side: u32, view: &[Vec3]) -> Vec<Vec3> {
        let view: Vec<u32> = view.iter().copied().map(packed).collect();
        let (mut bytes, mut texels) = (Vec::new(), Vec::new());
        compress(compression, side, &view, &mut bytes);
        assert_eq!(Some(bytes.len()), byte_count(compression, side));
        decompress(compression, side, &bytes, &mut texels);
        texels.into_iter().map(unpacked).collect()
    }

    #[test]
    fn eight_bits_hold_radiance_to_their_steps() {
        for step in 0..=400 {
            let x = 0.01 * 10.0_f32.powf(step as f32 / 100.0);
            let found = from_bits8(bits8(Vec3::splat(x))).x;
            if x > 0.1 && x < 2.0 {
                assert!((found / x - 1.0).abs() < 0.016, "{x} became {found}");
            }
            if x >= BRIGHTEST {
                assert!((found / BRIGHTEST - 1.0).abs() < 1e-4, "{x} became {found}");
            }
        }
        assert_eq!(from_bits8(bits8(Vec3::ZERO)), Vec3::ZERO);
    }

    /// How far two radiances are apart, in steps of eight bits.
    fn steps(a: Vec3, b: Vec3) -> i32 {
        let [a, b] = [a, b].map(|radiance| bits8(radiance).map(i32::from));
        (0..3).map(|k| (a[k] - b[k]).abs()).max().unwrap()
    }

    /// Half a step of five bits, of seven, and about one of eight that half floats of ten take.
    const ALLOWED: [(Compression, i32); 3] = [(Compression::Bc1, 5), (Compression::Bc6h, 1), (Compression::Bc7, 2)];

    #[test]
    fn views_of_one_colour_keep_it() {
        for (compression, allowed) in ALLOWED {
            for side in [1, 4, 5, 16] {
                for radiance in [Vec3::ZERO, Vec3::new(0.3, 0.7, 0.5), Vec3::new(1.4, 0.2, 0.9)] {
                    let view = vec![radiance; (side * side) as usize];
                    for found in restored(compression, side, &view) {
                        let off = steps(found, radiance);
                        assert!(off <= allowed, "{compression:?}: {radiance} became {found}, {off} steps off");
                    }
                }
            }
        }
    }

    /// What lies in a block lies between two colours: a ramp is kept, and every pixel stays at its place.
    #[test]
    fn ramps_stay_where_they_are() {
        const SIDE: u32 = 13;
        let ramp = |pixel: u32| {
            let (x, y) = ((pixel % SIDE) as f32 / SIDE as f32, (pixel / SIDE) as f32 / SIDE as f32);
            Vec3::new(1.0, 0.8, 0.5) * (0.2 + 0.5 * x + 0.2 * y)
        };
        let view: Vec<Vec3> = (0..SIDE * SIDE).map(ramp).collect();
        // One pixel aside is 9 steps aside at the dark end, a row 4.
        for (compression, allowed) in ALLOWED {
            let found = restored(compression, SIDE, &view);
            assert_eq!(found.len(), view.len());
            let off: Vec<i32> = found.iter().zip(&view).map(|(found, wanted)| steps(*found, *wanted)).collect();
            let mean = off.iter().sum::<i32>() as f32 / off.len() as f32;
            assert!(mean < 0.5 * allowed as f32 + 0.5, "{compression:?}: {mean}");
            assert!(off.iter().all(|off| *off <= 2 * allowed), "{compression:?}: {off:?}");
        }
    }

    /// Blocks are what they are said to be: another decoder sees the same in them.
    #[test]
    fn other_decoders_read_the_blocks() {
        let mut random = Stream::new(8);
        let view: Vec<u32> = (0..64).map(|_| packed(Vec3::from([0; 3].map(|_| 2.0 * random.next_unit())))).collect();
        for compression in ALL {
            let (mut bytes, mut texels) = (Vec::new(), Vec::new());
            compress(compression, 8, &view, &mut bytes);
            decompress(compression, 8, &bytes, &mut texels);
            for (number, block) in bytes.chunks(bytes.len() / 4).enumerate() {
                let (mut bits, mut floats) = ([0; 64], [0.0; 48]);
                match compression {
                    Compression::Bc1 => bcdec_rs::bc1(block, &mut bits, 16),
                    Compression::Bc7 => bcdec_rs::bc7(block, &mut bits, 16),
                    _ => bcdec_rs::bc6h_float(block, &mut floats, 12, false),
                }
                for pixel in 0..16 {
                    let expected = match compression {
                        Compression::Bc6h => Vec3::from_slice(&floats[3 * pixel..]),
                        _ => from_bits8([bits[4 * pixel], bits[4 * pixel + 1], bits[4 * pixel + 2], 255]),
                    };
                    let (x, y) = (number % 2 * 4 + pixel % 4, number / 2 * 4 + pixel / 4);
                    assert_eq!(texels[y * 8 + x], packed(expected), "{compression:?}, block {number}, pixel {pixel}");
                }
            }
        }
    }

    /// Half floats keep what eight bits do not reach.
    #[test]
    fn half_floats_keep_bright_lights() {
        for found in restored(Compression::Bc6h, 4, &[Vec3::new(3000.0, 2500.0, 1000.0); 16]) {
            assert!((found / Vec3::new(3000.0, 2500.0, 1000.0) - 1.0).abs().max_element() < 0.02, "{found}");
        }
    }

    /// Files are checked by their sums, but whoever writes one may write any blocks.
    #[test]
    fn any_blocks_are_radiance() {
        let mut random = Stream::new(7);
        for compression in ALL {
            let count = byte_count(compression, 32).unwrap();
            for _ in 0..50 {
                let bytes: Vec<u8> = (0..count).map(|_| (random.next_unit() * 256.0) as u8).collect();
                let mut texels = Vec::new();
                decompress(compression, 32, &bytes, &mut texels);
                assert_eq!(texels.len(), 32 * 32);
                assert!(texels.into_iter().all(|texel| unpacked(texel).is_finite()));
            }
        }
    }
}
