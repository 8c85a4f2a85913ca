//! Between which shares of a shell anything is shown in parts of a texture: rays need not look for things elsewhere.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::depths::{Depth, Depths};
use super::texels::{InTexels, TexelLayout};

/// Cells of the finest level have this many texels a side, as a power of two. Chosen, not measured.
const FINEST: u32 = 2;

/// Largest number of cells a side of a rectangle that are read. A bound on time; chosen, not measured.
const MAX_CELLS: u32 = 4;

/// Bounds of depths in cells of a texture's finest level, smaller and larger ones.
#[derive(Clone, Debug)]
pub(crate) struct DepthBounds {
    /// Levels of cells, the smallest cells first; each has face after face, row after row.
    levels: Vec<Vec<Range>>,
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

    /// Of what is shown wherever the ways between two places each pass, as far as these are wanted, seen from the
    /// centre: a straight way
    /// between places of one face of a cube lies in the rectangle about them. None where that is not known: not all
    /// are on one face.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn between<const LANES: usize>(
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
        let level = (u32::BITS - (span / MAX_CELLS).leading_zeros()) as usize;
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
    pub(crate) fn byte_count(&self) -> u64 {
        self.levels.iter().map(|level| size_of_val(level.as_slice()) as u64).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Vec3Lanes;
    use crate::math::random::Stream;
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
                let ends = [&in_texels(&Vec3Lanes::new(&start)), &in_texels(&Vec3Lanes::new(&end))];
                let Some(range) = bounds.between(ends, &wanted) else { continue };
                known += 1;
                nothing += u32::from(range.least > range.most);
                narrower += u32::from(range.least > 0.35 && range.most < 1.1);
                for (start, end) in start.into_iter().zip(end).take(3) {
                    for step in 0..=100 {
                        let place = start.lerp(end, step as f32 / 100.0);
                        let [texel] = layout.nearest(&Vec3Lanes::new(&[place]));
                        let word = depths.word(texel);
                        let (front, back) = (depths.front(word), depths.back(word));
                        let holds = range.least <= front && back <= range.most;
                        assert!(front == f32::INFINITY || holds, "{place}: {front} to {back} in {range:?}");
                    }
                }
            }
            assert!(known > 20 && nothing > 2 && narrower > 2, "{size}: {known}, {nothing}, {narrower}");
        }
    }
}
