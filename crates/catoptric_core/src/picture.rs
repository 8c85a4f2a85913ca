//! Pictures as files: PNG, JPEG and WebP for looking at, OpenEXR and Radiance HDR for measuring.

mod encode;
mod layers;

pub use encode::{PictureFormat, encode, encode_mask, encode_rgb8, encode_with_alpha, write, write_rgb8};
pub use layers::{Channel, ChannelValues, encode_layers};

use crate::error::SceneError;
use crate::exr_blocks;
use crate::framebuffer::{Framebuffer, linear_from_srgb};
use crate::input::read_file;
use exr::block::reader::ChunksReader;
use exr::prelude as openexr;
use std::io;
use std::path::Path;

/// Larger pictures are refused: they are damaged headers far more often than pictures.
const MAX_SIDE: u32 = 65_536;
/// The largest file of a picture.
const MAX_FILE_BYTES: u64 = 4 << 30;
/// The most memory that decoding a picture may take.
const MAX_DECODED_BYTES: u64 = 4 << 30;

/// Reads a picture as linear radiance: `.exr` and `.hdr` as they stand, 8- and 16-bit formats from sRGB.
///
/// # Errors
/// [`SceneError::Read`] when the file cannot be opened, [`SceneError::Invalid`] when it is no picture that can be read.
pub fn read(path: &Path) -> Result<Framebuffer, SceneError> {
    let bytes = bytes_of(path)?;
    let invalid = |problem: String| SceneError::invalid(path.display().to_string(), "picture", problem);
    // By content: extensions lie.
    if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) { read_exr(&bytes) } else { read_with_image(&bytes) }
        .map_err(invalid)
}

/// Reads one channel of an OpenEXR picture, the first of these names that it has, with or without the name of a layer
/// before it: width, height and values, rows from the top.
///
/// # Errors
/// [`SceneError::Read`], and [`SceneError::Invalid`] for other pictures and those without such a channel.
pub fn read_channel(path: &Path, names: &[&str]) -> Result<(u32, u32, Vec<f32>), SceneError> {
    let bytes = bytes_of(path)?;
    channel_of(&bytes, names).map_err(|problem| SceneError::invalid(path.display().to_string(), "picture", problem))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, SceneError> {
    read_file(path, MAX_FILE_BYTES).map_err(|source| SceneError::Read { path: path.into(), source })
}

fn channel_of(bytes: &[u8], names: &[&str]) -> Result<(u32, u32, Vec<f32>), String> {
    use openexr::{ReadChannels, ReadLayers};
    check_exr_size(bytes)?;
    let image = openexr::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(io::Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    let layer = &image.layer_data;
    let channels = &layer.channel_data.list;
    // Renderers put the layer's name before the channel's, and a point.
    let is_named = |name: &str, wanted: &str| name == wanted || name.rsplit('.').next() == Some(wanted);
    let found = names.iter().find_map(|wanted| channels.iter().find(|it| is_named(&it.name.to_string(), wanted)));
    let channel = found.ok_or_else(|| format!("has no channel named {}", names.join(", ")))?;
    let (width, height) = (layer.size.width(), layer.size.height());
    let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
    // Channels may have fewer values than the picture has pixels.
    if values.len() != width * height {
        return Err(format!("its channel {} is subsampled; write it with a value a pixel", channel.name));
    }
    Ok((width as u32, height as u32, values))
}

fn read_exr(bytes: &[u8]) -> Result<Framebuffer, String> {
    use openexr::{ReadChannels, ReadLayers};
    check_exr_size(bytes)?;
    let image = openexr::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| Framebuffer::new(size.width() as u32, size.height() as u32),
            |picture: &mut Framebuffer, at, (r, g, b, a): (f32, f32, f32, f32)| {
                let index = at.y() * picture.width as usize + at.x();
                picture.pixels[index] = [r, g, b, a];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(io::Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    Ok(image.layer_data.channel_data.pixels)
}

/// Memory is taken as headers demand.
fn check_exr_size(bytes: &[u8]) -> Result<(), String> {
    let meta = openexr::MetaData::read_from_buffered(io::Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
        if width.max(height) > u64::from(MAX_SIDE) || width * height * 16 > MAX_DECODED_BYTES {
            return Err(format!("its {width}x{height} pixels are too many; {MAX_SIDE} a side and 4 GiB are allowed"));
        }
    }
    // Others are not read twice.
    if !meta.headers.iter().any(exr_blocks::is_dwa) {
        return Ok(());
    }
    check_exr_blocks(bytes).map_err(|error| error.to_string())?
}

/// Blocks of DWA, too, say how much memory they take.
fn check_exr_blocks(bytes: &[u8]) -> openexr::Result<Result<(), String>> {
    let chunks = exr::block::read(io::Cursor::new(bytes), false)?.all_chunks(false)?;
    let headers = chunks.meta_data().headers.clone();
    for chunk in chunks {
        let chunk = chunk?;
        if let Some(Err(problem)) = headers.get(chunk.layer_index).map(|header| exr_blocks::check(&chunk, header)) {
            return Ok(Err(problem));
        }
    }
    Ok(Ok(()))
}

fn read_with_image(bytes: &[u8]) -> Result<Framebuffer, String> {
    let mut reader =
        image::ImageReader::new(io::Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    let format = reader.format().ok_or("is neither PNG, JPEG, WebP, Radiance HDR nor OpenEXR")?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    reader.limits(limits);
    let decoded = reader.decode().map_err(|error| error.to_string())?;
    let linear = format == image::ImageFormat::Hdr;
    let rgba = decoded.into_rgba32f();
    let (width, height) = rgba.dimensions();
    let curve = |value: f32| if linear { value } else { linear_from_srgb(value) };
    let pixels = rgba.pixels().map(|p| [curve(p.0[0]), curve(p.0[1]), curve(p.0[2]), p.0[3]]).collect();
    Ok(Framebuffer::of_pixels(width, height, pixels))
}
