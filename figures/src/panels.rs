//! Pictures put together from panels.

use anyhow::{Context, Result};
use image::codecs::png::{CompressionType, FilterType as RowFilter, PngEncoder};
use image::imageops::{self, FilterType};
use image::{ImageEncoder, RgbImage};
use std::path::Path;

/// Width of a panel where nothing else is said, in pixels.
const PANEL_WIDTH: u32 = 360;
/// White between two panels, in pixels.
const GAP: u32 = 4;

/// The part of a picture, in the picture's coordinates as shares of its size.
pub(crate) fn cut(picture: &RgbImage, [x, y, width, height]: [f32; 4]) -> RgbImage {
    let across = |share: f32| (share * picture.width() as f32) as u32;
    let down = |share: f32| (share * picture.height() as f32) as u32;
    imageops::crop_imm(picture, across(x), down(y), across(width), down(height)).to_image()
}

/// Pictures in a row, each as wide as a panel.
pub(crate) fn beside(pictures: &[RgbImage]) -> RgbImage {
    beside_of_width(pictures, PANEL_WIDTH)
}

/// Pictures in a row, each so many pixels wide.
pub(crate) fn beside_of_width(pictures: &[RgbImage], panel_width: u32) -> RgbImage {
    let panels: Vec<RgbImage> = pictures
        .iter()
        .map(|picture| {
            let height = panel_width * picture.height() / picture.width();
            imageops::resize(picture, panel_width, height, FilterType::CatmullRom)
        })
        .collect();
    let height = panels.iter().map(RgbImage::height).max().unwrap_or_default();
    let count = panels.len() as u32;
    let mut row = white(((panel_width + GAP) * count).saturating_sub(GAP), height);
    for (panel, left) in panels.iter().zip((0i64..).step_by((panel_width + GAP) as usize)) {
        imageops::replace(&mut row, panel, left, 0);
    }
    row
}

/// Rows of pictures, one below the other.
pub(crate) fn below(rows: &[RgbImage]) -> RgbImage {
    let width = rows.iter().map(RgbImage::width).max().unwrap_or_default();
    let height = rows.iter().map(|row| row.height() + GAP).sum::<u32>().saturating_sub(GAP);
    let mut all = white(width, height);
    let mut top = 0;
    for row in rows {
        imageops::replace(&mut all, row, 0, top);
        top += i64::from(row.height() + GAP);
    }
    all
}

/// A white picture.
pub(crate) fn white(width: u32, height: u32) -> RgbImage {
    RgbImage::from_pixel(width, height, image::Rgb([255; 3]))
}

/// Writes a picture as a small file: each channel rounded to one of 52 levels, hardly visible.
pub(crate) fn save_small(picture: &RgbImage, path: &Path) -> Result<()> {
    let rounded: Vec<u8> = picture.as_raw().iter().map(|channel| channel.saturating_add(2) / 5 * 5).collect();
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, RowFilter::Adaptive);
    encoder.write_image(&rounded, picture.width(), picture.height(), image::ExtendedColorType::Rgb8)?;
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
