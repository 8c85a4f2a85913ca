//! Pictures of light by direction: equirectangular, with a border, reduced, or averaged over hemispheres.

use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::math::portable::PortableMath;
use crate::parallel;
use glam::{Vec2, Vec3, Vec4};

/// A map of light by direction, for other look-ups than [`Environment`](super::Environment)'s own: an equirectangular
/// picture with a border of its neighbours, one texel wide.
#[derive(Clone, Copy, Debug)]
pub struct LightMap<'a> {
    /// Texels of a row, without the border.
    pub width: usize,
    /// Rows, without the border.
    pub height: usize,
    /// Linear radiance or irradiance, rows from the top: `height + 2` of `width + 2` texels. The fourth number is 0.
    pub texels: &'a [[f32; 4]],
}

/// Radiance by direction for fast look-ups: the fourth number is zero, so that one load reads all, and around the
/// picture stands a border of its neighbours.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EquirectangularMap {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Rows from the top, of two more than `width`; two more than `height` of them.
    pub(super) texels: Vec<[f32; 4]>,
}

impl EquirectangularMap {
    pub(super) fn light_map(&self) -> LightMap<'_> {
        LightMap { width: self.width, height: self.height, texels: &self.texels }
    }

    pub(super) fn new(width: usize, height: usize, radiance: &[[f32; 4]]) -> Self {
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
    pub(super) fn at(&self, position: Vec2) -> Vec3 {
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

/// The direction (unit length) that a position in a picture (0..1, v down) stands for.
#[inline]
pub(super) fn direction(u: f32, v: f32) -> Vec3 {
    let (azimuth, polar) = ((u - 0.5) * std::f32::consts::TAU, v * std::f32::consts::PI);
    Vec3::new(polar.sine() * azimuth.cosine(), polar.cosine(), polar.sine() * azimuth.sine())
}

/// The position in a picture that is not turned (0..1, v down) of a direction of unit length.
#[inline(always)] // for the instructions of its caller
pub(super) fn position(direction: Vec3) -> Vec2 {
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

/// A texel of a row and its right neighbour. Beyond a pole lies the same row, half way round.
#[inline(always)]
pub(super) fn neighbours<const C: usize>(
    texels: &[[f32; C]],
    width: usize,
    height: usize,
    left: i32,
    row: i32,
) -> [Vec4; 2] {
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

/// Maps are halved down to this height.
const LEAST_HEIGHT: usize = 4;

/// A picture at half its width and height, at a quarter, and so on.
pub(super) fn reductions(mut columns: usize, mut rows: usize, radiance: &[[f32; 3]]) -> Vec<EquirectangularMap> {
    let mut reduced = Vec::new();
    let mut last: Option<Vec<[f32; 4]>> = None;
    while rows >= 2 * LEAST_HEIGHT && columns >= 4 * LEAST_HEIGHT {
        let next = match &last {
            Some(last) => halved(last, columns, rows),
            None => halved(radiance, columns, rows),
        };
        (columns, rows) = (columns / 2, rows / 2);
        reduced.push(EquirectangularMap::new(columns, rows, &next));
        last = Some(next);
    }
    reduced
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

/// The irradiance that light from infinity causes, by normals.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Irradiance(pub(super) EquirectangularMap);

impl Irradiance {
    /// The irradiance that a picture of radiance causes, rows from the top.
    pub(in crate::scene) fn new(width: u32, height: u32, radiance: &[[f32; 3]]) -> Self {
        Self(irradiance_map(width, height, radiance))
    }

    pub(in crate::scene) fn map(&self) -> LightMap<'_> {
        self.0.light_map()
    }

    /// The irradiance of a surface with a normal, by the normal's position in the picture.
    #[inline(always)]
    pub(in crate::scene) fn at(&self, position: Vec2) -> Vec3 {
        self.0.at(position)
    }
}

const IRRADIANCE_WIDTH: usize = 64;
const IRRADIANCE_HEIGHT: usize = 32;

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
            directions[row * columns + column] += direction(u, v) * arriving.element_sum();
        }
    }
    for direction in &mut directions {
        *direction = direction.normalize_or_zero(); // without energy no direction matters
    }
    let radiance = parallel::map_collect(IRRADIANCE_WIDTH * IRRADIANCE_HEIGHT, |texel| {
        let (x, y) = (texel % IRRADIANCE_WIDTH, texel / IRRADIANCE_WIDTH);
        let normal = direction((x as f32 + 0.5) / IRRADIANCE_WIDTH as f32, (y as f32 + 0.5) / IRRADIANCE_HEIGHT as f32);
        let mut sum = Vec3::ZERO;
        for (energy, direction) in energy.iter().zip(&directions) {
            sum += *energy * direction.dot(normal).max(0.0);
        }
        sum.extend(0.0).to_array()
    });
    EquirectangularMap::new(IRRADIANCE_WIDTH, IRRADIANCE_HEIGHT, &radiance)
}

/// Coefficients of the arc tangent over its argument, by powers of the argument's square: a least-squares fit at
/// Chebyshev's points.
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
