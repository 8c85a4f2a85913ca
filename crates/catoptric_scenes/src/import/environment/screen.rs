//! 8-bit pictures, made for screens, as light from infinity.

use super::canvas::{Canvas, Radiance, check_sides};
use catoptric_core::framebuffer::linear_from_srgb;
use image::{ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// The memory that decoding may take, in bytes: 16384 x 8192 pixels of 8 bytes.
const MAX_BYTES: u64 = 1 << 30;

/// Returns true for the first bytes of a PNG, JPEG or WebP file.
pub(super) fn is_picture(bytes: &[u8]) -> bool {
    matches!(image::guess_format(bytes), Ok(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP))
}

/// The picture, its sRGB values made linear.
pub(super) fn read(bytes: &[u8], warnings: &mut Vec<String>) -> Result<Radiance, String> {
    let reader = || {
        let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?;
        let mut limits = Limits::default();
        limits.max_alloc = Some(MAX_BYTES);
        reader.limits(limits);
        Some(reader)
    };
    let broken = || "is broken or cut off: save it again".to_owned();
    let (width, height) = reader().and_then(|reader| reader.into_dimensions().ok()).ok_or_else(broken)?;
    check_sides(width.into(), height.into())?;
    let decoded = reader().ok_or_else(broken)?.decode().map_err(|error| match error {
        image::ImageError::Limits(_) => {
            format!("has {width} x {height} pixels, for which {MAX_BYTES} bytes are too few: scale it down")
        }
        _ => broken(),
    })?;
    warnings.push(
        "8-bit picture: no light brighter than white, so lamps and the sun in it light too little; an .hdr or .exr \
         picture has them"
            .into(),
    );
    let mut canvas = Canvas::new(width.into(), height.into(), warnings)?;
    let linear: Vec<f32> = (0..=u16::MAX).map(|value| linear_from_srgb(f32::from(value) / 65535.0)).collect();
    let mut set = |x: u32, y: u32, values: [u16; 3]| {
        canvas.set(x as usize, y as usize, values.map(|value| linear[usize::from(value)]));
    };
    match decoded {
        image::DynamicImage::ImageRgb8(picture) => {
            picture.enumerate_pixels().for_each(|(x, y, pixel)| set(x, y, pixel.0.map(|value| u16::from(value) * 257)));
        }
        other => other.into_rgb16().enumerate_pixels().for_each(|(x, y, pixel)| set(x, y, pixel.0)),
    }
    Ok(canvas.into_radiance())
}
