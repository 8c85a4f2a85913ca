//! Textures of layers: the faces of a cube or a single square with transparency, and which texels a look-up reads.
//!
//! [`TexelLayout::taps`] is the only place that says which texels count how much: look-ups sum over it, and inference
//! has its matrix from it.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use catoptric_core::math::lanes::{Lanes, Vec3Lanes, whole};
use catoptric_engine::light::cube_map::{Located, ProbeRows, direction_of, locate, texels_across};
use glam::{Vec2, Vec3, Vec4};
use std::ops::Range;

/// The largest ratio of a footprint's axes that is resolved by several look-ups: there are many layers to look up.
/// Chosen, not measured.
const MAX_ANISOTROPY: f32 = 4.0;

/// The places of look-ups (unit directions, or places of a square), and their changes from pixel to pixel: right, then
/// down.
#[derive(Clone, Copy, Debug)]
pub struct Footprints<const LANES: usize> {
    /// The places.
    pub places: Vec3Lanes<LANES>,
    /// The changes of their places from pixel to pixel.
    pub changes: [Vec3Lanes<LANES>; 2],
}

/// Four texels that are read together, with their weights.
#[derive(Clone, Copy, Debug)]
pub struct TexelTaps {
    /// Their numbers.
    pub texels: [u32; 4],
    /// The weight of each.
    pub weights: [f32; 4],
}

impl TexelTaps {
    /// Each texel with its weight, without those whose weight is 0.
    pub(crate) fn iter(self) -> impl Iterator<Item = (u32, f32)> {
        self.texels.into_iter().zip(self.weights).filter(|(_, weight)| *weight != 0.0)
    }
}

/// Texels of the finest level, side by side.
#[derive(Clone, Copy, Debug)]
pub struct InTexels<const LANES: usize> {
    pub(crate) face: [u32; LANES],
    pub(crate) column: [u32; LANES],
    pub(crate) row: [u32; LANES],
    /// True for places within the faces, not beyond a square.
    pub(crate) is_within: [bool; LANES],
}

/// The order of a texture's texels: level after level from the finest, face after face, row after row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct TexelLayout {
    /// Texels a side of the finest level, a power of two.
    pub size: u32,
    /// Six: those of a cube, looked up by directions. One: a square, looked up by places from -1 to 1.
    pub faces: u32,
    /// The first texel of every level.
    levels: Vec<u32>,
    count: u32,
}

impl TexelLayout {
    /// The faces of a cube.
    pub fn cube(size: u32) -> Self {
        Self::new(size, 6)
    }

    /// A square.
    pub fn square(size: u32) -> Self {
        Self::new(size, 1)
    }

    fn new(size: u32, faces: u32) -> Self {
        let (mut levels, mut count) = (Vec::new(), 0);
        let mut side = size;
        while side > 0 {
            levels.push(count);
            count += faces * side * side;
            side /= 2;
        }
        Self { size, faces, levels, count }
    }

    /// Texels a side of the finest level.
    pub(crate) fn size(&self) -> u32 {
        self.size
    }

    /// Texels of all levels.
    pub fn texel_count(&self) -> usize {
        self.count as usize
    }

    /// Texels of the finest level.
    pub(crate) fn finest_count(&self) -> usize {
        (self.faces * self.size * self.size) as usize
    }

    /// The texels of a face, level after level from the finest.
    pub(crate) fn levels_of(&self, face: u32) -> impl Iterator<Item = Range<usize>> + use<> {
        let size = self.size;
        self.levels.clone().into_iter().enumerate().map(move |(level, first)| {
            let count = (size >> level) * (size >> level);
            let first = (first + face * count) as usize;
            first..first + count as usize
        })
    }

    /// Faces of a level.
    pub fn faces(&self) -> u32 {
        self.faces
    }

    /// Look-up direction or place of a place of a face (from -1 to 1).
    pub fn place_of(&self, face: u32, at: Vec2) -> Vec3 {
        if self.faces == 6 { direction_of(face as usize, at) } else { at.extend(0.0) }
    }

    /// Look-up direction or place of the middle of a texel of the finest level.
    pub fn middle_of(&self, texel: u32) -> Vec3 {
        let (row, column) = (texel / self.size, texel % self.size);
        let at = Vec2::new(column as f32, (row % self.size) as f32) + 0.5;
        self.place_of(row / self.size, at * (2.0 / self.size as f32) - 1.0)
    }

    /// The texels that look-ups read, with their weights, which sum to one (less beyond a square's edges): trilinear
    /// look-ups side by side along the longer axis of a footprint. Lanes that are not wanted read nothing.
    #[inline(always)] // for the instructions of its caller
    pub fn taps<const LANES: usize>(
        &self,
        footprints: &Footprints<LANES>,
        wanted: &[bool; LANES],
        tap: &mut impl FnMut(usize, TexelTaps),
    ) {
        let probes = ProbeRows::of(&footprints.changes, MAX_ANISOTROPY);
        let mut most = 0.0;
        for lane in 0..LANES {
            most = if wanted[lane] { probes.count[lane].max(most) } else { most };
        }
        for number in 0..most as u32 {
            let mut weights = Lanes::ZERO;
            for lane in 0..LANES {
                let is_read = wanted[lane] && (number as f32) < probes.count[lane];
                weights[lane] = if is_read { 1.0 / probes.count[lane] } else { 0.0 };
            }
            self.trilinear(&probes.places(&footprints.places, number), &probes.spread, &weights, tap);
        }
    }

    /// The width of a footprint's narrower axis, in texels of the finest level.
    pub(crate) fn width(&self, footprints: &Footprints<1>) -> f32 {
        let probes = ProbeRows::of(&footprints.changes, MAX_ANISOTROPY);
        texels_across(probes.spread[0], self.size, self.located(&footprints.places).secant2[0])
    }

    /// Footprints of one width about places (unit directions, or places of the square).
    #[inline(always)] // for the instructions of its caller
    fn trilinear<const LANES: usize>(
        &self,
        places: &Vec3Lanes<LANES>,
        spread: &Lanes<LANES>,
        weights: &Lanes<LANES>,
        tap: &mut impl FnMut(usize, TexelTaps),
    ) {
        let located = self.located(places);
        let last = self.levels.len() as u32 - 1;
        let mut level = [0; LANES];
        let mut blend = [0.0; LANES];
        for lane in 0..LANES {
            let texels = texels_across(spread[lane], self.size, located.secant2[lane]);
            // Between two levels the blend is linear in the width: exponent and mantissa are level and blend.
            let bits = texels.max(1.0).to_bits();
            let exponent = (bits >> 23) - 127;
            let mantissa = f32::from_bits(bits & 0x007F_FFFF | 0x3F80_0000) - 1.0;
            level[lane] = exponent.min(last);
            blend[lane] = if exponent < last { mantissa } else { 0.0 };
        }
        let (mut fine, mut coarse) = (Lanes::ZERO, Lanes::ZERO);
        for lane in 0..LANES {
            fine[lane] = weights[lane] * (1.0 - blend[lane]);
            coarse[lane] = weights[lane] * blend[lane];
        }
        self.bilinear(&located, &level, &fine, tap);
        for level in &mut level {
            *level = (*level + 1).min(last);
        }
        self.bilinear(&located, &level, &coarse, tap);
    }

    #[inline(always)] // for the instructions of its caller
    fn bilinear<const LANES: usize>(
        &self,
        located: &Located<LANES>,
        level: &[u32; LANES],
        weights: &Lanes<LANES>,
        tap: &mut impl FnMut(usize, TexelTaps),
    ) {
        let mut low = [[0i32; LANES]; 2];
        let mut part = [[0.0; LANES]; 2];
        for axis in 0..2 {
            for lane in 0..LANES {
                let side = (self.size >> level[lane]) as f32;
                let place = (located.at[axis][lane] + 1.0) * (0.5 * side) - 0.5;
                // Places far beyond a square read nothing; values that are not numbers become the edge.
                let place = place.max(-2.0).min(side + 1.0);
                let floor = (place + 2.0).floor();
                low[axis][lane] = whole(floor) as i32 - 2;
                part[axis][lane] = place - (floor - 2.0);
            }
        }
        for lane in 0..LANES {
            let weight = weights[lane];
            if weight == 0.0 {
                continue;
            }
            let (level, face) = (level[lane] as usize, located.face[lane]);
            let side = self.size >> level;
            let (x, y) = (low[0][lane], low[1][lane]);
            let (right, down) = (part[0][lane], part[1][lane]);
            let (above, below) = (weight * (1.0 - down), weight * down);
            let weights = [above * (1.0 - right), above * right, below * (1.0 - right), below * right];
            let inner = 0..side as i32 - 1;
            if inner.contains(&x) && inner.contains(&y) {
                let texel = self.levels[level] + (face * side + y as u32) * side + x as u32;
                tap(lane, TexelTaps { texels: [texel, texel + 1, texel + side, texel + side + 1], weights });
            } else {
                tap(lane, self.beyond_an_edge(level, face, [x, y], weights));
            }
        }
    }

    /// The taps about a corner where some are beyond a face.
    #[inline(never)]
    fn beyond_an_edge(&self, level: usize, face: u32, [x, y]: [i32; 2], mut weights: [f32; 4]) -> TexelTaps {
        let mut texels = [0; 4];
        for (number, (dx, dy)) in [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter().enumerate() {
            match self.texel(level, face, x + dx, y + dy) {
                Some(texel) => texels[number] = texel,
                None => weights[number] = 0.0,
            }
        }
        TexelTaps { texels, weights }
    }

    /// The texels of the finest level that places lie in; beyond a square: none, [`u32::MAX`].
    #[inline(always)] // for the instructions of its caller
    pub fn nearest<const LANES: usize>(&self, places: &Vec3Lanes<LANES>) -> [u32; LANES] {
        let InTexels { face, column, row, is_within } = self.in_texels(places);
        let mut texels = [0; LANES];
        for lane in 0..LANES {
            let texel = (face[lane] * self.size + row[lane]) * self.size + column[lane];
            texels[lane] = if is_within[lane] { texel } else { u32::MAX };
        }
        texels
    }

    /// The texels of the finest level in which places lie, or to which they are nearest.
    #[inline(always)] // for the instructions of its caller
    pub fn in_texels<const LANES: usize>(&self, places: &Vec3Lanes<LANES>) -> InTexels<LANES> {
        let Located { face, at, .. } = self.located(places);
        let (size, last) = (self.size as f32, (self.size - 1) as f32);
        let mut found = InTexels { face, column: [0; LANES], row: [0; LANES], is_within: [false; LANES] };
        for lane in 0..LANES {
            let along = |axis: usize| {
                let place = (at[axis][lane] + 1.0) * (0.5 * size);
                whole(place.max(0.0).min(last).floor())
            };
            (found.column[lane], found.row[lane]) = (along(0), along(1));
            found.is_within[lane] = at[0][lane].abs() <= 1.0 && at[1][lane].abs() <= 1.0;
        }
        found
    }

    /// The upper left ones of the four texels of the finest level about places (those of the same face; beyond a
    /// square: none, [`u32::MAX`]), and where between the four these are: to the right and down.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn quads<const LANES: usize>(&self, places: &Vec3Lanes<LANES>) -> ([u32; LANES], [Lanes<LANES>; 2]) {
        let located = self.located(places);
        let mut aside = [Lanes::ZERO; 2];
        let mut low = [[0; LANES]; 2];
        let (size, last) = (self.size as f32, (self.size - 1) as f32);
        let before_last = self.size.saturating_sub(2) as f32;
        for axis in 0..2 {
            for lane in 0..LANES {
                let at = ((located.at[axis][lane] + 1.0) * (0.5 * size) - 0.5).max(0.0).min(last);
                let floor = at.floor().min(before_last);
                low[axis][lane] = whole(floor);
                aside[axis][lane] = at - floor;
            }
        }
        let mut texels = [0; LANES];
        for lane in 0..LANES {
            let is_within = located.at[0][lane].abs() <= 1.0 && located.at[1][lane].abs() <= 1.0;
            let first = (located.face[lane] * self.size + low[1][lane]) * self.size + low[0][lane];
            texels[lane] = if is_within { first } else { u32::MAX };
        }
        (texels, aside)
    }

    #[inline(always)] // for the instructions of its caller
    fn located<const LANES: usize>(&self, places: &Vec3Lanes<LANES>) -> Located<LANES> {
        if self.faces == 6 {
            return Located::of(places);
        }
        Located { face: [0; LANES], at: [places[0], places[1]], secant2: Lanes::splat(1.0) }
    }

    /// A texel of a face, or that of the next face where it lies beyond an edge; none beyond the edge of a square.
    fn texel(&self, level: usize, face: u32, x: i32, y: i32) -> Option<u32> {
        let side = self.size >> level;
        let within = 0..side as i32;
        if within.contains(&x) && within.contains(&y) {
            return Some(self.levels[level] + (face * side + y as u32) * side + x as u32);
        }
        if self.faces != 6 {
            return None;
        }
        let at = (Vec2::new(x as f32, y as f32) + 0.5) * (2.0 / side as f32) - 1.0;
        let (face, at, _) = locate(direction_of(face as usize, at));
        let place = ((at + 1.0) * (0.5 * side as f32)).clamp(Vec2::ZERO, Vec2::splat(side as f32 - 1.0));
        Some(self.levels[level] + (face as u32 * side + place.y as u32) * side + place.x as u32)
    }

    /// The texels of the finest level about one of them.
    pub(crate) fn beside(&self, texel: u32) -> impl Iterator<Item = u32> {
        let (face, index) = (texel / (self.size * self.size), texel % (self.size * self.size));
        let (x, y) = ((index % self.size) as i32, (index / self.size) as i32);
        let others = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).filter(|other| *other != (0, 0));
        others.filter_map(move |(dx, dy)| self.texel(0, face, x + dx, y + dy))
    }

    /// The texels of coarser levels, each with the four of the next finer level that it covers.
    pub(crate) fn coarser(&self) -> impl Iterator<Item = (u32, [u32; 4])> {
        (1..self.levels.len()).flat_map(move |level| {
            let side = self.size >> level;
            (0..self.faces * side * side).map(move |index| (self.levels[level] + index, self.covered(level, index)))
        })
    }

    /// The texels of the next finer level that a texel of a level covers.
    fn covered(&self, level: usize, index: u32) -> [u32; 4] {
        let side = self.size >> level;
        let (row, x) = (index / side, index % side);
        let corner = self.levels[level - 1] + 4 * row * side + 2 * x;
        [corner, corner + 1, corner + 2 * side, corner + 2 * side + 1]
    }

    /// Fills all levels but the finest: each texel has the mean of the four that it covers.
    pub fn fill_coarser(&self, texels: &mut [Vec4]) {
        for level in 1..self.levels.len() {
            let side = self.size >> level;
            for index in 0..self.faces * side * side {
                let sum: Vec4 = self.covered(level, index).into_iter().map(|finer| texels[finer as usize]).sum();
                texels[(self.levels[level] + index) as usize] = sum * 0.25;
            }
        }
    }
}
