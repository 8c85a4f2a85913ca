//! Pictures that are filled pixel by pixel, at a part of their size where they are large.

use catoptric_core::scene::Environment;
use glam::Vec3;

/// The most pixels of an environment: 8192 x 4096. Larger pictures are halved.
const MAX_PIXELS: u64 = 1 << 25;

/// The longest side of a picture that is halved.
const MAX_SIDE: u64 = 1 << 15;

/// An equirectangular picture of linear radiance, rows from the top.
pub(super) struct Radiance {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) radiance: Vec<[f32; 3]>,
}

/// A picture of linear radiance whose pixels may come in any order, each once.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    /// Pixels of the file along a side of one that is kept, as a power of 2.
    halvings: u32,
    kept_width: usize,
    radiance: Vec<[f32; 3]>,
}

impl Canvas {
    /// A black picture for so many pixels of a file; a warning where it is kept at a part of its size.
    pub(super) fn new(width: u64, height: u64, warnings: &mut Vec<String>) -> Result<Self, String> {
        check_sides(width, height)?;
        let mut halvings = 0;
        let kept = |side: u64, halvings: u32| side.div_ceil(1 << halvings);
        while kept(width, halvings) * kept(height, halvings) > MAX_PIXELS {
            halvings += 1;
        }
        let (kept_width, kept_height) = (kept(width, halvings) as usize, kept(height, halvings) as usize);
        if halvings > 0 {
            let part = ["half", "a quarter of", "an eighth of"][(halvings as usize - 1).min(2)];
            warnings.push(format!(
                "{width} x {height} pixels are read at {part} their size, {kept_width} x {kept_height}, averaged; \
                 environments have at most {MAX_PIXELS} pixels"
            ));
        }
        let radiance = vec![[0.0; 3]; kept_width * kept_height];
        Ok(Self { width: width as usize, height: height as usize, halvings, kept_width, radiance })
    }

    /// Sets a pixel of the file; those outside are left out. Values are kept as [`Environment::kept`] says.
    pub(super) fn set(&mut self, x: usize, y: usize, radiance: [f32; 3]) {
        if x >= self.width || y >= self.height {
            return;
        }
        let radiance = radiance.map(Environment::kept);
        let (column, row) = (x >> self.halvings, y >> self.halvings);
        let texel = &mut self.radiance[row * self.kept_width + column];
        if self.halvings == 0 {
            *texel = radiance;
            return;
        }
        // The last column and row may stand for fewer pixels.
        let side = 1usize << self.halvings;
        let along = |kept: usize, all: usize| side.min(all - (kept << self.halvings));
        let share = 1.0 / (along(column, self.width) * along(row, self.height)) as f32;
        for (sum, value) in texel.iter_mut().zip(radiance) {
            *sum += value * share;
        }
    }

    /// The picture.
    pub(super) fn into_radiance(self) -> Radiance {
        let height = self.radiance.len() / self.kept_width;
        Radiance { width: self.kept_width as u32, height: height as u32, radiance: self.radiance }
    }
}

/// The panorama of a cube with faces of so many pixels a side, of about the same density, from its radiance by
/// direction.
pub(super) fn of_cube(
    side: usize,
    radiance: impl Fn(Vec3) -> Vec3,
    warnings: &mut Vec<String>,
) -> Result<Radiance, String> {
    /// Places along a side of a texel that are averaged.
    const PLACES: usize = 2;
    let (width, height) = (4 * side, 2 * side);
    let mut canvas = Canvas::new(width as u64, height as u64, warnings)?;
    for row in 0..height {
        for column in 0..width {
            let mut sum = Vec3::ZERO;
            for place in 0..PLACES * PLACES {
                let within = |place: usize| (place as f32 + 0.5) / PLACES as f32;
                let u = (column as f32 + within(place % PLACES)) / width as f32;
                let v = (row as f32 + within(place / PLACES)) / height as f32;
                sum += radiance(Environment::direction(u, v));
            }
            canvas.set(column, row, (sum / (PLACES * PLACES) as f32).to_array());
        }
    }
    Ok(canvas.into_radiance())
}

/// The value at a place between the pixels of a picture, whose columns and rows are whole at their middles.
pub(super) fn between(column: f32, row: f32, pixel: impl Fn(usize, usize) -> Vec3) -> Vec3 {
    let (left, top) = (column as usize, row as usize);
    let [upper, lower] = [top, top + 1].map(|y| pixel(left, y).lerp(pixel(left + 1, y), column - left as f32));
    upper.lerp(lower, row - top as f32)
}

/// Refuses pictures without pixels, and very long sides.
pub(super) fn check_sides(width: u64, height: u64) -> Result<(), String> {
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("has {width} x {height} pixels; allowed are 1 to {MAX_SIDE} a side: scale it down"));
    }
    Ok(())
}
