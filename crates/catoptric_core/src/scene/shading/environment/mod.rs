//! Light from infinity: an equirectangular picture, its look-up, and the irradiance that it causes.

mod glossy;
mod lamps;
pub(in crate::scene) mod map;
mod picture;

use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::math::portable::PortableMath;
use glam::{Vec2, Vec3};
use glossy::GlossyMaps;
pub use lamps::{Lamp, Lamps};
pub use map::LightMap;
use map::{EquirectangularMap, Irradiance};
use picture::Picture;
use std::sync::OnceLock;

/// Light that comes from infinitely far away.
///
/// The picture is equirectangular: its centre lies in direction +x, columns turn from there towards +z to the
/// right, the top row is +y (the convention of the glTF sample viewer). [`Self::turned`] turns it about the y axis:
/// directions are turned where the picture is looked up, which stays as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The name of its source, for messages.
    pub name: String,
    pub(in crate::scene) picture: Picture,
    /// How far directions are turned before they are looked up.
    turn: Turn,
    irradiance: Irradiance,
    /// Made when a rough surface is first lit.
    glossy: OnceLock<GlossyMaps>,
    /// Made when light is first gathered over a lobe; `None`: there are none.
    lamps: OnceLock<Option<Lamps>>,
}

/// Columns of a picture that lamps are sought in, at most.
const COLUMNS_FOR_LAMPS: u32 = 2048;

/// The most places at which the picture is read for a pixel.
const MOST_PLACES: f32 = 16.0;

/// The largest change of a direction from pixel to pixel that is taken as it is. Chosen, not measured.
const LARGEST_CHANGE: f32 = 0.25;

/// The largest cone, across, over which radiance is averaged: wider ones reach behind the surface that they leave.
/// Chosen, not measured.
const LARGEST_CONE: f32 = 1.2;

impl Environment {
    /// An environment from linear radiance, rows from the top, each value as [`Self::kept`] keeps it.
    ///
    /// `radiance` must hold `width * height` values; missing ones are black.
    pub fn new(name: &str, width: u32, height: u32, mut radiance: Vec<[f32; 3]>) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        radiance.resize(width as usize * height as usize, [0.0; 3]);
        for value in radiance.iter_mut().flatten() {
            *value = Self::kept(*value);
        }
        let irradiance = Irradiance::new(width, height, &radiance);
        let picture = Picture::new(width, height, radiance);
        let (glossy, lamps) = (OnceLock::new(), OnceLock::new());
        Self { name: name.into(), picture, turn: Turn::NONE, irradiance, glossy, lamps }
    }

    /// A value of linear radiance as environments keep it: the infinite one is 65504, where half floats end (suns that
    /// overflowed are written so), one above a million is that, as more would swamp every sum; no number and negative
    /// ones are 0.
    pub fn kept(radiance: f32) -> f32 {
        match radiance {
            f32::INFINITY => 65504.0,
            radiance if radiance > 0.0 => radiance.min(1e6),
            _ => 0.0,
        }
    }

    /// The environment turned by so many radians about the y axis, counter-clockwise seen from above (from +y). Exact:
    /// the picture stays as it is.
    pub fn turned(mut self, angle: f64) -> Self {
        self.turn = self.turn.and(angle);
        (self.glossy, self.lamps) = (OnceLock::new(), OnceLock::new());
        self
    }

    /// The environment with all its light times a factor, which is 0 or more.
    pub fn scaled(mut self, factor: f32) -> Self {
        let maps = self.picture.reduced.iter_mut().chain([&mut self.irradiance.0]).flat_map(|map| &mut map.texels);
        maps.flatten().chain(self.picture.radiance.iter_mut().flatten()).for_each(|value| *value *= factor);
        (self.glossy, self.lamps) = (OnceLock::new(), OnceLock::new());
        self
    }

    /// How far it is turned about the y axis, counter-clockwise seen from above, in whole turns: 0 to 1. The position
    /// of a direction in the picture lies further right by so much of its width.
    pub fn turn(&self) -> f32 {
        self.turn.share
    }

    /// A direction in the scene from one in the picture.
    #[inline]
    pub(in super::super) fn scene_from_picture(&self, direction: Vec3) -> Vec3 {
        self.turn.of(direction)
    }

    /// The environment's small bright parts, if they matter.
    #[inline]
    pub fn lamps(&self) -> Option<&Lamps> {
        let found = || {
            let (level, (width, height, radiance)) = self.picture.within(COLUMNS_FOR_LAMPS);
            Lamps::new(level, width, height, radiance).map(|lamps| lamps.turned(|towards| self.turn.of(towards)))
        };
        self.lamps.get_or_init(found).as_ref()
    }

    /// Width, height and linear radiance of the picture, rows from the top.
    pub fn picture(&self) -> (u32, u32, &[[f32; 3]]) {
        (self.picture.width, self.picture.height, &self.picture.radiance)
    }

    /// The maps of irradiance by normals ([`Self::irradiance`]) and of radiance over highlights ([`Self::glossy`]), for
    /// alpha 1, 1/2, 1/4 to 1/64; these are made if they are not there yet.
    pub fn light_maps(&self) -> Vec<LightMap<'_>> {
        let glossy = self.glossy.get_or_init(|| GlossyMaps::new(&self.picture));
        std::iter::once(&self.irradiance.0).chain(glossy.levels()).map(EquirectangularMap::light_map).collect()
    }

    /// The picture's radiance at half its width and height, at a quarter, and so on ([`Self::radiance_over`] reads
    /// these); none of small pictures.
    pub fn reductions(&self) -> impl ExactSizeIterator<Item = LightMap<'_>> {
        self.picture.reduced.iter().map(EquirectangularMap::light_map)
    }

    /// The direction (unit length) that a position in a picture that is not turned (0..1, v down) stands for.
    #[inline]
    pub fn direction(u: f32, v: f32) -> Vec3 {
        map::direction(u, v)
    }

    /// The position in this picture (0..1, v down) of a direction of unit length.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn place(&self, direction: Vec3) -> Vec2 {
        let Vec2 { x, y } = map::position(direction);
        Vec2::new(self.turn.further(x), y)
    }

    /// The same of several directions, along u and v each.
    #[inline(always)] // for the instructions of its caller
    #[allow(clippy::needless_range_loop)] // lanes, for the vectoriser
    pub(super) fn places<const N: usize>(&self, directions: &Vec3Lanes<N>) -> [Lanes<N>; 2] {
        let mut positions = map::positions(directions);
        for i in 0..N {
            positions[0][i] = self.turn.further(positions[0][i]);
        }
        positions
    }

    /// The position in a picture that is not turned (0..1, v down) of a direction of unit length.
    #[inline(always)] // for the instructions of its caller
    pub fn position(direction: Vec3) -> Vec2 {
        map::position(direction)
    }

    /// The radiance from a direction (unit length), bilinear between texels.
    #[inline(always)] // for the instructions of its caller
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.picture.at_whole_level(self.place(direction), 0)
    }

    /// The mean radiance over a pixel: from a direction (unit length) that changes so much from pixel to pixel, along
    /// columns and rows. What supersampling gives, but for a blur of about half the pixel's short side.
    #[inline]
    pub fn radiance_over(&self, direction: Vec3, change: [Vec3; 2]) -> Vec3 {
        // Larger changes say little of what lies half a pixel away.
        self.mean_radiance(direction, change.map(|change| change.clamp_length_max(LARGEST_CHANGE)))
    }

    /// The mean radiance over a cone about a direction (unit length), by the angles across it.
    #[inline]
    pub fn radiance_of_cone(&self, direction: Vec3, across: [Vec3; 2]) -> Vec3 {
        let [wide, narrow] = across.map(|across| across.length_squared());
        let (narrow, wide) = (narrow.min(wide), narrow.max(wide));
        if narrow > 0.5 * wide && wide.is_finite() {
            return self.radiance_within(direction, (narrow * wide).sqrt().sqrt());
        }
        self.mean_radiance(direction, across.map(|across| across.clamp_length_max(LARGEST_CONE)))
    }

    /// The same within an angle across, on all sides of the direction.
    #[inline]
    pub fn radiance_within(&self, direction: Vec3, across: f32) -> Vec3 {
        self.picture.at_level(self.place(direction), self.level_of(across).min(self.picture.reduced.len() as f32))
    }

    /// [`Self::radiance_within`] of which lamps' light has this share, between 0 and 1.
    #[inline]
    pub fn radiance_within_beside(&self, lamps: &Lamps, direction: Vec3, across: f32, share_of_lamps: f32) -> Vec3 {
        let (position, level) = (self.place(direction), self.level_of(across).min(self.picture.reduced.len() as f32));
        let all = self.picture.at_level(position, level);
        if share_of_lamps >= 1.0 {
            return all;
        }
        let rest = lamps.rest_at(position, level);
        rest + (all - rest).max(Vec3::ZERO) * share_of_lamps
    }

    /// The reduction whose texels are as wide as an angle; 0: the picture itself.
    #[inline(always)]
    fn level_of(&self, across: f32) -> f32 {
        // Between texels of a reduction the picture is as smooth as over a cone that is wider by this factor.
        const SMOOTHING: f32 = 1.732;
        let texels_per_radian = self.picture.width as f32 * (1.0 / std::f32::consts::TAU);
        let texels = across.min(LARGEST_CONE) * (texels_per_radian / SMOOTHING);
        let texels = if texels > 1.0 { texels } else { 1.0 };
        // The logarithm's whole part and, nearly linear between powers of two, the rest.
        let bits = texels.to_bits();
        let mantissa = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
        ((bits >> 23) as i32 - 127) as f32 + (mantissa - 1.0)
    }

    #[inline(always)]
    fn mean_radiance(&self, direction: Vec3, change: [Vec3; 2]) -> Vec3 {
        let texels_per_radian = self.picture.width as f32 * (1.0 / std::f32::consts::TAU);
        let [dx, dy] = change.map(|change| change.length() * texels_per_radian);
        let across = if dx >= dy { 0 } else { 1 };
        let (long, short) = (dx.max(dy), dx.min(dy));
        // Within half a texel the picture is a ramp; what is not a number is read as one place.
        if dx.is_nan() || dy.is_nan() || long < 0.5 {
            return self.radiance(direction);
        }
        // Places follow each other along the longer side, every second one nearer to one end of the shorter side.
        let places = (2.0 * long / short.max(0.5)).clamp(4.0, MOST_PLACES).ceil();
        let level = (0.5 * short).max(long / places).max(1.0).logarithm2().min(self.picture.reduced.len() as f32);
        let mut sum = Vec3::ZERO;
        for place in 0..places as u32 {
            let along = (place as f32 + 0.5) / places - 0.5;
            let aside = if place % 2 == 0 { -0.25 } else { 0.25 };
            let step = change[across] * along + change[1 - across] * aside;
            let towards = (direction + step).try_normalize().unwrap_or(direction);
            sum += self.picture.at_level(self.place(towards), level);
        }
        sum * (1.0 / places)
    }

    /// The mean radiance over the highlight of a rough surface around a direction (unit length): what facets that
    /// reflect all light send to a viewer along the normal, over what they would send of white light (the first part
    /// of Karis 2013's split sum). `alpha` is the square of the perceptual roughness.
    ///
    /// The first call makes the maps that it reads; [`Self::prepare_glossy`] does so beforehand.
    #[inline(always)] // for the instructions of its caller
    pub fn glossy(&self, direction: Vec3, alpha: f32) -> Vec3 {
        self.glossy_at(self.place(direction), alpha)
    }

    /// The same at a position in the picture.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn glossy_at(&self, position: Vec2, alpha: f32) -> Vec3 {
        self.glossy.get_or_init(|| GlossyMaps::new(&self.picture)).radiance(&self.picture, position, alpha)
    }

    /// Makes the maps of [`Self::glossy`], on all cores, if they are not there yet.
    pub fn prepare_glossy(&self) {
        self.glossy.get_or_init(|| GlossyMaps::new(&self.picture));
    }

    /// The irradiance on a surface with this unit normal: radiance times cosine over the hemisphere.
    #[inline(always)] // for the instructions of its caller
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.irradiance_at(self.place(normal))
    }

    /// The same at a position in the picture.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn irradiance_at(&self, position: Vec2) -> Vec3 {
        self.irradiance.at(position)
    }
}

/// A turn about the y axis, counter-clockwise seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    /// In radians, as it was asked for.
    angle: f64,
    /// In whole turns, 0 to 1.
    share: f32,
    /// The sine and cosine of the turn.
    direction: [f32; 2],
}

impl Turn {
    const NONE: Self = Self { angle: 0.0, share: 0.0, direction: [0.0, 1.0] };

    /// This turn and another one after it, in radians.
    fn and(self, angle: f64) -> Self {
        let angle = self.angle + angle;
        let share = (angle / std::f64::consts::TAU).rem_euclid(1.0);
        let (sine, cosine) = (share * std::f64::consts::TAU).sine_cosine();
        // Rounding may make a whole turn of nearly one.
        let share = if share as f32 >= 1.0 { 0.0 } else { share as f32 };
        Self { angle, share, direction: [sine as f32, cosine as f32] }
    }

    /// A direction, turned.
    #[inline]
    fn of(self, Vec3 { x, y, z }: Vec3) -> Vec3 {
        let [sine, cosine] = self.direction;
        if self.share == 0.0 { Vec3::new(x, y, z) } else { Vec3::new(x * cosine + z * sine, y, z * cosine - x * sine) }
    }

    /// A position along the rows of a picture (0 to 1) further right by this turn.
    #[inline(always)] // for the instructions of its caller
    fn further(self, position: f32) -> f32 {
        let further = position + self.share;
        if further > 1.0 { further - 1.0 } else { further }
    }
}
