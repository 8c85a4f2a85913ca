//! Between which shares of a shell anything is shown in parts of a texture: rays need not look for things elsewhere.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::depths::{Depth, Depths};
use super::texels::{InTexels, Layout};

/// Cells of the finest level have this many texels a side, as a power of two.
const FINEST: u32 = 2;

/// As many cells a side of a rectangle are looked at, at most.
const MOST_CELLS: u32 = 4;

/// Of cells of a texture's finest level, smaller and larger ones, the bounds of what they show.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    /// Levels of cells, the smallest cells first; each has face after face, row after row.
    levels: Vec<Vec<Range>>,
    /// Texels a side of a face.
    size: u32,
}

/// The least share at which something is shown, and the largest at which something ends; nothing: the least is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) least: f32,
    pub(super) most: f32,
}

impl Range {
    const NOTHING: Self = Self { least: f32::INFINITY, most: 0.0 };

    /// Both.
    #[inline(always)] // for the instructions of its caller
    fn with(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    fn of(depth: Depth) -> Self {
        let is_shown = depth.front.is_finite();
        if is_shown { Self { least: depth.front, most: depth.front.max(depth.back) } } else { Self::NOTHING }
    }
}

impl Bounds {
    /// Of what a texture shows, texel by texel of its finest level.
    pub(super) fn new(layout: &Layout, depths: &Depths) -> Self {
        let size = layout.size();
        let side = (size >> FINEST).max(1);
        let mut finest = vec![Range::NOTHING; (layout.faces() * side * side) as usize];
        for (texel, depth) in depths.iter().enumerate() {
            let (row, column) = (texel as u32 / size, texel as u32 % size);
            let (face, row) = (row / size, row % size);
            let cell = (face * side + (row >> FINEST).min(side - 1)) * side + (column >> FINEST).min(side - 1);
            finest[cell as usize] = finest[cell as usize].with(Range::of(depth));
        }
        let (mut levels, mut finer) = (vec![finest], side);
        while finer > 1 {
            let below = &levels[levels.len() - 1];
            let side = finer / 2;
            let cell = |index: u32| {
                let corner = index / side * 2 * finer + index % side * 2;
                let four = [corner, corner + 1, corner + finer, corner + finer + 1];
                four.into_iter().fold(Range::NOTHING, |range, cell| range.with(below[cell as usize]))
            };
            let level = (0..layout.faces() * side * side).map(cell).collect();
            levels.push(level);
            finer = side;
        }
        Self { levels, size }
    }

    /// Of what is shown wherever the ways between two places each pass, as far as these are wanted, seen from the centre: a straight way
    /// between places of one face of a cube lies in the rectangle about them. None where that is not known: not all are on one face.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn between<const LANES: usize>(
        &self,
        [starts, ends]: [&InTexels<LANES>; 2],
        wanted: &[bool; LANES],
    ) -> Option<Range> {
        let (mut least, mut most) = ([u32::MAX; 3], [0u32; 3]);
        for places in [starts, ends] {
            for (number, numbers) in [&places.face, &places.column, &places.row].into_iter().enumerate() {
                for lane in 0..LANES {
                    least[number] = least[number].min(if wanted[lane] { numbers[lane] } else { u32::MAX });
                    most[number] = most[number].max(if wanted[lane] { numbers[lane] } else { 0 });
                }
            }
        }
        let face = most[0];
        if least[0] != face {
            return None;
        }
        // Rounding may take places on the way to the next texel.
        let low = [1, 2].map(|axis| least[axis].saturating_sub(1) >> FINEST);
        let high = [1, 2].map(|axis| (most[axis] + 1).min(self.size - 1) >> FINEST);
        let span = (high[0] - low[0]).max(high[1] - low[1]);
        let level = (u32::BITS - (span / MOST_CELLS).leading_zeros()) as usize;
        let level = level.min(self.levels.len() - 1);
        let side = (self.size >> (FINEST + level as u32)).max(1);
        let mut range = Range::NOTHING;
        for row in low[1] >> level..=high[1] >> level {
            for column in low[0] >> level..=high[0] >> level {
                let cell = (face * side + row.min(side - 1)) * side + column.min(side - 1);
                range = self.levels[level].get(cell as usize).map_or(range, |cell| range.with(*cell));
            }
        }
        Some(range)
    }

    /// Memory.
    pub(super) fn byte_count(&self) -> u64 {
        self.levels.iter().map(|level| size_of_val(level.as_slice()) as u64).sum()
    }
}
