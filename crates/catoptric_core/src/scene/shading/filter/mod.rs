//! Filtered look-ups in textures, several at a time: all work but the reading of texels is done for all of them at
//! once.

use super::sample_patterns::SAMPLE_PATTERNS;
use super::texture::{MipFilter, MipLevel, Texture, Wrap};
use crate::math::lanes::Lanes;
use glam::{Vec2, Vec4};

/// The largest ratio of the footprint's axes that is resolved by several look-ups; beyond it the result is blurred.
const MAX_ANISOTROPY: f32 = 8.0;

/// The positions of look-ups: texture coordinates and their change a pixel, along u and v each.
#[derive(Clone, Debug)]
pub(super) struct TextureLookUps<const N: usize> {
    pub(super) uv: [Lanes<N>; 2],
    /// Change with the pixel's column.
    pub(super) dx: [Lanes<N>; 2],
    /// Change with the pixel's row.
    pub(super) dy: [Lanes<N>; 2],
    /// The number of samples of the pixel that a look-up stands for; 0 as 1.
    pub(super) samples: [u32; N],
}

/// The texels and levels that each look-up reads.
struct Taps<const N: usize> {
    /// Look-ups along the footprint's longer axis, and 1 over them.
    probes: Lanes<N>,
    share: Lanes<N>,
    /// The footprint's longer axis.
    step: [Lanes<N>; 2],
    /// The finer level's index, and the share of the coarser one.
    level: Lanes<N>,
    blend: Lanes<N>,
    /// Half a texel where texels are blended, else 0.
    half: Lanes<N>,
}

/// Properties of textures, read before the look-up.
struct TextureTraits<const N: usize> {
    size: [Lanes<N>; 2],
    /// The index of the coarsest level; below 0 where levels are not used.
    last_level: Lanes<N>,
    /// 1 where the nearest level is taken, not a blend of two.
    nearest_level: Lanes<N>,
    /// Half a texel where texels are blended, when magnified and when minified.
    magnified_half: Lanes<N>,
    minified_half: Lanes<N>,
    /// The wrapping of coordinates: 0 clamped, 1 repeated, 0.5 mirrored.
    wrap: [Lanes<N>; 2],
}

/// The places in a pixel at which each look-up reads its texture: those of a pattern of samples.
struct FootprintPlaces<const N: usize> {
    /// The binary logarithm of how many there are, how many there are, and the side of the square that each stands
    /// for, in pixels.
    count_log2: [u32; N],
    count: Lanes<N>,
    side: Lanes<N>,
}

/// The levels that are read.
struct MipLevelLanes<const N: usize> {
    size: [Lanes<N>; 2],
    first: [u32; N],
    stride: [u32; N],
}

impl<const N: usize> MipLevelLanes<N> {
    const NONE: Self = Self { size: [Lanes::splat(1.0); 2], first: [0; N], stride: [1; N] };

    #[inline(always)]
    fn set(&mut self, lane: usize, level: &MipLevel) {
        (self.size[0][lane], self.size[1][lane]) = (level.width as f32, level.height as f32);
        (self.first[lane], self.stride[lane]) = (level.first, level.width + 1);
    }
}

/// The most places in a pixel: see [`places`].
const MAX_PLACES: usize = 8;

/// The places of 1, 2, 4 and 8 samples, from the middle of the pixel; 0, where there are fewer.
static PLACES: [[Vec2; MAX_PLACES]; 4] = {
    let mut places = [[Vec2::ZERO; MAX_PLACES]; 4];
    let mut pattern = 0;
    while pattern < places.len() {
        let mut place = 0;
        while place < 1 << pattern {
            let [x, y] = SAMPLE_PATTERNS[pattern][place];
            places[pattern][place] = Vec2::new(x as f32 / 16.0 - 0.5, y as f32 / 16.0 - 0.5);
            place += 1;
        }
        pattern += 1;
    }
    places
};

/// The filtered values of textures; white where there is none, or where the place is not finite.
///
/// A look-up that stands for several samples is made at the place of each, with its share of the footprint.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
pub(super) fn sample<const N: usize>(textures: &[Option<&Texture>; N], at: &TextureLookUps<N>) -> [Vec4; N] {
    let traits = traits(textures);
    let places = places(&traits, at);
    let taps = taps(&traits, at, &places.side);
    let mut texels: [&[[u16; 4]]; N] = [&[]; N];
    let (mut fine_levels, mut coarse_levels) = (MipLevelLanes::NONE, MipLevelLanes::NONE);
    // Counts and kinds of each lane's look-ups: zero without a texture.
    let (mut place_counts, mut probe_counts) = ([0u32; N], [0u32; N]);
    let (mut most_places, mut most_probes, mut any_blend) = (0, 0, false);
    for i in 0..N {
        let Some(texture) = textures[i] else { continue };
        let last = texture.levels.len() - 1;
        let fine = (index(taps.level[i]) as usize).min(last);
        fine_levels.set(i, &texture.levels[fine]);
        if taps.blend[i] > 0.0 {
            coarse_levels.set(i, &texture.levels[(fine + 1).min(last)]);
            any_blend = true;
        }
        texels[i] = &texture.texels;
        (place_counts[i], probe_counts[i]) = (1 << places.count_log2[i], index(taps.probes[i]));
        most_places = most_places.max(place_counts[i]);
        most_probes = most_probes.max(probe_counts[i]);
    }
    let look_up = PreparedLookUp {
        at,
        places: &places,
        taps: &taps,
        wrap: &traits.wrap,
        texels: &texels,
        levels: [&fine_levels, &coarse_levels],
        counts: [&place_counts, &probe_counts],
        steps: [most_places, most_probes],
    };
    let repeats = traits.wrap == [Lanes::splat(1.0); 2];
    let mut sums = match (repeats, any_blend) {
        (true, false) => look_up.sums::<true, false>(),
        (true, true) => look_up.sums::<true, true>(),
        (false, _) => look_up.sums::<false, true>(),
    };
    for i in 0..N {
        let finite = at.uv[0][i].is_finite() && at.uv[1][i].is_finite();
        let share = taps.share[i] / (places.count[i] * 65535.0);
        sums[i] = if textures[i].is_some() && finite { sums[i] * share } else { Vec4::ONE };
    }
    sums
}

/// Look-ups with all computed but the texels.
struct PreparedLookUp<'a, const N: usize> {
    at: &'a TextureLookUps<N>,
    places: &'a FootprintPlaces<N>,
    taps: &'a Taps<N>,
    wrap: &'a [Lanes<N>; 2],
    texels: &'a [&'a [[u16; 4]]; N],
    /// The finer and the coarser one.
    levels: [&'a MipLevelLanes<N>; 2],
    /// The numbers of places and probes of each.
    counts: [&'a [u32; N]; 2],
    /// The largest of either.
    steps: [u32; 2],
}

/// Steps (a probe at a place) whose texels are found before any is read.
const STEPS_AT_ONCE: usize = 4;

impl<const N: usize> PreparedLookUp<'_, N> {
    /// The sums over all places and probes. `REPEATS`: all textures do; `BLENDS`: some need their coarser level too.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
    fn sums<const REPEATS: bool, const BLENDS: bool>(&self) -> [Vec4; N] {
        let [places, probes] = self.steps;
        let mut sums = [Vec4::ZERO; N];
        let mut fine = [Texels::NONE; STEPS_AT_ONCE];
        let mut coarse = [Texels::NONE; STEPS_AT_ONCE];
        let mut steps = [[0u32; 2]; STEPS_AT_ONCE];
        let (mut place, mut probe) = (0, 0);
        while place < places {
            let mut count = 0;
            // No closures here: they would not be compiled for the caller's instruction set.
            while count < STEPS_AT_ONCE && place < places {
                let uv = moved(self.at, self.places, place as usize);
                let wrapped = [
                    along::<N, REPEATS>(probe, &uv[0], self.taps, 0, &self.wrap[0]),
                    along::<N, REPEATS>(probe, &uv[1], self.taps, 1, &self.wrap[1]),
                ];
                fine[count] = corners::<N, REPEATS>(&wrapped, self.levels[0], self.wrap, &self.taps.half);
                if BLENDS {
                    coarse[count] = corners::<N, REPEATS>(&wrapped, self.levels[1], self.wrap, &self.taps.half);
                }
                steps[count] = [place, probe];
                count += 1;
                probe += 1;
                if probe == probes {
                    (place, probe) = (place + 1, 0);
                }
            }
            for i in 0..N {
                let (texels, blend) = (self.texels[i], self.taps.blend[i]);
                let (place_count, probe_count) = (self.counts[0][i], self.counts[1][i]);
                let mut sum = sums[i];
                for step in 0..count {
                    let [place, probe] = steps[step];
                    if (place >= place_count) | (probe >= probe_count) {
                        continue;
                    }
                    let value = fine[step].blended(texels, i);
                    sum += value;
                    if BLENDS && blend > 0.0 {
                        sum += (coarse[step].blended(texels, i) - value) * blend;
                    }
                }
                sums[i] = sum;
            }
        }
        sums
    }
}

/// The places at which each look-up reads its texture; one, in the middle, where the texture shows no detail.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
fn places<const N: usize>(traits: &TextureTraits<N>, at: &TextureLookUps<N>) -> FootprintPlaces<N> {
    let mut extents2 = [0.0; N];
    for i in 0..N {
        let [width, height] = [traits.size[0][i], traits.size[1][i]];
        let (xu, xv, yu, yv) = (at.dx[0][i] * width, at.dx[1][i] * height, at.dy[0][i] * width, at.dy[1][i] * height);
        let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
        extents2[i] = x2.max(y2);
    }
    let mut places = FootprintPlaces { count_log2: [0; N], count: Lanes::splat(1.0), side: Lanes::splat(1.0) };
    for i in 0..N {
        let samples_log2 = at.samples[i].max(1).next_power_of_two().trailing_zeros();
        // Within half a texel a texture is a ramp (or a step, where texels are not blended), within one it has a bend
        // or two.
        let ramp = if traits.magnified_half[i] > 0.0 { 0.3 } else { 0.0 };
        places.count_log2[i] = match extents2[i] {
            extent2 if extent2 < ramp => 0,
            extent2 if extent2 < 1.0 => samples_log2.min(2),
            _ if samples_log2 <= 3 => samples_log2,
            // Sixteen would cost more than they show: four leave a mean FLIP of 0.02 on the finest textures.
            _ => 2,
        };
    }
    for i in 0..N {
        places.count[i] = (1u32 << places.count_log2[i]) as f32;
        places.side[i] = (1.0 / places.count[i]).sqrt();
    }
    places
}

/// The coordinates of a place in the pixel.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
fn moved<const N: usize>(at: &TextureLookUps<N>, places: &FootprintPlaces<N>, place: usize) -> [Lanes<N>; 2] {
    let place = place % MAX_PLACES;
    let offset = PLACES[places.count_log2[0] as usize % PLACES.len()][place];
    let (mut x, mut y) = ([offset.x; N], [offset.y; N]);
    // Neighbours mostly have as many.
    if places.count_log2 != [places.count_log2[0]; N] {
        for i in 0..N {
            let offset = PLACES[places.count_log2[i] as usize % PLACES.len()][place];
            (x[i], y[i]) = (offset.x, offset.y);
        }
    }
    let mut result = at.uv;
    for axis in 0..2 {
        for i in 0..N {
            result[axis][i] += at.dx[axis][i] * x[i] + at.dy[axis][i] * y[i];
        }
    }
    result
}

#[inline(always)]
fn traits<const N: usize>(textures: &[Option<&Texture>; N]) -> TextureTraits<N> {
    let mut traits = TextureTraits {
        size: [Lanes::splat(1.0); 2],
        last_level: Lanes::splat(-1.0),
        nearest_level: Lanes::splat(0.0),
        magnified_half: Lanes::splat(0.5),
        minified_half: Lanes::splat(0.5),
        wrap: [Lanes::splat(1.0); 2],
    };
    let half = |linear: bool| if linear { 0.5 } else { 0.0 };
    let wrap = |wrap: Wrap| match wrap {
        Wrap::ClampToEdge => 0.0,
        Wrap::Repeat => 1.0,
        Wrap::MirroredRepeat => 0.5,
    };
    for (i, texture) in textures.iter().enumerate() {
        let Some(texture) = texture else { continue };
        let sampler = &texture.sampler;
        (traits.size[0][i], traits.size[1][i]) = (texture.levels[0].width as f32, texture.levels[0].height as f32);
        if sampler.mip_filter != MipFilter::None {
            traits.last_level[i] = (texture.levels.len() - 1) as f32;
        }
        traits.nearest_level[i] = if sampler.mip_filter == MipFilter::Nearest { 1.0 } else { 0.0 };
        traits.magnified_half[i] = half(sampler.magnify_linear);
        traits.minified_half[i] = half(sampler.minify_linear);
        (traits.wrap[0][i], traits.wrap[1][i]) = (wrap(sampler.wrap_u), wrap(sampler.wrap_v));
    }
    traits
}

#[inline(always)]
fn taps<const N: usize>(traits: &TextureTraits<N>, at: &TextureLookUps<N>, side: &Lanes<N>) -> Taps<N> {
    let mut taps = Taps {
        probes: Lanes::splat(1.0),
        share: Lanes::splat(1.0),
        step: [Lanes::splat(0.0); 2],
        level: Lanes::splat(0.0),
        blend: Lanes::splat(0.0),
        half: Lanes::splat(0.0),
    };
    // All loads come first and nothing branches, so that the loop becomes vector instructions.
    for i in 0..N {
        let [width, height] = [traits.size[0][i], traits.size[1][i]];
        let side = side[i];
        let (dx_u, dx_v) = (at.dx[0][i] * side, at.dx[1][i] * side);
        let (dy_u, dy_v) = (at.dy[0][i] * side, at.dy[1][i] * side);
        let (last_level, nearest_level) = (traits.last_level[i], traits.nearest_level[i]);
        let (magnified_half, minified_half) = (traits.magnified_half[i], traits.minified_half[i]);
        let (xu, xv, yu, yv) = (dx_u * width, dx_v * height, dy_u * width, dy_v * height);
        let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
        let across = x2 >= y2;
        let major2 = if across { x2 } else { y2 };
        let minor2 = if across { y2 } else { x2 };
        // Footprints that are not a number, infinite or tiny are magnification.
        let minified = (major2 > 1.0) & (major2 < f32::INFINITY);
        let mipped = minified & (last_level >= 0.0);
        let major2 = if mipped { major2 } else { 1.0 };
        let minor2 = if minor2 > 1e-20 { minor2 } else { 1e-20 };
        let ratio2 = major2 / minor2;
        let ratio2 = if ratio2 < MAX_ANISOTROPY * MAX_ANISOTROPY { ratio2 } else { MAX_ANISOTROPY * MAX_ANISOTROPY };
        let ratio2 = if ratio2 < major2 { ratio2 } else { major2 };
        let probes = -floor(-ratio2.sqrt());
        let probes = if probes > 1.0 { probes } else { 1.0 };
        let inverse = 1.0 / probes;
        let level = 0.5 * log2(major2 * inverse * inverse);
        let last = if mipped { last_level } else { 0.0 };
        let level = if level > 0.0 { level } else { 0.0 };
        let level = if level < last { level } else { last };
        // The nearest level is the lower one of a level half a step up.
        let whole = floor(level + 0.5 * nearest_level);
        // The places of four samples and more lie one beside the other along a long axis too: with half as many
        // look-ups at each, all of them together leave no gap.
        let probes = if (side <= 0.5) & (probes > 4.0) { -floor(-0.5 * probes) } else { probes };
        taps.probes[i] = probes;
        taps.share[i] = 1.0 / probes;
        taps.level[i] = whole;
        taps.blend[i] = (level - whole) * (1.0 - nearest_level);
        taps.half[i] = if minified { minified_half } else { magnified_half };
        let (step_u, step_v) = (if across { dx_u } else { dy_u }, if across { dx_v } else { dy_v });
        taps.step[0][i] = if mipped { step_u } else { 0.0 };
        taps.step[1][i] = if mipped { step_v } else { 0.0 };
    }
    taps
}

/// Coordinates of the look-ups along the footprints, brought into 0..1. `REPEATS`: `wrap` is 1 throughout.
#[inline(always)]
fn along<const N: usize, const REPEATS: bool>(
    probe: u32,
    at: &Lanes<N>,
    taps: &Taps<N>,
    axis: usize,
    wrap: &Lanes<N>,
) -> Lanes<N> {
    let mut result = Lanes::splat(0.0);
    for i in 0..N {
        let (at, step, share, wrap) = (at[i], taps.step[axis][i], taps.share[i], wrap[i]);
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
#[derive(Clone, Copy)]
struct Texels<const N: usize> {
    rows: [[u32; N]; 2],
    share: [Lanes<N>; 2],
}

#[inline(always)]
fn corners<const N: usize, const REPEATS: bool>(
    wrapped: &[Lanes<N>; 2],
    levels: &MipLevelLanes<N>,
    wrap: &[Lanes<N>; 2],
    half: &Lanes<N>,
) -> Texels<N> {
    let mut texels = Texels::NONE;
    // All loads come first and nothing branches, so that the loop becomes vector instructions.
    for i in 0..N {
        let [width, height] = [levels.size[0][i], levels.size[1][i]];
        let (first_texel, stride) = (levels.first[i], levels.stride[i]);
        let (wrap_u, wrap_v, half) = (wrap[0][i], wrap[1][i], half[i]);
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
    const NONE: Self = Self { rows: [[0; N]; 2], share: [Lanes::splat(0.0); 2] };

    /// The blend of four texels, 65535 for 1.
    #[inline(always)]
    fn blended(&self, texels: &[[u16; 4]], i: usize) -> Vec4 {
        let (upper, lower) = (pair(texels, self.rows[0][i]), pair(texels, self.rows[1][i]));
        let (x, y) = (self.share[0][i], self.share[1][i]);
        let both: [f32; 8] = std::array::from_fn(|k| upper[k] + (lower[k] - upper[k]) * y);
        let left = Vec4::new(both[0], both[1], both[2], both[3]);
        let right = Vec4::new(both[4], both[5], both[6], both[7]);
        left + (right - left) * x
    }
}

/// A texel and its right neighbour.
#[inline(always)]
fn pair(texels: &[[u16; 4]], first: u32) -> [f32; 8] {
    let first = first as usize;
    match texels.get(first..first + 2).and_then(|pair| pair.as_flattened().first_chunk::<8>()) {
        Some(pair) => pair.map(f32::from),
        None => [0.0; 8],
    }
}

/// 1.5 * 2^23: added to a number within +-2^22, it leaves the number's nearest integer in the lowest bits.
const ROUNDER: f32 = 12_582_912.0;

/// Rounds a number within +-2^22 towards negative infinity. The library's is a call on machines without SSE 4.1.
#[inline(always)]
fn floor(value: f32) -> f32 {
    let rounded = (value + ROUNDER) - ROUNDER;
    if rounded > value { rounded - 1.0 } else { rounded }
}

/// A whole number of at least 0 and below 2^22 as an index.
#[inline(always)]
fn index(value: f32) -> u32 {
    (value + ROUNDER).to_bits() & 0x3f_ffff
}

/// The binary logarithm of a positive, normal number, to 1e-6. The library's is a call.
#[inline(always)]
fn log2(value: f32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let bits = value.to_bits();
    let exponent = (bits.wrapping_sub(SQRT_HALF_BITS) as i32) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub((exponent << 23) as u32));
    // ln m = 2 artanh t.
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let t2 = t * t;
    let series = 1.0 + t2 * (1.0 / 3.0 + t2 * (1.0 / 5.0 + t2 * (1.0 / 7.0 + t2 * (1.0 / 9.0))));
    exponent as f32 + 2.0 * std::f32::consts::LOG2_E * t * series
}

#[cfg(test)]
mod tests;
