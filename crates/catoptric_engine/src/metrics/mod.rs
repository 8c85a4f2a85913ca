//! The error of a picture against the reference: FLIP, RMSE and the share of visibly wrong pixels.
//!
//! All numbers exist for the whole picture and for a part of it, usually the pixels that show a reflector or a lens.

mod error;
mod flip;
mod heat;

pub use error::MetricError;
pub use flip::{DEFAULT_PIXELS_PER_DEGREE, flip_map};
pub use heat::{heat_color, heat_map_rgb8};

use catoptric_core::framebuffer::{Framebuffer, srgb_from_linear};
use catoptric_core::parallel;
use error::check;
use serde::Serialize;

/// The error of a picture, or of a part of it, against the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PictureError {
    /// Mean of LDR-FLIP, 0 (equal) to 1.
    pub flip_mean: f64,
    /// The value that 99 of 100 pixels do not exceed, each pixel counted alike.
    pub flip_p99: f64,
    /// Root mean square difference of the linear red, green and blue values. Infinite where a picture is not finite.
    pub rmse: f64,
    /// Share of pixels with an sRGB channel off by more than 0.1.
    pub over_0_1: f64,
}

/// Two pictures compared pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// LDR-FLIP of each pixel, 0 to 1, rows from the top.
    pub flip: Vec<f32>,
    pixels: Vec<PixelDifference>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct PixelDifference {
    squared: f64,
    visible: bool,
}

impl Comparison {
    /// Compares two linear pictures; the second is the truth. FLIP clamps them to the range of sRGB.
    ///
    /// # Errors
    /// [`MetricError`] when the sizes differ.
    pub fn new(test: &Framebuffer, reference: &Framebuffer) -> Result<Self, MetricError> {
        check(test, reference)?;
        let flip = flip_map(test, reference, DEFAULT_PIXELS_PER_DEGREE)?;
        let pixels = parallel::map_collect(flip.len(), |index| difference(test.pixels[index], reference.pixels[index]));
        Ok(Self { width: test.width, height: test.height, flip, pixels })
    }

    /// The error of the whole picture; `None` if it has no pixels.
    pub fn whole(&self) -> Option<PictureError> {
        self.sum(|_| true)
    }

    /// The error of those pixels where the mask is true; `None` if there are no such pixels.
    ///
    /// # Errors
    /// [`MetricError::Length`] when the mask does not have one value a pixel.
    pub fn masked(&self, mask: &[bool]) -> Result<Option<PictureError>, MetricError> {
        if mask.len() != self.flip.len() {
            return Err(MetricError::Length { what: "the mask", found: mask.len(), expected: self.flip.len() });
        }
        Ok(self.sum(|index| mask[index]))
    }

    fn sum(&self, wanted: impl Fn(usize) -> bool) -> Option<PictureError> {
        let chosen: Vec<usize> = (0..self.flip.len()).filter(|&index| wanted(index)).collect();
        if chosen.is_empty() {
            return None;
        }
        let count = chosen.len() as f64;
        let total = |value: &dyn Fn(usize) -> f64| chosen.iter().map(|&index| value(index)).sum::<f64>();
        let mut flip: Vec<f32> = chosen.iter().map(|&index| self.flip[index]).collect();
        Some(PictureError {
            flip_mean: total(&|index| f64::from(self.flip[index])) / count,
            flip_p99: f64::from(percentile(&mut flip, 0.99)),
            rmse: (total(&|index| self.pixels[index].squared) / (3.0 * count)).sqrt(),
            over_0_1: total(&|index| if self.pixels[index].visible { 1.0 } else { 0.0 }) / count,
        })
    }
}

/// The smallest of `values` that at least this share of them does not exceed; 0 when there are none. Reorders `values`.
pub fn percentile(values: &mut [f32], share: f64) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = (share.clamp(0.0, 1.0) * values.len() as f64).ceil() as usize;
    let index = rank.clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(index, f32::total_cmp).1
}

fn difference(test: [f32; 4], reference: [f32; 4]) -> PixelDifference {
    let mut squared = 0.0;
    let mut visible = false;
    for (a, b) in test.into_iter().zip(reference).take(3) {
        let step = f64::from(a) - f64::from(b);
        squared += if step.is_finite() { step * step } else { f64::INFINITY };
        visible |= (srgb_from_linear(a) - srgb_from_linear(b)).abs() > 0.1;
    }
    PixelDifference { squared, visible }
}
