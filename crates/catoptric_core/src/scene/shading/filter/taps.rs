//! Where in a pixel and on which mip levels look-ups read their texture.

use super::super::sample_patterns::SAMPLE_PATTERNS;
use super::super::texture::{MipFilter, Texture, Wrap};
use super::arithmetic::{floor, log2};
use super::look_ups::TextureLookUps;
use crate::math::lanes::Lanes;
use glam::Vec2;

/// The largest ratio of the footprint's axes that is resolved by several look-ups; beyond it the result is blurred.
const MAX_ANISOTROPY: f32 = 8.0;

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

/// Properties of a texture for its look-ups.
pub(super) struct TextureTraits {
    /// The size of the finest level, in texels.
    size: [f32; 2],
    /// The index of the coarsest level; below 0 where levels are not used.
    last_level: f32,
    /// 1 where the nearest level is taken, not a blend of two.
    nearest_level: f32,
    /// Half a texel where texels are blended, when magnified and when minified.
    magnified_half: f32,
    minified_half: f32,
    /// The wrapping of coordinates: 0 clamped, 1 repeated, 0.5 mirrored.
    pub(super) wrap: [f32; 2],
}

impl TextureTraits {
    #[inline(always)]
    pub(super) fn new(texture: &Texture) -> Self {
        let half = |linear: bool| if linear { 0.5 } else { 0.0 };
        let wrap = |wrap: Wrap| match wrap {
            Wrap::ClampToEdge => 0.0,
            Wrap::Repeat => 1.0,
            Wrap::MirroredRepeat => 0.5,
        };
        let sampler = &texture.sampler;
        let uses_levels = sampler.mip_filter != MipFilter::None;
        Self {
            size: texture.levels[0].size,
            last_level: if uses_levels { (texture.levels.len() - 1) as f32 } else { -1.0 },
            nearest_level: if sampler.mip_filter == MipFilter::Nearest { 1.0 } else { 0.0 },
            magnified_half: half(sampler.magnify_linear),
            minified_half: half(sampler.minify_linear),
            wrap: [wrap(sampler.wrap_u), wrap(sampler.wrap_v)],
        }
    }
}

/// The places in a pixel at which each look-up reads its texture: those of a pattern of samples.
pub(super) struct FootprintPlaces<const N: usize> {
    /// The binary logarithm of how many there are, how many there are, and the side of the square that each stands
    /// for, in pixels.
    pub(super) count_log2: [u32; N],
    pub(super) count: Lanes<N>,
    side: Lanes<N>,
}

/// The places at which each look-up reads its texture; one, in the middle, where the texture shows no detail.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
pub(super) fn places<const N: usize>(traits: &TextureTraits, at: &TextureLookUps<N>) -> FootprintPlaces<N> {
    let [width, height] = traits.size;
    // Within half a texel a texture is a ramp (or a step, where texels are not blended), within one it has a bend
    // or two.
    let ramp = if traits.magnified_half > 0.0 { 0.3 } else { 0.0 };
    let mut places = FootprintPlaces { count_log2: [0; N], count: Lanes::splat(1.0), side: Lanes::splat(1.0) };
    for i in 0..N {
        let (xu, xv, yu, yv) = (at.dx[0][i] * width, at.dx[1][i] * height, at.dy[0][i] * width, at.dy[1][i] * height);
        let (x2, y2) = (xu * xu + xv * xv, yu * yu + yv * yv);
        let extent2 = if x2 > y2 { x2 } else { y2 };
        // The binary logarithm of a power of two that is not smaller than the number of samples.
        let samples = at.samples[i];
        let samples_log2 = u32::from(samples > 1) + u32::from(samples > 2) + u32::from(samples > 4);
        // Sixteen would cost more than they show: four leave a mean FLIP of 0.02 on the finest textures.
        let samples_log2 = if samples > 8 { 2 } else { samples_log2 };
        let few = if samples_log2 < 2 { samples_log2 } else { 2 };
        let places_log2 = if extent2 < 1.0 { few } else { samples_log2 };
        let places_log2 = if extent2 < ramp { 0 } else { places_log2 };
        let count = (1u32 << places_log2) as f32;
        places.count_log2[i] = places_log2;
        places.count[i] = count;
        places.side[i] = (1.0 / count).sqrt();
    }
    places
}

/// The coordinates of a place in the pixel.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
pub(super) fn moved<const N: usize>(
    at: &TextureLookUps<N>,
    places: &FootprintPlaces<N>,
    place: usize,
) -> [Lanes<N>; 2] {
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
    let mut result = [Lanes::splat(0.0); 2];
    for axis in 0..2 {
        for i in 0..N {
            result[axis][i] = at.uv[axis][i] + (at.dx[axis][i] * x[i] + at.dy[axis][i] * y[i]);
        }
    }
    result
}

/// The texels and levels that each look-up reads.
pub(super) struct Taps<const N: usize> {
    /// Look-ups along the footprint's longer axis, and 1 over them.
    pub(super) probes: Lanes<N>,
    pub(super) share: Lanes<N>,
    /// The footprint's longer axis.
    pub(super) step: [Lanes<N>; 2],
    /// The finer level's index, and the share of the coarser one.
    pub(super) level: Lanes<N>,
    pub(super) blend: Lanes<N>,
    /// Half a texel where texels are blended, else 0.
    pub(super) half: Lanes<N>,
}

#[inline(always)]
pub(super) fn taps<const N: usize>(
    traits: &TextureTraits,
    at: &TextureLookUps<N>,
    places: &FootprintPlaces<N>,
) -> Taps<N> {
    let zero = Lanes::splat(0.0);
    let mut taps = Taps { probes: zero, share: zero, step: [zero; 2], level: zero, blend: zero, half: zero };
    let [width, height] = traits.size;
    let (last_level, nearest_level) = (traits.last_level, traits.nearest_level);
    let (magnified_half, minified_half) = (traits.magnified_half, traits.minified_half);
    // All loads come first and nothing branches, so that the loop becomes vector instructions.
    for i in 0..N {
        let side = places.side[i];
        let (dx_u, dx_v) = (at.dx[0][i] * side, at.dx[1][i] * side);
        let (dy_u, dy_v) = (at.dy[0][i] * side, at.dy[1][i] * side);
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
