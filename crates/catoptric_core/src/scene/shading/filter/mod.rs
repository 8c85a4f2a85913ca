//! Filtered look-ups in a texture, several at a time: all work but the reading of texels is done for all of them at
//! once.

mod arithmetic;
mod look_ups;
mod taps;
mod texels;

pub use arithmetic::{floor, index, log2};
pub use look_ups::TextureLookUps;

use super::texture::{Texture, UvFootprint};
use crate::math::lanes::Lanes;
use glam::{Vec2, Vec4};
use taps::{FootprintPlaces, Taps, TextureTraits, moved, places, taps};
use texels::{LevelLanes, along, corners};

impl Texture {
    /// The filtered value at `uv` (0..1 over the image, v down) for a footprint of that size.
    ///
    /// Anisotropic footprints take up to eight trilinear look-ups along their longer axis. Where one look-up stands for
    /// several samples of a pixel, the places of the samples are looked up, each with its share of the footprint: what
    /// supersampling would give.
    #[inline]
    pub fn sample(&self, uv: Vec2, footprint: &UvFootprint) -> Vec4 {
        let UvFootprint { dx, dy, samples } = *footprint;
        let [uv, dx, dy] = [uv, dx, dy].map(|pair| pair.to_array().map(Lanes::splat));
        let mut value = [Vec4::ZERO];
        sample(self, &TextureLookUps { uv, dx, dy, samples: [samples] }, 1, &mut value);
        value[0]
    }
}

/// Sets the filtered values of a texture at the first `count` places; white where a place is not finite.
///
/// A look-up that stands for several samples is made at the place of each, with its share of the footprint.
#[cfg_attr(not(debug_assertions), inline(always))]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
pub fn sample<const N: usize>(texture: &Texture, at: &TextureLookUps<N>, count: usize, values: &mut [Vec4; N]) {
    *values = [Vec4::ZERO; N];
    let traits = TextureTraits::new(texture);
    let places = places(&traits, at);
    let taps = taps(&traits, at, &places);
    let look_up = PreparedLookUp { texture, at, places: &places, taps: &taps, wrap: traits.wrap, count };
    let blends = taps.blend.iter().any(|blend| *blend > 0.0);
    match (traits.wrap == [1.0; 2], blends) {
        (true, false) => look_up.sums::<true, false>(values),
        (true, true) => look_up.sums::<true, true>(values),
        (false, _) => look_up.sums::<false, true>(values),
    }
    for i in 0..N {
        let finite = at.uv[0][i].is_finite() && at.uv[1][i].is_finite();
        let share = taps.share[i] / (places.count[i] * 65535.0);
        values[i] = if finite { values[i] * share } else { Vec4::ONE };
    }
}

/// Look-ups with all computed but the texels.
struct PreparedLookUp<'a, const N: usize> {
    texture: &'a Texture,
    at: &'a TextureLookUps<N>,
    places: &'a FootprintPlaces<N>,
    taps: &'a Taps<N>,
    wrap: [f32; 2],
    count: usize,
}

impl<const N: usize> PreparedLookUp<'_, N> {
    /// Adds the sums over all places and probes. `REPEATS`: the texture does; `BLENDS`: some need their coarser level
    /// too.
    #[cfg_attr(not(debug_assertions), inline(always))]
    #[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
    fn sums<const REPEATS: bool, const BLENDS: bool>(&self, sums: &mut [Vec4; N]) {
        let Self { texture, at, places, taps, wrap, count } = *self;
        let (mut fine_levels, mut coarse_levels) = ([0u32; N], [0u32; N]);
        let (mut place_counts, mut probe_counts) = ([0u32; N], [0u32; N]);
        for i in 0..N {
            fine_levels[i] = index(taps.level[i]);
            coarse_levels[i] = fine_levels[i] + 1;
            place_counts[i] = 1 << places.count_log2[i];
            probe_counts[i] = index(taps.probes[i]);
        }
        let most = |counts: &[u32; N]| counts.iter().fold(0, |most, count| most.max(*count));
        let (most_places, most_probes) = (most(&place_counts), most(&probe_counts));
        let fine_levels = LevelLanes::new(texture, &fine_levels);
        let coarse_levels = LevelLanes::new(texture, &coarse_levels);
        let texels = &texture.texels[..];
        for place in 0..most_places {
            let uv = moved(at, places, place as usize);
            for probe in 0..most_probes {
                let wrapped = [
                    along::<N, REPEATS>(probe, &uv[0], taps, 0, wrap[0]),
                    along::<N, REPEATS>(probe, &uv[1], taps, 1, wrap[1]),
                ];
                let fine = corners::<N, REPEATS>(&wrapped, &fine_levels, wrap, &taps.half);
                if BLENDS {
                    let coarse = corners::<N, REPEATS>(&wrapped, &coarse_levels, wrap, &taps.half);
                    for i in 0..count.min(N) {
                        if (place >= place_counts[i]) | (probe >= probe_counts[i]) {
                            continue;
                        }
                        let mut value = fine.blended(texels, i);
                        let blend = taps.blend[i];
                        if blend > 0.0 {
                            value += (coarse.blended(texels, i) - value) * blend;
                        }
                        sums[i] += value;
                    }
                } else {
                    for i in 0..count.min(N) {
                        if (place < place_counts[i]) & (probe < probe_counts[i]) {
                            sums[i] += fine.blended(texels, i);
                        }
                    }
                }
            }
        }
    }
}
