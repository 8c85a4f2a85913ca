//! Readers of option values; each message names what is allowed.

mod pictures;
mod points;
mod stream;

pub(crate) use catoptric_options::parse::{
    Order, exact_vector, field_of_view, file, key_value, no_stream, order, size, vector,
};
pub(crate) use pictures::{FramesWanted, NamePattern, Region, frames_per_second, frames_wanted, region};
pub(crate) use points::{Grid, JSON_LINES, PointSource, camera_path, is_camera, points, table_path};
pub(crate) use stream::{FileOrStream, file_or_stream, place};

use catoptric::picture::PictureFormat;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::PathBuf;
use std::time::Duration;

/// Longer times are taken for slips.
const MAX_SECS: u64 = 366 * 24 * 3600;

/// A time such as `50m`, `1h30m`, `90s`.
pub(crate) fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || format!("`{text}` is no time; write it as 90s, 50m or 1h30m");
    let (mut total, mut rest) = (Duration::ZERO, text.trim());
    if rest.is_empty() {
        return Err(wrong());
    }
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit()).ok_or_else(wrong)?;
        let count: u64 = rest[..digits].parse().map_err(|_| wrong())?;
        let unit_secs = match rest.as_bytes()[digits] {
            b's' => 1,
            b'm' => 60,
            b'h' => 3600,
            _ => return Err(wrong()),
        };
        let secs = count.checked_mul(unit_secs).filter(|secs| *secs <= MAX_SECS);
        total += Duration::from_secs(secs.ok_or_else(|| format!("`{text}` is longer than a year"))?);
        rest = &rest[digits + 1..];
    }
    Ok(total)
}

/// Reads the name of a picture or its pattern, or `-`.
pub(crate) fn picture_path() -> impl TypedValueParser<Value = FileOrStream> {
    PathBufValueParser::new().try_map(picture)
}

/// Reads the name of a PNG picture.
pub(crate) fn png_path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(png)
}

/// Reads the name of a mask or its pattern.
pub(crate) fn mask_path() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(mask)
}

fn picture(path: PathBuf) -> Result<FileOrStream, String> {
    let picture = FileOrStream::from(path);
    let Some(path) = picture.path() else { return Ok(picture) };
    if PictureFormat::from_path(path).is_none() {
        return Err(format!("the name must end in {}, or be `-`", PictureFormat::EXTENSIONS));
    }
    NamePattern::of(path)?;
    Ok(picture)
}

pub(crate) fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("it must be a number from 0 to 1".into()),
    }
}

fn png(path: PathBuf) -> Result<PathBuf, String> {
    let path = no_stream(path)?;
    match PictureFormat::from_path(&path) {
        Some(PictureFormat::Png) => Ok(path),
        _ => Err("the name must end in .png".into()),
    }
}

fn mask(path: PathBuf) -> Result<PathBuf, String> {
    let path = no_stream(path)?;
    NamePattern::of(&path)?;
    match PictureFormat::from_path(&path) {
        Some(PictureFormat::Png | PictureFormat::Exr) => Ok(path),
        _ => Err("the name must end in .png or .exr".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times() {
        assert_eq!(duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("1h30m"), Ok(Duration::from_secs(5400)));
        for wrong in ["", "90", "m", "1d", "-5m", "1h30", "99999999999999999999s", "9999999999h", "5µ"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn names() {
        let (picture, mask) = (|name: &str| picture(name.into()), |name: &str| mask(name.into()));
        assert!(picture("a.PNG").is_ok() && picture("a.bmp").is_err() && picture("png").is_err());
        assert!(["a.jpg", "a.JPEG", "a.webp", "a-##.exr"].iter().all(|name| picture(name).is_ok()));
        assert!(mask("a.exr").is_ok() && mask("a.jpg").is_err() && mask("##-##.png").is_err());
        assert!(
            png("a.exr".into()).is_err() && share("0.5") == Ok(0.5) && share("1.1").is_err() && share("nan").is_err()
        );
        let table = |name: &str| points::table(name.into());
        assert!(table("a.CSV").is_ok() && table("a.npy").is_ok() && table("csv").is_err());
    }
}
