//! The writing of pictures. The same picture gives the same bytes.

use super::layers;
use crate::error::SceneError;
use crate::framebuffer::{Framebuffer, srgb_from_linear};
use crate::output::write_file;
use crate::parallel;
use image::{ExtendedColorType, ImageEncoder};
use std::io::{self, Write};
use std::path::Path;

/// The quality of JPEG pictures, of 100.
const JPEG_QUALITY: u8 = 95;

/// Pixels that a thread encodes at once. A size for threads; chosen, not measured.
const CHUNK: usize = 4096;

/// The kinds of picture files that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8-bit sRGB, clamped, no tone curve.
    Png,
    /// The same with 16 bits.
    Png16,
    /// 8-bit sRGB, clamped, no tone curve, with small losses.
    Jpeg,
    /// 8-bit sRGB, clamped, no tone curve; lossless.
    WebP,
    /// Linear RGBA, 32-bit floats; lossless (ZIP).
    Exr,
    /// Linear RGBA, 16-bit floats; lossless (ZIP).
    ExrHalf,
}

impl PictureFormat {
    /// The extensions of pictures, for messages.
    pub const EXTENSIONS: &str = ".png, .jpg, .webp or .exr";

    /// The format that a file name's extension stands for; returns `None` if it is none of [`Self::EXTENSIONS`].
    pub fn from_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "webp" => Some(Self::WebP),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }

    /// True if it holds linear radiance of any range; others hold what a screen shows.
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Exr | Self::ExrHalf)
    }
}

/// Writes a picture in the format of its extension, as [`encode`] does.
///
/// # Errors
/// [`SceneError::Unsupported`] for extensions that stand for no format, [`SceneError::Write`] otherwise.
pub fn write(path: &Path, picture: &Framebuffer) -> Result<(), SceneError> {
    let Some(format) = PictureFormat::from_path(path) else {
        return Err(SceneError::Unsupported {
            file: path.display().to_string(),
            feature: "this kind of picture file".into(),
            remedy: format!("use a name that ends in {}", PictureFormat::EXTENSIONS),
        });
    };
    write_file(path, |writer| writer.write_all(&encode(format, picture)?))
}

/// The content of a picture's file; formats for screens are without alpha.
///
/// # Errors
/// Pictures that their format cannot hold.
pub fn encode(format: PictureFormat, picture: &Framebuffer) -> io::Result<Vec<u8>> {
    let Framebuffer { width, height, .. } = *picture;
    match format {
        PictureFormat::Png => encode_rgb8(width, height, &picture.to_srgb8()),
        PictureFormat::Png16 => encode_png(width, height, &bytes_of(&srgb16(picture)), ExtendedColorType::Rgb16),
        PictureFormat::Jpeg => encode_jpeg(width, height, &picture.to_srgb8()),
        PictureFormat::WebP => encode_webp(width, height, &picture.to_srgb8(), ExtendedColorType::Rgb8),
        PictureFormat::Exr | PictureFormat::ExrHalf => {
            layers::encode_layers(picture, format == PictureFormat::ExrHalf, Vec::new(), None)
        }
    }
}

/// The content of a picture's file with alpha, which is the pixels' coverage: straight in formats for screens, that is
/// colours are not multiplied by it. Linear formats hold pixels as they are.
///
/// # Errors
/// Pictures that their format cannot hold; JPEG, which has no alpha.
pub fn encode_with_alpha(format: PictureFormat, picture: &Framebuffer) -> io::Result<Vec<u8>> {
    let Framebuffer { width, height, .. } = *picture;
    let alphas = || picture.pixels.iter().map(|pixel| pixel[3].clamp(0.0, 1.0));
    let rgba8 = || {
        let mut bytes = picture.to_srgba8();
        for (pixel, alpha) in bytes.chunks_exact_mut(4).zip(alphas()) {
            pixel[3] = (alpha * 255.0 + 0.5) as u8;
        }
        bytes
    };
    match format {
        PictureFormat::Png => encode_png(width, height, &rgba8(), ExtendedColorType::Rgba8),
        PictureFormat::Png16 => {
            let colors = srgb16(picture);
            let with_alpha = |([r, g, b], alpha): (&[u16; 3], f32)| [*r, *g, *b, (alpha * 65535.0 + 0.5) as u16];
            let pixels: Vec<u16> = colors.as_chunks().0.iter().zip(alphas()).flat_map(with_alpha).collect();
            encode_png(width, height, &bytes_of(&pixels), ExtendedColorType::Rgba16)
        }
        PictureFormat::WebP => encode_webp(width, height, &rgba8(), ExtendedColorType::Rgba8),
        PictureFormat::Jpeg => Err(io::Error::new(io::ErrorKind::InvalidInput, "JPEG has no alpha")),
        PictureFormat::Exr | PictureFormat::ExrHalf => encode(format, picture),
    }
}

/// The content of a PNG file of 8-bit sRGB pixels, three bytes each, rows from the top.
///
/// # Errors
/// When there are not `3 * width * height` bytes.
pub fn encode_rgb8(width: u32, height: u32, rgb: &[u8]) -> io::Result<Vec<u8>> {
    encode_png(width, height, rgb, ExtendedColorType::Rgb8)
}

/// Writes 8-bit sRGB pixels, three bytes each, rows from the top, as PNG.
///
/// # Errors
/// [`SceneError::Write`], also when there are not `3 * width * height` bytes.
pub fn write_rgb8(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<(), SceneError> {
    write_file(path, |writer| writer.write_all(&encode_rgb8(width, height, rgb)?))
}

/// The content of a mask's file, from shares of pixels, 0 to 1: a grey PNG, in which 255 stands for 1 and steps are
/// equal, or in linear formats the one channel `Y`.
///
/// # Errors
/// When there is not one value a pixel, and for other formats.
pub fn encode_mask(format: PictureFormat, width: u32, height: u32, shares: &[f32]) -> io::Result<Vec<u8>> {
    match format {
        PictureFormat::Png => {
            let grey: Vec<u8> = shares.iter().map(|share| (share.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect();
            encode_png(width, height, &grey, ExtendedColorType::L8)
        }
        PictureFormat::Exr => layers::encode_grey(width, height, shares),
        _ => Err(io::Error::new(io::ErrorKind::InvalidInput, "masks are PNG or OpenEXR")),
    }
}

/// Three numbers a pixel.
fn srgb16(picture: &Framebuffer) -> Vec<u16> {
    let mut values = vec![0u16; picture.pixels.len() * 3];
    parallel::for_each_chunk_mut(&mut values, CHUNK * 3, |chunk, values| {
        for (pixel, values) in picture.pixels[chunk * CHUNK..].iter().zip(values.as_chunks_mut::<3>().0) {
            *values = [pixel[0], pixel[1], pixel[2]].map(|linear| (srgb_from_linear(linear) * 65535.0 + 0.5) as u16);
        }
    });
    values
}

/// In the order of the machine, as the encoder takes them.
fn bytes_of(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_ne_bytes()).collect()
}

fn encode_png(width: u32, height: u32, bytes: &[u8], color: ExtendedColorType) -> io::Result<Vec<u8>> {
    check_count(width, height, bytes, color)?;
    let mut file = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut file);
    encoder.write_image(bytes, width, height, color).map_err(io::Error::other)?;
    Ok(file)
}

fn encode_webp(width: u32, height: u32, bytes: &[u8], color: ExtendedColorType) -> io::Result<Vec<u8>> {
    check_count(width, height, bytes, color)?;
    let mut file = Vec::new();
    let encoder = image::codecs::webp::WebPEncoder::new_lossless(&mut file);
    encoder.write_image(bytes, width, height, color).map_err(io::Error::other)?;
    Ok(file)
}

fn encode_jpeg(width: u32, height: u32, rgb: &[u8]) -> io::Result<Vec<u8>> {
    check_count(width, height, rgb, ExtendedColorType::Rgb8)?;
    let mut file = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut file, JPEG_QUALITY);
    encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8).map_err(io::Error::other)?;
    Ok(file)
}

/// The encoders take other numbers of bytes for a bug and panic.
fn check_count(width: u32, height: u32, bytes: &[u8], color: ExtendedColorType) -> io::Result<()> {
    let expected = u64::from(width) * u64::from(height) * u64::from(color.bits_per_pixel() / 8);
    if bytes.len() as u64 == expected {
        return Ok(());
    }
    let problem = format!("{} bytes for a picture of {width}x{height} pixels", bytes.len());
    Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
}
