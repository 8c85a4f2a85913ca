//! Readers of option values; each message names what is allowed.

mod pictures;
mod points;
mod stream;

pub(crate) use pictures::{FramesWanted, NamePattern, Region, frames_per_second, frames_wanted, region};
pub(crate) use points::{Grid, JSON_LINES, PointSource, camera_path, is_camera, points, table_path};
pub(crate) use stream::{FileOrStream, file, file_or_stream, place};

use catoptric::picture::PictureFormat;
use catoptric_scenes::import::EnvironmentEdit;
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::{DVec3, Vec3};
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

/// The longest side of a picture.
const MAX_SIDE: u32 = 16_384;
/// The most pixels of a picture.
const MAX_PIXELS: u64 = 1 << 27;
/// Coordinates and times beyond this are taken for slips.
const MAX_NUMBER: f32 = 1e9;
/// Longer times are taken for slips.
const MAX_SECS: u64 = 366 * 24 * 3600;

pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |part: &str| {
        let side = part.trim().parse::<u32>().map_err(|_| format!("`{part}` is not a whole number"))?;
        if (1..=MAX_SIDE).contains(&side) { Ok(side) } else { Err(format!("a side must be 1 to {MAX_SIDE} pixels")) }
    };
    let (width, height) = text.split_once(['x', 'X']).ok_or("write it as WxH, such as 1280x720")?;
    let size = [side(width)?, side(height)?];
    if u64::from(size[0]) * u64::from(size[1]) > MAX_PIXELS {
        return Err(format!("more than {MAX_PIXELS} pixels"));
    }
    Ok(size)
}

pub(crate) fn number(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if value.abs() <= MAX_NUMBER => Ok(value),
        Ok(_) => Err(format!("`{text}` is not between -1e9 and 1e9")),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

/// An angle by which the environment is turned, in degrees.
pub(crate) fn rotation(text: &str) -> Result<f64, String> {
    let most = EnvironmentEdit::MOST_ROTATION_DEG;
    number_within(text, -most..=most)
}

/// A factor for the environment's light.
pub(crate) fn strength(text: &str) -> Result<f64, String> {
    number_within(text, 0.0..=EnvironmentEdit::MOST_STRENGTH)
}

fn number_within(text: &str, allowed: RangeInclusive<f64>) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if allowed.contains(&value) => Ok(value),
        Ok(_) => Err(format!("`{text}` is not between {} and {}", allowed.start(), allowed.end())),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

pub(crate) fn vector(text: &str) -> Result<Vec3, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<f32>, String>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err("write it as X,Y,Z, such as -2,1,3".into()),
    }
}

/// A vector in double precision.
pub(crate) fn exact_vector(text: &str) -> Result<DVec3, String> {
    vector(text)?;
    let numbers = text.split(',').map(|part| part.trim().parse().map_err(|_| format!("`{part}` is not a number")));
    let numbers = numbers.collect::<Result<Vec<f64>, String>>()?;
    Ok(DVec3::from_slice(&numbers))
}

pub(crate) fn field_of_view(text: &str) -> Result<f32, String> {
    let degrees = number(text)?;
    if (0.1..=179.0).contains(&degrees) { Ok(degrees) } else { Err("it must be 0.1 to 179 degrees".into()) }
}

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

pub(crate) fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().into(), value.trim().into())),
        _ => Err("write it as KEY=VALUE".into()),
    }
}

/// The highest order of paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// What the scene needs.
    Auto,
    Exact(u32),
}

/// How bright PNG pictures are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Exposure {
    /// The mean of what is seen before the background becomes middle grey.
    Auto,
    /// In stops.
    Stops(f32),
}

pub(crate) fn order(text: &str) -> Result<Order, String> {
    match text.parse() {
        _ if text == "auto" => Ok(Order::Auto),
        Ok(order @ 0..=16) => Ok(Order::Exact(order)),
        _ => Err("it must be `auto` or a whole number from 0 to 16".into()),
    }
}

pub(crate) fn exposure(text: &str) -> Result<Exposure, String> {
    match text.parse::<f32>() {
        _ if text == "auto" => Ok(Exposure::Auto),
        Ok(stops) if stops.abs() <= 30.0 => Ok(Exposure::Stops(stops)),
        _ => Err("it must be `auto` or a number of stops from -30 to 30".into()),
    }
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
    let path = stream::no_stream(path)?;
    match PictureFormat::from_path(&path) {
        Some(PictureFormat::Png) => Ok(path),
        _ => Err("the name must end in .png".into()),
    }
}

fn mask(path: PathBuf) -> Result<PathBuf, String> {
    let path = stream::no_stream(path)?;
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
    fn orders_and_exposures() {
        assert_eq!(
            (order("auto"), order("0"), order("16")),
            (Ok(Order::Auto), Ok(Order::Exact(0)), Ok(Order::Exact(16)))
        );
        assert!(["17", "-1", "two", ""].iter().all(|wrong| order(wrong).is_err()));
        assert_eq!((exposure("auto"), exposure("-1.5")), (Ok(Exposure::Auto), Ok(Exposure::Stops(-1.5))));
        assert!(["nan", "inf", "31", "bright"].iter().all(|wrong| exposure(wrong).is_err()));
    }

    #[test]
    fn times() {
        assert_eq!(duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("1h30m"), Ok(Duration::from_secs(5400)));
        for wrong in ["", "90", "m", "1d", "-5m", "1h30", "99999999999999999999s", "9999999999h", "5µ"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes() {
        assert_eq!(size("64x48"), Ok([64, 48]));
        assert_eq!(size("16384x1"), Ok([16384, 1]));
        for wrong in ["0x1", "1x16385", "64", "64x", "-1x4", "16384x16384", "1e3x2", ""] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn vectors() {
        assert_eq!(vector("-2,1.5, 3e0"), Ok(Vec3::new(-2.0, 1.5, 3.0)));
        for wrong in ["1,2", "1,2,3,4", "a,b,c", "nan,0,0", "inf,0,0", "1e30,0,0", ""] {
            assert!(vector(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn exact_vectors_keep_all_digits() {
        assert_eq!(exact_vector("-0.1, 2e-3,3"), Ok(DVec3::new(-0.1, 2e-3, 3.0)));
        assert!(exact_vector("1,2").is_err() && exact_vector("1,2,inf").is_err());
    }

    #[test]
    fn pairs_and_names() {
        assert_eq!(key_value("a = b=c"), Ok(("a".into(), "b=c".into())));
        assert!(key_value("a").is_err() && key_value("=a").is_err());
        let (picture, mask) = (|name: &str| picture(name.into()), |name: &str| mask(name.into()));
        assert!(picture("a.PNG").is_ok() && picture("a.bmp").is_err() && picture("png").is_err());
        assert!(["a.jpg", "a.JPEG", "a.webp", "a-##.exr"].iter().all(|name| picture(name).is_ok()));
        assert!(mask("a.exr").is_ok() && mask("a.jpg").is_err() && mask("##-##.png").is_err());
        assert!(
            png("a.exr".into()).is_err() && share("0.5") == Ok(0.5) && share("1.1").is_err() && share("nan").is_err()
        );
        let table = |name: &str| points::table(name.into());
        assert!(table("a.CSV").is_ok() && table("a.npy").is_ok() && table("csv").is_err());
        assert!(field_of_view("0").is_err() && field_of_view("180").is_err() && field_of_view("40").is_ok());
    }
}
