//! The positions of look-ups.

use crate::math::lanes::Lanes;

/// The positions of look-ups: texture coordinates and their change a pixel, along u and v each.
#[derive(Clone, Debug)]
pub struct TextureLookUps<const N: usize> {
    /// The texture coordinates.
    pub uv: [Lanes<N>; 2],
    /// Change with the pixel's column.
    pub dx: [Lanes<N>; 2],
    /// Change with the pixel's row.
    pub dy: [Lanes<N>; 2],
    /// The number of samples of the pixel that a look-up stands for; 0 as 1.
    pub samples: [u32; N],
}

impl<const N: usize> TextureLookUps<N> {
    pub(in super::super) const ZERO: Self =
        Self { uv: [Lanes::ZERO; 2], dx: [Lanes::ZERO; 2], dy: [Lanes::ZERO; 2], samples: [1; N] };
}
