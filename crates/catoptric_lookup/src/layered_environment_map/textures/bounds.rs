//! Between which shares of a shell anything is shown in parts of a texture: rays need not look for things elsewhere.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::depths::{Depth, Depths};
use super::texels::{InTexels, TexelLayout};

/// Cells of the finest level have this many texels a side, as a power of two. Chosen, not measured.
const FINEST: u32 = 2;

/// Largest number of cells a side of a rectangle that are read for many rays together. A bound on time; chosen, not
/// measured.
const MAX_CELLS: u32 = 4;

/// Bounds of depths in cells of a texture's finest level, smaller and larger ones.
#[derive(Clone, Debug)]
pub(crate) struct DepthBounds {
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
pub(crate) struct Range {
    pub(crate) least: f32,
    pub(crate) most: f32,
}

impl Range {
    const NOTHING: Self = Self { least: f32::INFINITY, most: 0.0 };

    /// No bounds.
    const ALL: Self = Self { least: 0.0, most: f32::INFINITY };

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

impl DepthBounds {
    /// Bounds of a texture's depths, texel by texel of its finest level.
    pub(crate) fn new(layout: &TexelLayout, depths: &Depths) -> Self {
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
    pub(crate) fn is_nothing_between<const LANES: usize>(
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

    /// Bounds of what is shown wherever the way between two places passes, lane by lane: each lane's are those that it
    /// has alone. All that is shown where that is not known: the places are on two faces.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn between<const LANES: usize>(
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
            // Of cells that are no smaller than the rectangle it reaches into no more than two times two.
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

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_core::math::lanes::Vec3Lanes;
    use catoptric_core::math::random::Stream;
    use glam::Vec3;

    #[test]
    fn bounds_hold_all_that_straight_ways_pass() {
        let mut random = Stream::new(11);
        for size in [8, 64, 256] {
            let layout = TexelLayout::cube(size);
            // A few things before nothing.
            let things: Vec<(Vec3, f32)> = (0..12)
                .map(|_| {
                    let middle = Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)));
                    (middle.normalize(), random.next_between(0.3, 1.2))
                })
                .collect();
            let texel = |texel: u32| {
                let direction = layout.middle_of(texel).normalize();
                let shown = things.iter().find(|(middle, _)| middle.dot(direction) > 0.97);
                shown.map_or(Depth::NOTHING, |(_, share)| Depth { front: *share, back: 1.1 * share })
            };
            let depths = Depths::new((0..6 * size * size).map(texel));
            let bounds = DepthBounds::new(&layout, &depths);
            let (mut known, mut nothing, mut narrower) = (0, 0, 0);
            for _ in 0..400 {
                let mut vector = |size: f32| Vec3::from([0; 3].map(|_| random.next_between(-size, size)));
                // Four ways side by side, one of which is not wanted.
                let (start, end) = (vector(1.0), vector(1.0));
                let start = [0.1, 0.1, 0.1, 2.0].map(|aside| start + vector(aside));
                let end = [0.1, 0.1, 0.1, 2.0].map(|aside| end + vector(aside));
                let wanted = [true, true, true, false];
                let in_texels = |places: &Vec3Lanes<4>| layout.in_texels(places);
                let in_one = |place: &Vec3Lanes<1>| layout.in_texels(place);
                let ends = [&in_texels(&Vec3Lanes::new(&start)), &in_texels(&Vec3Lanes::new(&end))];
                let ranges = bounds.between(ends, &wanted);
                let is_nothing = bounds.is_nothing_between(ends, &wanted);
                nothing += u32::from(is_nothing);
                for (lane, (start, end)) in start.into_iter().zip(end).enumerate().take(3) {
                    let range = ranges[lane];
                    known += u32::from(range.most < f32::INFINITY);
                    narrower += u32::from(range.least > 0.35 && range.most < 1.1);
                    let alone = [start, end].map(|place| in_one(&Vec3Lanes::new(&[place])));
                    let [range_alone] = bounds.between([&alone[0], &alone[1]], &[true]);
                    assert_eq!(range, range_alone, "a lane's bounds are its own");
                    for step in 0..=100 {
                        let place = start.lerp(end, step as f32 / 100.0);
                        let [texel] = layout.nearest(&Vec3Lanes::new(&[place]));
                        let word = depths.word(texel);
                        let (front, back) = (depths.front(word), depths.back(word));
                        let holds = range.least <= front && back <= range.most && !is_nothing;
                        assert!(front == f32::INFINITY || holds, "{place}: {front} to {back} in {range:?}");
                    }
                }
            }
            assert!(known > 20 && nothing > 2 && narrower > 2, "{size}: {known}, {nothing}, {narrower}");
        }
    }
}
