//! Decoding of 8-bit pictures for textures, within limits.

#[cfg(feature = "gltf")]
mod ktx2;
mod rgba;

pub(super) use rgba::Picture;

use image::{ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// The largest width and height of a texture.
const MAX_SIDE: u32 = 16_384;
/// Texels that are allowed whatever the size of the files: sixteen pictures of 4096 x 4096, 3 GiB of memory.
const FREE_TEXELS: u64 = 1 << 28;
/// Texels that are allowed for every byte of an encoded picture; photographs need about 16.
const TEXELS_PER_BYTE: u64 = 32;

/// The size of a picture, read from its header alone.
pub(super) fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    #[cfg(feature = "gltf")]
    if ktx2::is_ktx2(bytes) {
        return ktx2::dimensions(bytes);
    }
    let mut reader = reader(bytes)?;
    // Nothing is decoded here; sizes beyond the limits are told by them.
    reader.no_limits();
    reader.into_dimensions().map_err(|error| format!("is broken or cut off ({error})"))
}

/// The picture in the bytes of a file, once it is admitted by its size.
pub(super) fn decode_within(bytes: &[u8], budget: &mut TexelBudget) -> Result<Picture, String> {
    budget.admit(dimensions(bytes)?, bytes.len())?;
    decode(bytes)
}

/// The picture in the bytes of a PNG, JPEG, WebP, TGA or BMP file.
pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    #[cfg(feature = "gltf")]
    if ktx2::is_ktx2(bytes) {
        return ktx2::decode(bytes);
    }
    let broken = |error: image::ImageError| format!("is broken or cut off ({error})");
    let picture = reader(bytes)?.decode().map_err(broken)?.into_rgba8();
    let (width, height) = picture.dimensions();
    Ok(Picture { width, height, texels: picture.pixels().map(|pixel| pixel.0).collect() })
}

fn reader(bytes: &[u8]) -> Result<ImageReader<Cursor<&[u8]>>, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|error| error.to_string())?;
    match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP | ImageFormat::Bmp) => {}
        // The one format without a signature.
        None if is_targa(bytes) => reader.set_format(ImageFormat::Tga),
        _ => return Err(format!("is no PNG, JPEG, WebP, TGA or BMP picture but {}", super::files::kind_of(bytes))),
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(512 << 20);
    reader.limits(limits);
    Ok(reader)
}

/// Returns true if the header is one of a Truevision TGA picture: its kinds of colour maps, pictures and depths.
fn is_targa(bytes: &[u8]) -> bool {
    matches!(bytes, [_, 0 | 1, 1 | 2 | 3 | 9 | 10 | 11, ..])
        && matches!(bytes.get(16), Some(8 | 15 | 16 | 24 | 32))
        && bytes.get(12..16) != Some(&[0; 4])
}

/// Keeps the memory of all textures of a scene in proportion to the size of its files.
#[derive(Debug, Default)]
pub(super) struct TexelBudget {
    used: u64,
    encoded_bytes: u64,
}

impl TexelBudget {
    /// Accounts for a picture that is about to be decoded.
    pub(super) fn admit(&mut self, (width, height): (u32, u32), encoded_bytes: usize) -> Result<(), String> {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!("has {width} x {height} texels; allowed are 1 to {MAX_SIDE} a side"));
        }
        self.used += u64::from(width) * u64::from(height);
        self.encoded_bytes += encoded_bytes as u64;
        let allowed = FREE_TEXELS + TEXELS_PER_BYTE * self.encoded_bytes;
        if self.used > allowed {
            return Err(format!(
                "has {width} x {height} texels, {} with those before it; allowed are {allowed} for files of this size",
                self.used
            ));
        }
        Ok(())
    }
}
