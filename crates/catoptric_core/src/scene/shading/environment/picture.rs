//! The picture of an environment: radiance by direction, as fine as it is and reduced.

use super::map::{EquirectangularMap, neighbours, reductions};
use glam::{Vec2, Vec3};

/// Linear radiance in an equirectangular picture, at least one texel wide and high.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Picture {
    pub(in crate::scene) width: u32,
    pub(in crate::scene) height: u32,
    /// Rows from the top.
    pub(in crate::scene) radiance: Vec<[f32; 3]>,
    /// The same at half the width and height, at a quarter, and so on.
    pub(super) reduced: Vec<EquirectangularMap>,
}

impl Picture {
    /// A picture of `width * height` values.
    pub(super) fn new(width: u32, height: u32, radiance: Vec<[f32; 3]>) -> Self {
        let reduced = reductions(width as usize, height as usize, &radiance);
        Self { width, height, radiance, reduced }
    }

    /// The picture, or the first of its reductions that is no wider than so many columns, and which of them: 0 is the
    /// picture itself.
    pub(in crate::scene) fn within(&self, columns: u32) -> (usize, (u32, u32, Vec<[f32; 3]>)) {
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

    /// The radiance at a position, blended between two reductions.
    #[inline(always)]
    pub(super) fn at_level(&self, position: Vec2, level: f32) -> Vec3 {
        let whole = level as usize;
        let (fine, share) = (self.at_whole_level(position, whole), level - whole as f32);
        if share > 0.0 { fine + (self.at_whole_level(position, whole + 1) - fine) * share } else { fine }
    }

    /// The radiance at a position of a reduction; 0: the picture as it is.
    #[inline(always)]
    pub(super) fn at_whole_level(&self, position: Vec2, level: usize) -> Vec3 {
        if level == 0 || self.reduced.is_empty() {
            return bilinear(&self.radiance, self.width as usize, self.height as usize, position);
        }
        self.reduced[(level - 1).min(self.reduced.len() - 1)].at(position)
    }
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
