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
pub const BRIGHTEST: f32 = 64.0;

/// The exponent of eight-bit values, whose steps are small in the dark, where the eye sees them. About that of sRGB.
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
pub fn byte_count(compression: Compression, side: u32) -> Option<usize> {
    variant(compression).map(|variant| variant.blocks_byte_size(padded(side), padded(side)))
}

/// Appends the blocks of a view: `side` pixels a side of packed radiance, row by row. Appends nothing where views are
/// not compressed.
pub fn compress(compression: Compression, side: u32, view: &[u32], bytes: &mut Vec<u8>) {
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
pub fn decompress(compression: Compression, side: u32, blocks: &[u8], texels: &mut Vec<u32>) {
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
    /// The values for BC6H, three for each pixel.
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
pub fn bits8(radiance: Vec3) -> [u8; 4] {
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

/// The radiance that eight bits a channel stand for.
pub fn from_bits8([r, g, b, _]: [u8; 4]) -> Vec3 {
    Vec3::from([r, g, b].map(|bits| RADIANCE[usize::from(bits)]))
}
