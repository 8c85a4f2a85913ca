//! Between which shares of a shell anything is shown in parts of a texture: rays need not look for things elsewhere.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::depths::{Depth, Depths};
use crate::layered_environment_map::texels::{InTexels, TexelLayout};

/// Cells of the finest level have this many texels a side, as a power of two. Chosen, not measured.
const FINEST: u32 = 2;

/// Largest number of cells a side of a rectangle that are read for many rays together. A bound on time; chosen, not
/// measured.
const MAX_CELLS: u32 = 4;

/// Bounds of depths in cells of a texture's finest level, smaller and larger ones.
#[derive(Clone, Debug)]
pub struct DepthBounds {
    /// Cells level after level, the smallest first; each level has face after face, row after row.
    cells: Vec<Range>,
    /// The first cell of every level.
    levels: Vec<u32>,
    /// Texels a side of a face.
    size: u32,
}

/// The least share at which something is shown, and the largest at which something ends; nothing: the least is
/// infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The nearest.
    pub least: f32,
    /// The farthest.
    pub most: f32,
}

impl Range {
    const NOTHING: Self = Self { least: f32::INFINITY, most: 0.0 };

    /// The range without bounds.
    const ALL: Self = Self { least: 0.0, most: f32::INFINITY };

    /// The union of both.
    #[inline(always)] // for the instructions of its caller
    fn with(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }

    fn of(depth: Depth) -> Self {
        let is_shown = depth.front.is_finite();
        if is_shown { Self { least: depth.front, most: depth.front.max(depth.back) } } else { Self::NOTHING }
    }
}

impl DepthBounds {
    /// Bounds of a texture's depths, texel by texel of its finest level.
    pub fn new(layout: &TexelLayout, depths: &Depths) -> Self {
        let size = layout.size();
        let side = (size >> FINEST).max(1);
        let mut finest = vec![Range::NOTHING; (layout.faces() * side * side) as usize];
        for (texel, depth) in depths.iter().enumerate() {
            let (row, column) = (texel as u32 / size, texel as u32 % size);
            let (face, row) = (row / size, row % size);
            let cell = (face * side + (row >> FINEST).min(side - 1)) * side + (column >> FINEST).min(side - 1);
            finest[cell as usize] = finest[cell as usize].with(Range::of(depth));
        }
        let (mut cells, mut levels, mut finer) = (finest, vec![0], side);
        while finer > 1 {
            let below = levels[levels.len() - 1];
            levels.push(cells.len() as u32);
            let side = finer / 2;
            for index in 0..layout.faces() * side * side {
                let corner = below + index / side * 2 * finer + index % side * 2;
                let four = [corner, corner + 1, corner + finer, corner + finer + 1];
                cells.push(four.into_iter().fold(Range::NOTHING, |range, cell| range.with(cells[cell as usize])));
            }
            finer = side;
        }
        Self { cells, levels, size }
    }

    /// Returns true if nothing is shown wherever the ways between two places each pass, as far as these are wanted,
    /// seen from the centre: a straight way between places of one face of a cube lies in the rectangle about them.
    /// False where that is not known: not all are on one face.
    #[inline(always)] // for the instructions of its caller
    pub fn is_nothing_between<const LANES: usize>(
        &self,
        [starts, ends]: [&InTexels<LANES>; 2],
        wanted: &[bool; LANES],
    ) -> bool {
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
            return false;
        }
        let (low, high) = self.cells_about([least[1], least[2]], [most[1], most[2]]);
        let span = (high[0] - low[0]).max(high[1] - low[1]);
        let level = self.held(u32::BITS - (span / MAX_CELLS).leading_zeros());
        let mut range = Range::NOTHING;
        for row in low[1] >> level..=high[1] >> level {
            for column in low[0] >> level..=high[0] >> level {
                range = range.with(self.cell(level, face, [column, row]));
            }
        }
        range == Range::NOTHING
    }

    /// Bounds of the depths shown along the way between two places, lane by lane: each lane's do not depend on others.
    /// If the places are on two faces, the bounds of everything.
    #[inline(always)] // for the instructions of its caller
    pub fn between<const LANES: usize>(
        &self,
        [starts, ends]: [&InTexels<LANES>; 2],
        wanted: &[bool; LANES],
    ) -> [Range; LANES] {
        let mut ranges = [Range::NOTHING; LANES];
        for lane in 0..LANES {
            if !wanted[lane] {
                continue;
            }
            let face = starts.face[lane];
            if face != ends.face[lane] {
                ranges[lane] = Range::ALL;
                continue;
            }
            let (start, end) = ([starts.column[lane], starts.row[lane]], [ends.column[lane], ends.row[lane]]);
            let least = [start[0].min(end[0]), start[1].min(end[1])];
            let most = [start[0].max(end[0]), start[1].max(end[1])];
            let (low, high) = self.cells_about(least, most);
            let span = (high[0] - low[0]).max(high[1] - low[1]);
            // At cells that are no smaller than the rectangle, it overlaps at most two times two of them.
            let level = self.held(u32::BITS - span.saturating_sub(1).leading_zeros());
            let (left, above) = (low[0] >> level, low[1] >> level);
            let (right, below) = (high[0] >> level, high[1] >> level);
            let upper = self.cell(level, face, [left, above]).with(self.cell(level, face, [right, above]));
            let lower = self.cell(level, face, [left, below]).with(self.cell(level, face, [right, below]));
            ranges[lane] = upper.with(lower);
        }
        ranges
    }

    /// The smallest cells, by column and row, about a rectangle of texels.
    #[inline(always)] // for the instructions of its caller
    fn cells_about(&self, least: [u32; 2], most: [u32; 2]) -> ([u32; 2], [u32; 2]) {
        // Rounding may take places on the way to the next texel.
        let last = self.size - 1;
        let low = [least[0].saturating_sub(1) >> FINEST, least[1].saturating_sub(1) >> FINEST];
        (low, [(most[0] + 1).min(last) >> FINEST, (most[1] + 1).min(last) >> FINEST])
    }

    /// A level that there is.
    #[inline(always)] // for the instructions of its caller
    fn held(&self, level: u32) -> u32 {
        level.min(self.levels.len() as u32 - 1)
    }

    #[inline(always)] // for the instructions of its caller
    fn cell(&self, level: u32, face: u32, [column, row]: [u32; 2]) -> Range {
        let side = (self.size >> (FINEST + level)).max(1);
        let cell = self.levels[level as usize] + (face * side + row.min(side - 1)) * side + column.min(side - 1);
        self.cells.get(cell as usize).copied().unwrap_or(Range::NOTHING)
    }

    /// The cells of all levels, and how many levels there are.
    pub(crate) fn parts(&self) -> (&[Range], u32) {
        (&self.cells, self.levels.len() as u32)
    }

    /// Memory.
    pub(crate) fn byte_count(&self) -> u64 {
        size_of_val(self.cells.as_slice()) as u64
    }
}
