//! Light from infinity: an equirectangular picture, its look-up, and the irradiance that it causes.

mod glossy;

use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::math::portable::PortableMath;
use glam::{Vec2, Vec3, Vec4};
use glossy::GlossyMaps;
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
    irradiance: EquirectangularMap,
    /// Made when a rough surface is first lit.
    glossy: OnceLock<GlossyMaps>,
}

/// Radiance by direction for fast look-ups: the fourth number is zero, so that one load reads all, and around the
/// picture stands a border of its neighbours.
#[derive(Clone, Debug, PartialEq)]
struct EquirectangularMap {
    width: usize,
    height: usize,
    /// Rows from the top, of two more than `width`; two more than `height` of them.
    texels: Vec<[f32; 4]>,
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

impl EquirectangularMap {
    fn light_map(&self) -> LightMap<'_> {
        LightMap { width: self.width, height: self.height, texels: &self.texels }
    }

    fn new(width: usize, height: usize, radiance: &[[f32; 4]]) -> Self {
        let mut texels = Vec::with_capacity((width + 2) * (height + 2));
        for row in -1..=height as i32 {
            for column in -1..=width as i32 {
                texels.push(neighbours(radiance, width, height, column, row)[0].to_array());
            }
        }
        Self { width, height, texels }
    }

    /// The value at a position, between four texels. Without closures: they would not be compiled for the instructions
    /// of the caller.
    #[inline(always)]
    fn at(&self, position: Vec2) -> Vec3 {
        let (left, right_share) = from_border(position.x, self.width);
        let (top, lower_share) = from_border(position.y, self.height);
        let stride = self.width + 2;
        let upper = self.between(top * stride + left, right_share);
        let lower = self.between((top + 1) * stride + left, right_share);
        (upper + (lower - upper) * lower_share).truncate()
    }

    /// The value between a texel and its right neighbour.
    #[inline(always)]
    fn between(&self, texel: usize, share: f32) -> Vec4 {
        let (left, right) = (Vec4::from_array(self.texels[texel]), Vec4::from_array(self.texels[texel + 1]));
        left + (right - left) * share
    }
}

/// Where a position (0 to 1) of a picture of so many texels lies, from the middle of its border's first texel: whole
/// texels, and the rest.
#[inline(always)]
fn from_border(position: f32, count: usize) -> (usize, f32) {
    let (at, last) = (position * count as f32 + 0.5, count as f32);
    let at = if at > 0.0 { at } else { 0.0 };
    let at = if at < last { at } else { last };
    let whole = at as i32;
    (whole as usize, at - whole as f32)
}

/// The most places at which the picture is read for a pixel.
const MOST_PLACES: f32 = 16.0;

/// The largest change of a direction from pixel to pixel that is taken as it is. Chosen, not measured.
const LARGEST_CHANGE: f32 = 0.25;

/// The largest cone, across, over which radiance is averaged: wider ones reach behind the surface that they leave.
/// Chosen, not measured.
const LARGEST_CONE: f32 = 1.2;

/// Maps are halved down to this height.
const LEAST_HEIGHT: usize = 4;

const IRRADIANCE_WIDTH: usize = 64;
const IRRADIANCE_HEIGHT: usize = 32;

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
        let irradiance = irradiance_map(width, height, &radiance);
        let (mut columns, mut rows) = (width as usize, height as usize);
        let mut reduced = Vec::new();
        let mut last: Option<Vec<[f32; 4]>> = None;
        while rows >= 2 * LEAST_HEIGHT && columns >= 4 * LEAST_HEIGHT {
            let next = match &last {
                Some(last) => halved(last, columns, rows),
                None => halved(&radiance, columns, rows),
            };
            (columns, rows) = (columns / 2, rows / 2);
            reduced.push(EquirectangularMap::new(columns, rows, &next));
            last = Some(next);
        }
        Self { name: name.into(), width, height, radiance, reduced, irradiance, glossy: OnceLock::new() }
    }

    /// Width, height and linear radiance of the picture, rows from the top.
    pub fn picture(&self) -> (u32, u32, &[[f32; 3]]) {
        (self.width, self.height, &self.radiance)
    }

    /// The maps of irradiance by normals ([`Self::irradiance`]) and of radiance over highlights ([`Self::glossy`]), for
    /// alpha 1, 1/2, 1/4 to 1/64; these are made if they are not there yet.
    pub fn light_maps(&self) -> Vec<LightMap<'_>> {
        let glossy = self.glossy.get_or_init(|| GlossyMaps::new(self));
        std::iter::once(&self.irradiance).chain(glossy.levels()).map(EquirectangularMap::light_map).collect()
    }

    /// The picture's radiance at half its width and height, at a quarter, and so on ([`Self::radiance_over`] reads
    /// these); none of small pictures.
    pub fn reductions(&self) -> impl ExactSizeIterator<Item = LightMap<'_>> {
        self.reduced.iter().map(EquirectangularMap::light_map)
    }

    /// The direction (unit length) that a position in the picture (0..1, v down) stands for.
    #[inline]
    pub fn direction(u: f32, v: f32) -> Vec3 {
        let (azimuth, polar) = ((u - 0.5) * std::f32::consts::TAU, v * std::f32::consts::PI);
        Vec3::new(polar.sine() * azimuth.cosine(), polar.cosine(), polar.sine() * azimuth.sine())
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
        // Between texels of a reduction the picture is as smooth as over a cone that is wider by this factor.
        const SMOOTHING: f32 = 1.732;
        let texels_per_radian = self.width as f32 * (1.0 / std::f32::consts::TAU);
        let texels = across.min(LARGEST_CONE) * (texels_per_radian / SMOOTHING);
        let texels = if texels > 1.0 { texels } else { 1.0 };
        // The logarithm's whole part and, nearly linear between powers of two, the rest.
        let bits = texels.to_bits();
        let mantissa = f32::from_bits(bits & 0x007f_ffff | 0x3f80_0000);
        let level = ((bits >> 23) as i32 - 127) as f32 + (mantissa - 1.0);
        self.at_level(Self::position(direction), level.min(self.reduced.len() as f32))
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

/// A texel of a row and its right neighbour. Beyond a pole lies the same row, half way round.
#[inline(always)]
fn neighbours<const C: usize>(texels: &[[f32; C]], width: usize, height: usize, left: i32, row: i32) -> [Vec4; 2] {
    let (columns, rows) = (width as i32, height as i32);
    let is_beyond = row < 0 || row >= rows;
    let left = wrapped(if is_beyond { left + columns / 2 } else { left }, columns);
    let right = wrapped(left + 1, columns);
    let start = row.clamp(0, rows - 1) as usize * width;
    [padded(&texels[start + left as usize]), padded(&texels[start + right as usize])]
}

/// The first three numbers of a texel, and one that does not matter.
#[inline(always)]
fn padded<const C: usize>(texel: &[f32; C]) -> Vec4 {
    Vec4::new(texel[0], texel[1], texel[2], texel[C - 1])
}

/// A column of a map that repeats. Positions are less than a turn beyond it, if at all: no division.
#[inline(always)]
fn wrapped(column: i32, columns: i32) -> i32 {
    let column = if column < 0 { column + columns } else { column };
    let column = if column >= columns { column - columns } else { column };
    column.clamp(0, columns - 1)
}

/// The largest whole number that is not above: machines without an instruction for it call a function.
#[inline(always)]
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    whole - i32::from(value < whole as f32)
}

/// A map of half the width and height; odd last columns and rows are left out.
fn halved<const C: usize>(radiance: &[[f32; C]], width: usize, height: usize) -> Vec<[f32; 4]> {
    let (columns, rows) = (width / 2, height / 2);
    let mut halves = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let at = |x: usize, y: usize| padded(&radiance[(2 * row + y) * width + 2 * column + x]);
            let mean = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) * 0.25;
            halves.push(mean.truncate().extend(0.0).to_array());
        }
    }
    halves
}

/// Irradiance for a grid of normals, by summing over the picture reduced to at most 128 x 64 cells.
fn irradiance_map(width: u32, height: u32, radiance: &[[f32; 3]]) -> EquirectangularMap {
    let (columns, rows) = ((width as usize).min(128), (height as usize).min(64));
    // Energy (radiance times solid angle) and mean direction, weighted by energy, of each cell.
    let mut energy = vec![Vec3::ZERO; columns * rows];
    let mut directions = vec![Vec3::ZERO; columns * rows];
    for y in 0..height as usize {
        let polar = |edge: usize| (edge as f32 / height as f32 * std::f32::consts::PI).cosine();
        let solid_angle = std::f32::consts::TAU / width as f32 * (polar(y) - polar(y + 1));
        let row = y * rows / height as usize;
        for x in 0..width as usize {
            let column = x * columns / width as usize;
            let arriving = Vec3::from(radiance[y * width as usize + x]) * solid_angle;
            let (u, v) = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
            energy[row * columns + column] += arriving;
            directions[row * columns + column] += Environment::direction(u, v) * arriving.element_sum();
        }
    }
    for direction in &mut directions {
        *direction = direction.normalize_or_zero(); // without energy no direction matters
    }
    let radiance = crate::parallel::map_collect(IRRADIANCE_WIDTH * IRRADIANCE_HEIGHT, |texel| {
        let (x, y) = (texel % IRRADIANCE_WIDTH, texel / IRRADIANCE_WIDTH);
        let normal = Environment::direction(
            (x as f32 + 0.5) / IRRADIANCE_WIDTH as f32,
            (y as f32 + 0.5) / IRRADIANCE_HEIGHT as f32,
        );
        let mut sum = Vec3::ZERO;
        for (energy, direction) in energy.iter().zip(&directions) {
            sum += *energy * direction.dot(normal).max(0.0);
        }
        sum.extend(0.0).to_array()
    });
    EquirectangularMap::new(IRRADIANCE_WIDTH, IRRADIANCE_HEIGHT, &radiance)
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
}
