//! Light from infinity: an equirectangular picture, its look-up, and the irradiance that it causes.

mod glossy;
mod lamps;
pub(in crate::scene) mod map;

use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::math::portable::PortableMath;
use glam::{Vec2, Vec3};
use glossy::GlossyMaps;
pub use lamps::{Lamp, Lamps};
use map::{EquirectangularMap, Irradiance, neighbours, reductions};
use std::sync::OnceLock;

/// Light that comes from infinitely far away.
///
/// The picture is equirectangular: its centre lies in direction +x, columns turn from there towards +z to the
/// right, the top row is +y (the convention of the glTF sample viewer).
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// The name of its source, for messages.
    pub name: String,
    pub(in super::super) width: u32,
    pub(in super::super) height: u32,
    /// Linear radiance, rows from the top.
    pub(in super::super) radiance: Vec<[f32; 3]>,
    /// The same at half the width and height, at a quarter, and so on.
    reduced: Vec<EquirectangularMap>,
    irradiance: Irradiance,
    /// Made when a rough surface is first lit.
    glossy: OnceLock<GlossyMaps>,
    /// Made when light is first gathered over a lobe; `None`: there are none.
    lamps: OnceLock<Option<Lamps>>,
}

/// A map of light by direction, for other look-ups than [`Environment`]'s own: an equirectangular picture with a
/// border of its neighbours, one texel wide.
#[derive(Clone, Copy, Debug)]
pub struct LightMap<'a> {
    /// Texels of a row, without the border.
    pub width: usize,
    /// Rows, without the border.
    pub height: usize,
    /// Linear radiance or irradiance, rows from the top: `height + 2` of `width + 2` texels. The fourth number is 0.
    pub texels: &'a [[f32; 4]],
}

/// Columns of a picture that lamps are sought in, at most.
const COLUMNS_FOR_LAMPS: u32 = 2048;

fn light_map(map: &EquirectangularMap) -> LightMap<'_> {
    LightMap { width: map.width, height: map.height, texels: &map.texels }
}

/// The most places at which the picture is read for a pixel.
const MOST_PLACES: f32 = 16.0;

/// The largest change of a direction from pixel to pixel that is taken as it is. Chosen, not measured.
const LARGEST_CHANGE: f32 = 0.25;

/// The largest cone, across, over which radiance is averaged: wider ones reach behind the surface that they leave.
/// Chosen, not measured.
const LARGEST_CONE: f32 = 1.2;

impl Environment {
    /// An environment from linear radiance, rows from the top. Values that are not finite or negative become black.
    ///
    /// `radiance` must hold `width * height` values; missing ones are black.
    pub fn new(name: &str, width: u32, height: u32, mut radiance: Vec<[f32; 3]>) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        radiance.resize(width as usize * height as usize, [0.0; 3]);
        for value in radiance.iter_mut().flatten() {
            // Half floats end at 65504; brighter values are a broken file and would swamp every sum.
            *value = if value.is_finite() { value.clamp(0.0, 1e6) } else { 0.0 };
        }
        let irradiance = Irradiance::new(width, height, &radiance);
        let reduced = reductions(width as usize, height as usize, &radiance);
        let (glossy, lamps) = (OnceLock::new(), OnceLock::new());
        Self { name: name.into(), width, height, radiance, reduced, irradiance, glossy, lamps }
    }

    /// Its small bright parts, if they matter.
    #[inline]
    pub fn lamps(&self) -> Option<&Lamps> {
        let found = || {
            let (level, (width, height, radiance)) = self.picture_within(COLUMNS_FOR_LAMPS);
            Lamps::new(level, width, height, radiance)
        };
        self.lamps.get_or_init(found).as_ref()
    }

    /// Width, height and linear radiance of the picture, rows from the top.
    pub fn picture(&self) -> (u32, u32, &[[f32; 3]]) {
        (self.width, self.height, &self.radiance)
    }

    /// The picture, or the first of its reductions that is no wider than so many columns, and which of them: 0 is the
    /// picture itself.
    pub(in crate::scene) fn picture_within(&self, columns: u32) -> (usize, (u32, u32, Vec<[f32; 3]>)) {
        let fits = |map: &EquirectangularMap| map.width <= columns as usize;
        if self.width <= columns || self.reduced.is_empty() {
            return (0, (self.width, self.height, self.radiance.clone()));
        }
        let index = self.reduced.iter().position(fits).unwrap_or(self.reduced.len() - 1);
        let map = &self.reduced[index];
        let rows = map.texels.chunks_exact(map.width + 2).skip(1).take(map.height);
        let radiance = rows.flat_map(|row| row[1..=map.width].iter().map(|[r, g, b, _]| [*r, *g, *b]));
        (index + 1, (map.width as u32, map.height as u32, radiance.collect()))
    }

    /// The maps of irradiance by normals ([`Self::irradiance`]) and of radiance over highlights ([`Self::glossy`]), for
    /// alpha 1, 1/2, 1/4 to 1/64; these are made if they are not there yet.
    pub fn light_maps(&self) -> Vec<LightMap<'_>> {
        let glossy = self.glossy.get_or_init(|| GlossyMaps::new(self));
        std::iter::once(&self.irradiance.0).chain(glossy.levels()).map(light_map).collect()
    }

    /// The picture's radiance at half its width and height, at a quarter, and so on ([`Self::radiance_over`] reads
    /// these); none of small pictures.
    pub fn reductions(&self) -> impl ExactSizeIterator<Item = LightMap<'_>> {
        self.reduced.iter().map(light_map)
    }

    /// The direction (unit length) that a position in the picture (0..1, v down) stands for.
    #[inline]
    pub fn direction(u: f32, v: f32) -> Vec3 {
        map::direction(u, v)
    }

    /// The position in the picture (0..1, v down) of a direction of unit length.
    #[inline(always)] // for the instructions of its caller
    pub fn position(direction: Vec3) -> Vec2 {
        let azimuth = arc_tangent(direction.z, direction.x);
        let polar = arc_tangent((direction.x * direction.x + direction.z * direction.z).sqrt(), direction.y);
        Vec2::new(azimuth * (1.0 / std::f32::consts::TAU) + 0.5, polar * std::f32::consts::FRAC_1_PI)
    }

    /// The same of several directions, along u and v each.
    #[inline(always)] // for the instructions of its caller
    #[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
    pub(super) fn positions<const N: usize>(directions: &Vec3Lanes<N>) -> [Lanes<N>; 2] {
        let mut positions = [Lanes::ZERO; 2];
        for i in 0..N {
            let [x, y, z] = [directions[0][i], directions[1][i], directions[2][i]];
            positions[0][i] = arc_tangent(z, x) * (1.0 / std::f32::consts::TAU) + 0.5;
            positions[1][i] = arc_tangent((x * x + z * z).sqrt(), y) * std::f32::consts::FRAC_1_PI;
        }
        positions
    }

    /// The radiance from a direction (unit length), bilinear between texels.
    #[inline(always)] // for the instructions of its caller
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        bilinear(&self.radiance, self.width as usize, self.height as usize, Self::position(direction))
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
        self.at_level(Self::position(direction), self.level_of(across).min(self.reduced.len() as f32))
    }

    /// [`Self::radiance_within`] of which lamps' light has this share, between 0 and 1.
    #[inline]
    pub fn radiance_within_beside(&self, lamps: &Lamps, direction: Vec3, across: f32, share_of_lamps: f32) -> Vec3 {
        let (position, level) = (Self::position(direction), self.level_of(across).min(self.reduced.len() as f32));
        let all = self.at_level(position, level);
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
        let texels_per_radian = self.width as f32 * (1.0 / std::f32::consts::TAU);
        let texels = across.min(LARGEST_CONE) * (texels_per_radian / SMOOTHING);
        let texels = if texels > 1.0 { texels } else { 1.0 };
        // The logarithm's whole part and, nearly linear between powers of two, the rest.
        let bits = texels.to_bits();
        let mantissa = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
        ((bits >> 23) as i32 - 127) as f32 + (mantissa - 1.0)
    }

    #[inline(always)]
    fn mean_radiance(&self, direction: Vec3, change: [Vec3; 2]) -> Vec3 {
        let texels_per_radian = self.width as f32 * (1.0 / std::f32::consts::TAU);
        let [dx, dy] = change.map(|change| change.length() * texels_per_radian);
        let across = if dx >= dy { 0 } else { 1 };
        let (long, short) = (dx.max(dy), dx.min(dy));
        // Within half a texel the picture is a ramp; what is not a number is read as one place.
        if dx.is_nan() || dy.is_nan() || long < 0.5 {
            return self.radiance(direction);
        }
        // Places follow each other along the longer side, every second one nearer to one end of the shorter side.
        let places = (2.0 * long / short.max(0.5)).clamp(4.0, MOST_PLACES).ceil();
        let level = (0.5 * short).max(long / places).max(1.0).logarithm2().min(self.reduced.len() as f32);
        let mut sum = Vec3::ZERO;
        for place in 0..places as u32 {
            let along = (place as f32 + 0.5) / places - 0.5;
            let aside = if place % 2 == 0 { -0.25 } else { 0.25 };
            let step = change[across] * along + change[1 - across] * aside;
            let towards = (direction + step).try_normalize().unwrap_or(direction);
            sum += self.at_level(Self::position(towards), level);
        }
        sum * (1.0 / places)
    }

    /// The radiance at a position, blended between two reductions.
    #[inline(always)]
    fn at_level(&self, position: Vec2, level: f32) -> Vec3 {
        let whole = level as usize;
        let (fine, share) = (self.at_whole_level(position, whole), level - whole as f32);
        if share > 0.0 { fine + (self.at_whole_level(position, whole + 1) - fine) * share } else { fine }
    }

    /// The radiance at a position of a reduction; 0: the picture as it is.
    #[inline(always)]
    fn at_whole_level(&self, position: Vec2, level: usize) -> Vec3 {
        if level == 0 || self.reduced.is_empty() {
            return bilinear(&self.radiance, self.width as usize, self.height as usize, position);
        }
        self.reduced[(level - 1).min(self.reduced.len() - 1)].at(position)
    }

    /// The mean radiance over the highlight of a rough surface around a direction (unit length): what facets that
    /// reflect all light send to a viewer along the normal, over what they would send of white light (the first part
    /// of Karis 2013's split sum). `alpha` is the square of the perceptual roughness.
    ///
    /// The first call makes the maps that it reads; [`Self::prepare_glossy`] does so beforehand.
    #[inline(always)] // for the instructions of its caller
    pub fn glossy(&self, direction: Vec3, alpha: f32) -> Vec3 {
        self.glossy_at(Self::position(direction), alpha)
    }

    /// The same at a position in the picture.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn glossy_at(&self, position: Vec2, alpha: f32) -> Vec3 {
        self.glossy.get_or_init(|| GlossyMaps::new(self)).radiance(self, position, alpha)
    }

    /// Makes the maps of [`Self::glossy`], on all cores, if they are not there yet.
    pub fn prepare_glossy(&self) {
        self.glossy.get_or_init(|| GlossyMaps::new(self));
    }

    /// The irradiance on a surface with this unit normal: radiance times cosine over the hemisphere.
    #[inline(always)] // for the instructions of its caller
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.irradiance_at(Self::position(normal))
    }

    /// The same at a position in the picture.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn irradiance_at(&self, position: Vec2) -> Vec3 {
        self.irradiance.at(position)
    }
}

/// Of the arc tangent over its argument, by powers of the argument's square: a least-squares fit at Chebyshev's points.
const ARC_TANGENT: [f32; 7] = [0.99999565, -0.33316, 0.19796892, -0.13195902, 0.07899983, -0.03310525, 0.0066582896];

/// The angle of a point from the first axis, to 2e-6: several times faster than the library's.
#[inline(always)]
fn arc_tangent(y: f32, x: f32) -> f32 {
    // Without the library's `max` and `min`, which are no single instructions.
    let (x_size, y_size) = (x.abs(), y.abs());
    let is_steep = y_size > x_size;
    let (long, short) = if is_steep { (y_size, x_size) } else { (x_size, y_size) };
    let ratio = short / if long > f32::MIN_POSITIVE { long } else { f32::MIN_POSITIVE };
    let square = ratio * ratio;
    let mut series = 0.0;
    for coefficient in ARC_TANGENT.iter().rev() {
        series = series * square + coefficient;
    }
    let angle = ratio * series;
    let angle = if is_steep { std::f32::consts::FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { std::f32::consts::PI - angle } else { angle };
    if y < 0.0 { -angle } else { angle }
}

/// The value of a picture at a position, between four texels. Without closures: they would not be compiled for the
/// instructions of the caller.
#[inline(always)]
fn bilinear(texels: &[[f32; 3]], width: usize, height: usize, position: Vec2) -> Vec3 {
    let (x, y) = (position.x * width as f32 - 0.5, position.y * height as f32 - 0.5);
    let (left, top) = (floor(x), floor(y));
    let (fx, fy) = (x - left as f32, y - top as f32);
    let [upper_left, upper_right] = neighbours(texels, width, height, left, top);
    let [lower_left, lower_right] = neighbours(texels, width, height, left, top + 1);
    let upper = upper_left * (1.0 - fx) + upper_right * fx;
    let lower = lower_left * (1.0 - fx) + lower_right * fx;
    (upper * (1.0 - fy) + lower * fy).truncate()
}

/// The largest whole number that is not above: machines without an instruction for it call a function.
#[inline(always)]
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    whole - i32::from(value < whole as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_sky_gives_pi_times_its_radiance() {
        let sky = Environment::new("white", 64, 32, vec![[1.0; 3]; 64 * 32]);
        for normal in [Vec3::X, Vec3::Y, Vec3::NEG_Z, Vec3::ONE.normalize()] {
            assert!((sky.irradiance(normal).x - std::f32::consts::PI).abs() < 0.01);
            assert_eq!(sky.radiance(normal), Vec3::ONE);
        }
    }

    #[test]
    fn level_floors_under_a_low_sun_look_alike_from_all_sides() {
        // A sun of a few degrees at a height of 20 degrees: the irradiance of a level floor is its energy times sin 20.
        let (width, height) = (256u32, 128u32);
        for column in [128u32, 200, 64, 0, 30] {
            let row = (70.0 / 180.0 * height as f32) as u32;
            let mut radiance = vec![[0.0; 3]; (width * height) as usize];
            radiance[(row * width + column) as usize] = [1e5; 3];
            let sky = Environment::new("sun", width, height, radiance);
            let polar = |edge: u32| (edge as f32 / height as f32 * std::f32::consts::PI).cos();
            let energy = 1e5 * std::f32::consts::TAU / width as f32 * (polar(row) - polar(row + 1));
            let towards =
                Environment::direction((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32);
            let found = sky.irradiance(Vec3::Y).x;
            assert!((found / (energy * towards.y) - 1.0).abs() < 0.01, "{column}: {found} for {}", energy * towards.y);
        }
    }

    #[test]
    fn angles_are_right_all_round() {
        for step in 0..10_000 {
            let angle = (step as f32 + 0.5) / 10_000.0 * std::f32::consts::TAU - std::f32::consts::PI;
            let found = arc_tangent(3.0 * angle.sin(), 3.0 * angle.cos());
            assert!((found - angle).abs() < 2e-6, "{found} for {angle}");
        }
        assert!(arc_tangent(0.0, 0.0).is_finite());
    }

    #[test]
    fn positions_and_directions_are_inverse() {
        for (u, v) in [(0.5, 0.5), (0.75, 0.5), (0.1, 0.2), (0.99, 0.9)] {
            let position = Environment::position(Environment::direction(u, v));
            assert!((position - Vec2::new(u, v)).length() < 1e-5);
        }
        assert!((Environment::direction(0.5, 0.5) - Vec3::X).length() < 1e-6);
        assert!((Environment::direction(0.75, 0.5) - Vec3::Z).length() < 1e-6);
    }

    #[test]
    fn means_over_pixels_are_those_of_many_directions() {
        // A picture of blocks of very different brightness, 4 x 4 texels each.
        let (width, height) = (256u32, 128u32);
        let texel = |index: u32| (index % width / 4 * 37 + index / width / 4 * 61) % 17;
        let radiance = (0..width * height).map(|index| [texel(index) as f32, 1.0, 0.0]).collect();
        let sky = Environment::new("blocks", width, height, radiance);
        let mut random = crate::math::random::Stream::new(5);
        let mut worst = 0.0f32;
        for size_texels in [0.3, 1.0, 3.0, 12.0, 40.0] {
            let mut squares = 0.0;
            for _ in 0..200 {
                let mut number = || random.next_between(-1.0, 1.0);
                let direction = Vec3::new(number(), 0.7 * number(), number()).normalize_or(Vec3::X);
                let across = direction.any_orthonormal_vector();
                let size = size_texels * std::f32::consts::TAU / width as f32;
                let change = [across * size, direction.cross(across) * size * 0.7];
                let mut sum = Vec3::ZERO;
                for place in 0..1024 {
                    let (x, y) = ((place % 32) as f32 / 32.0 - 0.484_375, (place / 32) as f32 / 32.0 - 0.484_375);
                    sum += sky.radiance((direction + change[0] * x + change[1] * y).normalize());
                }
                let found = sky.radiance_over(direction, change);
                squares += (found.x - sum.x / 1024.0).powi(2);
                assert!((found.y - 1.0).abs() < 1e-4 && found.z == 0.0, "{found}");
            }
            worst = worst.max((squares / 200.0).sqrt());
        }
        // One direction alone is off by 4.9, the spread of the blocks, at the largest size.
        assert!(worst < 1.2, "{worst}");
        assert!(sky.radiance_over(Vec3::Y, [Vec3::NAN, Vec3::X]).is_finite());
        assert!(sky.radiance_over(Vec3::Y, [Vec3::splat(1e30), Vec3::X]).is_finite());
    }

    #[test]
    fn broken_values_become_black() {
        let sky = Environment::new("broken", 2, 1, vec![[f32::NAN, f32::INFINITY, -3.0]; 2]);
        assert_eq!(sky.radiance(Vec3::X), Vec3::ZERO);
    }

    /// What lamps have, the rest lacks: a surface is lit by both as by the whole.
    #[test]
    fn lamps_and_the_rest_are_all_light() {
        let (width, height) = (128usize, 64usize);
        let radiance: Vec<[f32; 3]> = (0..width * height)
            .map(|index| {
                if (30..34).contains(&(index % width)) && (10..14).contains(&(index / width)) {
                    [300.0, 200.0, 100.0]
                } else {
                    [0.5; 3]
                }
            })
            .collect();
        let environment = Environment::new("lit", width as u32, height as u32, radiance);
        let lamps = environment.lamps().expect("a lamp");
        let towards = Environment::direction(32.0 / width as f32, 12.0 / height as f32);
        assert!(lamps.all().iter().all(|lamp| lamp.towards.dot(towards) > 0.99));
        let irradiance: Vec3 = lamps.all().iter().map(|lamp| lamp.light * lamp.towards.dot(towards)).sum();
        let mut of_rest = Vec3::ZERO;
        for row in 0..height {
            for column in 0..width {
                let [u, v] = [(column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32];
                let direction = Environment::direction(u, v);
                let area = std::f32::consts::TAU / width as f32 * std::f32::consts::PI / height as f32;
                let solid_angle = area * (v * std::f32::consts::PI).sine();
                let rest = environment.radiance_within_beside(lamps, direction, 0.0, 0.0);
                of_rest += rest * (direction.dot(towards).max(0.0) * solid_angle);
            }
        }
        let all = environment.irradiance(towards);
        assert!((irradiance + of_rest - all).length() < 0.02 * all.length(), "{irradiance} + {of_rest}, {all}");
        assert!(irradiance.length() > 0.5 * all.length());
        assert!(Environment::new("even", 64, 32, vec![[2.0; 3]; 64 * 32]).lamps().is_none());
    }
}
