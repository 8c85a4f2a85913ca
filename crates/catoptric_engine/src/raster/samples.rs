//! The positions of a pixel's coverage samples.

use crate::error::RenderError;
use catoptric_core::math::lanes::LANES;
use catoptric_core::scene::SAMPLE_PATTERNS;
use glam::Vec2;

const fn positions<const N: usize>(pattern: usize) -> [Vec2; N] {
    let mut result = [Vec2::ZERO; N];
    let mut index = 0;
    while index < N {
        let [x, y] = SAMPLE_PATTERNS[pattern][index];
        result[index] = Vec2::new(x as f32 / 16.0, y as f32 / 16.0);
        index += 1;
    }
    result
}

/// The numbers of samples a pixel that the rasteriser can take.
pub const SAMPLE_COUNTS: [u32; 5] = [1, 2, 4, 8, 16];

static POSITIONS_1: [Vec2; 1] = positions(0);
static POSITIONS_2: [Vec2; 2] = positions(1);
static POSITIONS_4: [Vec2; 4] = positions(2);
static POSITIONS_8: [Vec2; 8] = positions(3);
static POSITIONS_16: [Vec2; 16] = positions(4);

/// The offsets of a pixel's samples from its top left corner, in pixels: the standard patterns of Direct3D and Vulkan.
///
/// # Errors
/// [`RenderError::Samples`] when `samples` is none of [`SAMPLE_COUNTS`].
pub fn sample_positions(samples: u32) -> Result<&'static [Vec2], RenderError> {
    match samples {
        1 => Ok(&POSITIONS_1),
        2 => Ok(&POSITIONS_2),
        4 => Ok(&POSITIONS_4),
        8 => Ok(&POSITIONS_8),
        16 => Ok(&POSITIONS_16),
        _ => Err(RenderError::Samples { samples }),
    }
}

/// The division of the samples of a row of pixels into groups of [`LANES`]: several pixels, one pixel or half a pixel.
///
/// The samples of a pixel follow each other, those of the next pixel come after them.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Samples a pixel.
    pub samples: usize,
    /// The binary logarithm of the samples a pixel.
    pub(super) samples_log2: u32,
    /// Different patterns of offsets: 2 where a group is half a pixel, else 1.
    pub halves: usize,
    /// Offsets of a group's samples from the corner of its first pixel, in sixteenths of a pixel.
    pub x: [[i32; LANES]; 2],
    /// The same along y.
    pub y: [[i32; LANES]; 2],
    /// The sample positions within a pixel.
    pub positions: &'static [Vec2],
    /// The samples in each quarter of a pixel, as bits.
    pub(super) quarters: [u32; 4],
    /// Smallest and largest offset of a sample in its pixel, in sixteenths of a pixel.
    pub(super) extent_x: [i32; 2],
    /// The same along y.
    pub(super) extent_y: [i32; 2],
}

impl Pattern {
    /// The pattern of a number of samples a pixel.
    pub fn new(samples: u32) -> Result<Self, RenderError> {
        let positions = sample_positions(samples)?;
        let pattern = SAMPLE_PATTERNS[samples.trailing_zeros() as usize];
        let count = pattern.len();
        let offset = |half: usize, lane: usize, axis: usize| {
            let index = half * LANES + lane;
            let pixel = if axis == 0 { index / count } else { 0 };
            // The second half stands for another group of the same pixel only when there are 16 samples.
            let pixel = if count > LANES { 0 } else { pixel % (LANES / count) };
            pixel as i32 * 16 + pattern[index % count][axis] as i32
        };
        let table = |axis| std::array::from_fn(|half| std::array::from_fn(|lane| offset(half, lane, axis)));
        let extent = |axis: usize| {
            let values = || pattern.iter().map(|offset| offset[axis] as i32);
            [values().min().unwrap_or(0), values().max().unwrap_or(15)]
        };
        let mut quarters = [0; 4];
        for (index, position) in positions.iter().enumerate() {
            quarters[usize::from(position.x >= 0.5) + 2 * usize::from(position.y >= 0.5)] |= 1 << index;
        }
        Ok(Self {
            samples: count,
            samples_log2: samples.trailing_zeros(),
            halves: count.div_ceil(LANES),
            x: table(0),
            y: table(1),
            positions,
            quarters,
            extent_x: extent(0),
            extent_y: extent(1),
        })
    }
}
