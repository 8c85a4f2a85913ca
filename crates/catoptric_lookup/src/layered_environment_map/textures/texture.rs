//! Textures of layers as they are kept: half floats, as in bakes. These take half the memory, and arrive sooner where
//! the cache does not have them.

use crate::layered_environment_map::texels::{TexelLayout, TexelTaps};
use block_compression::half::f16;
use glam::Vec4;

/// Radiance times opacity, and opacity.
#[derive(Clone, Debug)]
pub struct LayerTexture {
    /// The layout of its texels.
    pub layout: TexelLayout,
    /// The texels of all levels, the finest first.
    pub texels: Vec<LayerTexel>,
}

impl LayerTexture {
    /// A texture from values in the layout's order.
    pub fn new(layout: TexelLayout, values: &[Vec4]) -> Self {
        Self { layout, texels: values.iter().map(|value| LayerTexel::new(*value)).collect() }
    }
}

/// Bytes of a texel.
pub(crate) const TEXEL_BYTES: usize = size_of::<LayerTexel>();

/// Four half floats, by their bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerTexel([u16; 4]);

/// The factor by which the bits of a half float are too small when they are moved to the place that a float has for its
/// own: exponents begin at -15, and not at -127.
const SCALE: f32 = f32::from_bits((127 + 112) << 23);

impl LayerTexel {
    /// The nearest half floats; values that are too large become the largest, and those that are not numbers 0.
    pub fn new(value: Vec4) -> Self {
        let held = |value: f32| if value.is_nan() { 0.0 } else { value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32()) };
        let half = |value: f32| f16::from_f32(held(value)).to_bits();
        Self(value.to_array().map(half))
    }

    /// The texel from the bytes of [`Self::to_bytes`].
    pub fn of_bytes(bytes: [u8; TEXEL_BYTES]) -> Self {
        let (halves, _) = bytes.as_chunks::<2>();
        let mut texel = Self([0; 4]);
        texel.0.iter_mut().zip(halves).for_each(|(half, bytes)| *half = u16::from_le_bytes(*bytes));
        texel
    }

    /// The lowest byte of each half float first.
    pub fn to_bytes(self) -> [u8; TEXEL_BYTES] {
        let mut bytes = [0; TEXEL_BYTES];
        let (halves, _) = bytes.as_chunks_mut::<2>();
        halves.iter_mut().zip(self.0).for_each(|(bytes, half)| *bytes = half.to_le_bytes());
        bytes
    }

    /// The bits of the four half floats.
    pub(crate) fn halves(self) -> [u16; 4] {
        self.0
    }

    /// The numbers.
    pub fn value(self) -> Vec4 {
        self.scaled() * SCALE
    }

    /// The numbers over [`SCALE`]; infinities, which bakes of any bytes may have, become large ones.
    #[inline(always)] // for the instructions of its caller
    fn scaled(self) -> Vec4 {
        let mut value = [0.0; 4];
        for (value, half) in value.iter_mut().zip(self.0) {
            let half = u32::from(half);
            *value = f32::from_bits((half & 0x8000) << 16 | (half & 0x7FFF) << 13);
        }
        Vec4::from_array(value)
    }
}

impl TexelTaps {
    /// The sum of texels by their weights.
    #[inline(always)] // for the instructions of its caller
    pub fn sum(&self, texels: &[LayerTexel]) -> Vec4 {
        let mut sum = Vec4::ZERO;
        for tap in 0..4 {
            sum += texels[self.texels[tap] as usize].scaled() * (self.weights[tap] * SCALE);
        }
        sum
    }
}
