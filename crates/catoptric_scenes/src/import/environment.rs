//! Light from infinity from `.hdr` (Radiance) and `.exr` (OpenEXR) pictures.

use super::files::{self, MAX_SCENE_BYTES};
use catoptric_core::error::SceneError;
use catoptric_core::scene::Environment;
use std::io::Cursor;
use std::path::Path;

/// The most pixels of an environment: 8192 x 4096.
const MAX_PIXELS: u64 = 1 << 25;
const MAX_SIDE: u64 = 16_384;

/// Reads an equirectangular picture in linear radiance, `.hdr` or `.exr`.
///
/// # Errors
/// [`SceneError`] when the file cannot be read, is broken, is of another kind or is larger than 8192 x 4096 pixels.
pub fn load_environment(path: &Path) -> Result<Environment, SceneError> {
    let name = path.display().to_string();
    check_kind(&name)?;
    environment_from(&name, &files::read(path, MAX_SCENE_BYTES)?)
}

/// Refuses names of other kinds of files, before anything is read.
fn check_kind(name: &str) -> Result<(), SceneError> {
    match super::extension(Path::new(name)).as_str() {
        "hdr" | "exr" => Ok(()),
        other => {
            let problem = format!("`.{other}` is no kind of environment; allowed are .hdr and .exr");
            Err(SceneError::invalid(name, "extension", problem))
        }
    }
}

/// The same from memory, by the extension of its name.
pub(super) fn environment_from(name: &str, bytes: &[u8]) -> Result<Environment, SceneError> {
    check_kind(name)?;
    match super::extension(Path::new(name)).as_str() {
        "hdr" => from_hdr(name, bytes),
        _ => from_exr(name, bytes),
    }
}

/// An environment from the bytes of a Radiance picture.
fn from_hdr(name: &str, bytes: &[u8]) -> Result<Environment, SceneError> {
    let broken = |error: image::ImageError| SceneError::invalid(name, "picture", format!("cannot be read: {error}"));
    let reader = || image::ImageReader::with_format(Cursor::new(bytes), image::ImageFormat::Hdr);
    let (width, height) = reader().into_dimensions().map_err(broken)?;
    check_size(name, u64::from(width), u64::from(height))?;
    let picture = reader().decode().map_err(broken)?.into_rgb32f();
    let radiance = picture.pixels().map(|pixel| pixel.0).collect();
    Ok(Environment::new(files::file_name(name), width, height, radiance))
}

/// An environment from the bytes of an OpenEXR picture: the first layer with the channels R, G and B.
fn from_exr(name: &str, bytes: &[u8]) -> Result<Environment, SceneError> {
    use exr::prelude::*;
    let broken = |error: exr::error::Error| SceneError::invalid(name, "picture", format!("cannot be read: {error}"));
    let metadata = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &metadata.headers {
        check_size(name, header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0f32; 3]; size.width() * size.height()]),
            |(width, pixels): &mut (usize, Vec<[f32; 3]>), position, (r, g, b): (f32, f32, f32)| {
                if let Some(pixel) = pixels.get_mut(position.y() * *width + position.x()) {
                    *pixel = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let size = image.layer_data.size;
    let radiance = image.layer_data.channel_data.pixels.1;
    Ok(Environment::new(files::file_name(name), size.width() as u32, size.height() as u32, radiance))
}

fn check_size(name: &str, width: u64, height: u64) -> Result<(), SceneError> {
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE || width * height > MAX_PIXELS {
        let problem = format!("{width} x {height} pixels; allowed are up to {MAX_SIDE} a side and {MAX_PIXELS} in all");
        return Err(SceneError::invalid(name, "picture", problem));
    }
    Ok(())
}
