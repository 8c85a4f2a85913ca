//! Filtered look-ups in a texture, several at a time: all work but the reading of texels is done for all of them at
//! once.

mod arithmetic;
mod taps;
mod texels;

pub use arithmetic::{floor, index, log2};

use super::texture::Texture;
use crate::math::lanes::Lanes;
use glam::Vec4;
use taps::{FootprintPlaces, Taps, TextureTraits, moved, places, taps};
use texels::{LevelLanes, along, corners};

/// The positions of look-ups: texture coordinates and their change a pixel, along u and v each.
#[derive(Clone, Debug)]
pub struct TextureLookUps<const N: usize> {
    /// The texture coordinates.
    pub uv: [Lanes<N>; 2],
    /// Change with the pixel's column.
    pub dx: [Lanes<N>; 2],
    /// Change with the pixel's row.
    pub dy: [Lanes<N>; 2],
    /// The number of samples of the pixel that a look-up stands for; 0 as 1.
    pub samples: [u32; N],
}

impl<const N: usize> TextureLookUps<N> {
    pub(super) const ZERO: Self =
        Self { uv: [Lanes::ZERO; 2], dx: [Lanes::ZERO; 2], dy: [Lanes::ZERO; 2], samples: [1; N] };
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
