//! Light from infinity: an equirectangular picture, its look-up, and the irradiance that it causes.

use glam::{Vec2, Vec3};

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
    irradiance: Vec<[f32; 3]>,
}

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
        Self { name: name.into(), width, height, radiance, irradiance }
    }

    /// The direction (unit length) that a position in the picture (0..1, v down) stands for.
    #[inline]
    pub fn direction(u: f32, v: f32) -> Vec3 {
        let (azimuth, polar) = ((u - 0.5) * std::f32::consts::TAU, v * std::f32::consts::PI);
        Vec3::new(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin())
    }

    /// The position in the picture (0..1, v down) of a direction of unit length.
    #[inline]
    pub fn position(direction: Vec3) -> Vec2 {
        let azimuth = direction.z.atan2(direction.x);
        let polar = direction.y.clamp(-1.0, 1.0).acos();
        Vec2::new(azimuth * (1.0 / std::f32::consts::TAU) + 0.5, polar * std::f32::consts::FRAC_1_PI)
    }

    /// The radiance from a direction (unit length), bilinear between texels.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        bilinear(&self.radiance, self.width as usize, self.height as usize, Self::position(direction))
    }

    /// The irradiance on a surface with this unit normal: radiance times cosine over the hemisphere.
    #[inline]
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        bilinear(&self.irradiance, IRRADIANCE_WIDTH, IRRADIANCE_HEIGHT, Self::position(normal))
    }
}

#[inline]
fn bilinear(texels: &[[f32; 3]], width: usize, height: usize, position: Vec2) -> Vec3 {
    let x = position.x * width as f32 - 0.5;
    let y = position.y * height as f32 - 0.5;
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let row = |y: i64| {
        // Beyond a pole lies the same row, half way round.
        let over = y < 0 || y >= height as i64;
        let turned = if over { left as i64 + width as i64 / 2 } else { left as i64 };
        let x0 = turned.rem_euclid(width as i64) as usize;
        let start = y.clamp(0, height as i64 - 1) as usize * width;
        Vec3::from(texels[start + x0]) * (1.0 - fx) + Vec3::from(texels[start + (x0 + 1) % width]) * fx
    };
    row(top as i64) * (1.0 - fy) + row(top as i64 + 1) * fy
}

/// Irradiance for a grid of normals, by summing over the picture reduced to at most 128 x 64 cells.
fn irradiance_map(width: u32, height: u32, radiance: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let (columns, rows) = ((width as usize).min(128), (height as usize).min(64));
    // Energy (radiance times solid angle) and mean direction, weighted by energy, of each cell.
    let mut energy = vec![Vec3::ZERO; columns * rows];
    let mut directions = vec![Vec3::ZERO; columns * rows];
    for y in 0..height as usize {
        let polar = |edge: usize| (edge as f32 / height as f32 * std::f32::consts::PI).cos();
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
    crate::parallel::map_collect(IRRADIANCE_WIDTH * IRRADIANCE_HEIGHT, |texel| {
        let (x, y) = (texel % IRRADIANCE_WIDTH, texel / IRRADIANCE_WIDTH);
        let normal = Environment::direction(
            (x as f32 + 0.5) / IRRADIANCE_WIDTH as f32,
            (y as f32 + 0.5) / IRRADIANCE_HEIGHT as f32,
        );
        let mut sum = Vec3::ZERO;
        for (energy, direction) in energy.iter().zip(&directions) {
            sum += *energy * direction.dot(normal).max(0.0);
        }
        sum.to_array()
    })
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
    fn positions_and_directions_are_inverse() {
        for (u, v) in [(0.5, 0.5), (0.75, 0.5), (0.1, 0.2), (0.99, 0.9)] {
            let position = Environment::position(Environment::direction(u, v));
            assert!((position - Vec2::new(u, v)).length() < 1e-5);
        }
        assert!((Environment::direction(0.5, 0.5) - Vec3::X).length() < 1e-6);
        assert!((Environment::direction(0.75, 0.5) - Vec3::Z).length() < 1e-6);
    }

    #[test]
    fn broken_values_become_black() {
        let sky = Environment::new("broken", 2, 1, vec![[f32::NAN, f32::INFINITY, -3.0]; 2]);
        assert_eq!(sky.radiance(Vec3::X), Vec3::ZERO);
    }
}
