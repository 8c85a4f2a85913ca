//! The form in which rows of views are kept: as numbers, or in blocks.

use super::blocks::{BlockPixels, byte_count, decompress, padded};
use super::depth_blocks;
use super::texels::{ViewLevels, packed};
use crate::light_field::settings::Compression;
use std::borrow::Cow;

/// Sizes of views and of their stored data.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewForm {
    pub(crate) compression: Compression,
    /// The levels of a view.
    pub levels: ViewLevels,
    /// The first byte of each level's blocks in those of a view.
    first_bytes: Vec<usize>,
    block_bytes: usize,
    /// The bytes of a view.
    light_bytes: usize,
    depth_bytes: usize,
}

/// A row of views, wherever and in whichever form it is kept.
#[derive(Clone, Copy, Debug, Default)]
pub struct RowView<'a> {
    /// Empty where views are compressed.
    pub texels: &'a [u32],
    /// The parallax of every ray; empty where views are compressed.
    pub parallax: &'a [i16],
    /// Blocks of all levels of a view, view after view; empty where views are not compressed.
    pub blocks: &'a [u8],
    /// Blocks of depths, view after view; empty where views are not compressed.
    pub depths: &'a [u8],
}

impl ViewForm {
    /// The form of views of `side` pixels a side.
    pub fn new(side: u32, compression: Compression) -> Self {
        let levels = ViewLevels::new(side);
        let (mut first_bytes, mut sum) = (Vec::new(), 0);
        for &(_, side) in &levels.levels {
            first_bytes.push(sum);
            sum += byte_count(compression, side).unwrap_or_default();
        }
        let block_bytes = byte_count(compression, 1).unwrap_or_default();
        let (light_bytes, depth_bytes) = match compression {
            Compression::None => (4 * levels.count as usize, 2 * (side * side) as usize),
            _ => (sum, depth_blocks::byte_count(side)),
        };
        Self { compression, levels, first_bytes, block_bytes, light_bytes, depth_bytes }
    }

    /// Pixels a side of a view.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn side(&self) -> u32 {
        self.levels.levels.first().map_or(0, |level| level.1)
    }

    /// Pixels of a view.
    pub fn rays_a_view(&self) -> u64 {
        u64::from(self.side()) * u64::from(self.side())
    }

    /// Bytes of a view, in memory and baked.
    pub fn bytes_a_view(&self) -> usize {
        self.light_bytes + self.depth_bytes
    }

    /// The bytes of a view's light.
    pub fn light_bytes(&self) -> usize {
        self.light_bytes
    }

    /// The parallax of a pixel, as it is stored; 0 where there is none.
    #[inline(always)] // for the instructions of its caller
    pub fn parallax(&self, row: &RowView<'_>, view: u32, x: u32, y: u32) -> i16 {
        let side = self.side();
        if self.compression == Compression::None {
            let index = ((view * side + y) * side + x) as usize;
            return row.parallax.get(index).copied().unwrap_or_default();
        }
        depth_blocks::at(side, row.depths.get(view as usize * self.depth_bytes..).unwrap_or_default(), x, y)
    }

    /// The packed radiance of a texel of a view's level and of those beside, below, and beside that one, which the
    /// level must have; where it has one texel a side, of that one four times.
    #[inline(always)] // for the instructions of its caller
    pub fn four(&self, row: &RowView<'_>, view: u32, level: usize, low: [u32; 2]) -> [u32; 4] {
        if self.compression == Compression::None {
            self.four_numbers(row, view, level, low)
        } else {
            self.four_of_blocks(row, view, level, low)
        }
    }

    #[inline(always)] // for the instructions of its caller
    fn four_numbers(&self, row: &RowView<'_>, view: u32, level: usize, [x, y]: [u32; 2]) -> [u32; 4] {
        let Some(&(first, side)) = self.levels.levels.get(level) else { return [0; 4] };
        let (right, down) = if side > 1 { (1, side as usize) } else { (0, 0) };
        let low = (view * self.levels.count + first + y * side + x) as usize;
        let window = row.texels.get(low..low + down + right + 1);
        window.map_or([0; 4], |window| [window[0], window[right], window[down], window[down + right]])
    }

    #[inline(never)] // so that the rest stays in the cache of those that need it not
    pub(crate) fn four_of_blocks(&self, row: &RowView<'_>, view: u32, level: usize, [x, y]: [u32; 2]) -> [u32; 4] {
        let Some((&(_, side), first)) = self.levels.levels.get(level).zip(self.first_bytes.get(level)) else {
            return [0; 4];
        };
        let (across, next) = ((padded(side) / 4) as usize, u32::from(side > 1));
        let first = view as usize * self.light_bytes + first;
        let (mut last, mut pixels) = (usize::MAX, BlockPixels::default());
        [0, 1, 2, 3].map(|corner| {
            let (x, y) = ((x + (corner & 1) * next) as usize, (y + (corner >> 1) * next) as usize);
            let start = first + (y / 4 * across + x / 4) * self.block_bytes;
            if start != last {
                let Some(block) = row.blocks.get(start..start + self.block_bytes) else { return 0 };
                pixels.decode(self.compression, block);
                last = start;
            }
            packed(pixels.radiance(self.compression, y % 4 * 4 + x % 4))
        })
    }

    /// The packed radiance of all levels of a row's views.
    pub fn texels<'a>(&self, row: &RowView<'a>) -> Cow<'a, [u32]> {
        if self.compression == Compression::None {
            return row.texels.into();
        }
        let mut texels = Vec::with_capacity(row.blocks.len() / self.light_bytes * self.levels.count as usize);
        for view in row.blocks.chunks_exact(self.light_bytes) {
            for (&(_, side), first) in self.levels.levels.iter().zip(&self.first_bytes) {
                let count = byte_count(self.compression, side).unwrap_or_default();
                decompress(self.compression, side, &view[*first..first + count], &mut texels);
            }
        }
        texels.into()
    }

    /// The parallaxes of a row's views, as they are stored.
    pub fn parallaxes<'a>(&self, row: &RowView<'a>) -> Cow<'a, [i16]> {
        if self.compression == Compression::None {
            return row.parallax.into();
        }
        let side = self.side();
        let pixels =
            |blocks| (0..side * side).map(move |pixel| depth_blocks::at(side, blocks, pixel % side, pixel / side));
        row.depths.chunks_exact(self.depth_bytes).flat_map(pixels).collect::<Vec<i16>>().into()
    }
}
