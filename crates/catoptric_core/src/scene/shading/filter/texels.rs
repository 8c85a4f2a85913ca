//! Texels at a place of a texture, and their blends.

use super::super::texture::Texture;
use super::arithmetic::{floor, index};
use super::taps::Taps;
use crate::math::lanes::Lanes;
use glam::Vec4;

/// The mip levels that are read, one a look-up.
pub(super) struct LevelLanes<const N: usize> {
    size: [Lanes<N>; 2],
    first: [u32; N],
    stride: [u32; N],
}

impl<const N: usize> LevelLanes<N> {
    /// The levels of these indices; the coarsest where there are fewer.
    #[inline(always)]
    pub(super) fn new(texture: &Texture, indices: &[u32; N]) -> Self {
        let level = |index: u32| &texture.levels[(index as usize).min(texture.levels.len() - 1)];
        let level0 = level(indices[0]);
        let mut lanes =
            Self { size: level0.size.map(Lanes::splat), first: [level0.first; N], stride: [level0.stride; N] };
        // Neighbours mostly read the same.
        if *indices != [indices[0]; N] {
            for (i, &index) in indices.iter().enumerate() {
                let level = level(index);
                (lanes.size[0][i], lanes.size[1][i]) = (level.size[0], level.size[1]);
                (lanes.first[i], lanes.stride[i]) = (level.first, level.stride);
            }
        }
        lanes
    }
}

/// Coordinates of the look-ups along the footprints, brought into 0..1. `REPEATS`: `wrap` is 1.
#[inline(always)]
pub(super) fn along<const N: usize, const REPEATS: bool>(
    probe: u32,
    at: &Lanes<N>,
    taps: &Taps<N>,
    axis: usize,
    wrap: f32,
) -> Lanes<N> {
    let mut result = Lanes::splat(0.0);
    for i in 0..N {
        let (at, step, share) = (at[i], taps.step[axis][i], taps.share[i]);
        let coordinate = at + step * ((probe as f32 + 0.5) * share - 0.5);
        let folded = if REPEATS {
            coordinate - floor(coordinate)
        } else {
            let scaled = coordinate * wrap;
            let fraction = scaled - floor(scaled);
            let mirrored = 1.0 - (1.0 - 2.0 * fraction).abs();
            let folded = if wrap == 1.0 { fraction } else { mirrored };
            if wrap == 0.0 { coordinate } else { folded }
        };
        // NaN, and coordinates that rounding leaves outside.
        let folded = if folded > 0.0 { folded } else { 0.0 };
        result[i] = if folded < 1.0 { folded } else { 1.0 };
    }
    result
}

/// The texels to be blended: where the left ones of the upper and the lower row are, and the shares of the right ones
/// and of the lower row.
pub(super) struct Texels<const N: usize> {
    rows: [[u32; N]; 2],
    share: [Lanes<N>; 2],
}

#[inline(always)]
pub(super) fn corners<const N: usize, const REPEATS: bool>(
    wrapped: &[Lanes<N>; 2],
    levels: &LevelLanes<N>,
    wrap: [f32; 2],
    half: &Lanes<N>,
) -> Texels<N> {
    let mut texels = Texels { rows: [[0; N]; 2], share: [Lanes::splat(0.0); 2] };
    let [wrap_u, wrap_v] = wrap;
    // All loads come first and nothing branches, so that the loop becomes vector instructions.
    for i in 0..N {
        let [width, height] = [levels.size[0][i], levels.size[1][i]];
        let (first_texel, stride) = (levels.first[i], levels.stride[i]);
        let half = half[i];
        let (x, y) = (wrapped[0][i] * width - half, wrapped[1][i] * height - half);
        let blended = if half > 0.0 { 1.0 } else { 0.0 };

        // Mirrored coordinates are already folded: beyond the edge lies the edge's own texel.
        let last = width - 1.0;
        let first = floor(x);
        let below = if REPEATS || wrap_u == 1.0 { last } else { 0.0 };
        let inside = if first < 0.0 { below } else { first };
        let inside = if first > last { last - below } else { inside };
        let column = index(inside);
        // Left of the image its edge shows alone, if it does not repeat; right of it see `Texture::texels`.
        let edge = !REPEATS & (first < 0.0) & (wrap_u != 1.0);
        let share = if edge { 0.0 } else { x - first };
        texels.share[0][i] = share * blended;

        let last = height - 1.0;
        let first = floor(y);
        let below = if REPEATS || wrap_v == 1.0 { last } else { 0.0 };
        let above = last - below;
        let second = first + 1.0;
        let second = if second > last { above } else { second };
        let inside = if first < 0.0 { below } else { first };
        let inside = if first > last { above } else { inside };
        texels.share[1][i] = (y - first) * blended;

        let start = first_texel.wrapping_add(column);
        texels.rows[0][i] = index(inside).wrapping_mul(stride).wrapping_add(start);
        texels.rows[1][i] = index(second).wrapping_mul(stride).wrapping_add(start);
    }
    texels
}

impl<const N: usize> Texels<N> {
    /// The blend of four texels, 65535 for 1.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
    pub(super) fn blended(&self, texels: &[[u16; 4]], i: usize) -> Vec4 {
        let (upper, lower) = (pair(texels, self.rows[0][i]), pair(texels, self.rows[1][i]));
        let (x, y) = (self.share[0][i], self.share[1][i]);
        let mut both = [0.0; 8];
        for k in 0..8 {
            both[k] = upper[k] + (lower[k] - upper[k]) * y;
        }
        let left = Vec4::new(both[0], both[1], both[2], both[3]);
        let right = Vec4::new(both[4], both[5], both[6], both[7]);
        left + (right - left) * x
    }
}

/// A texel and its right neighbour.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // for the instructions of its caller, which closures would not have
fn pair(texels: &[[u16; 4]], first: u32) -> [f32; 8] {
    let first = first as usize;
    let mut values = [0.0; 8];
    if let Some(pair) = texels.get(first..first + 2).and_then(|pair| pair.as_flattened().first_chunk::<8>()) {
        for k in 0..8 {
            values[k] = f32::from(pair[k]);
        }
    }
    values
}
