//! Readers of option values; each message names what is allowed.

use catoptric_scenes::import::EnvironmentEdit;
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::{DVec3, Vec3};
use std::ffi::OsStr;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// The word for a standard stream.
pub const STREAM: &str = "-";
/// The longest side of a picture.
const MAX_SIDE: u32 = 16_384;
/// The most pixels of a picture.
const MAX_PIXELS: u64 = 1 << 27;
/// Coordinates and times beyond this are taken for slips.
const MAX_NUMBER: f32 = 1e9;

/// Reads the size of a picture, `WxH`, in pixels.
///
/// # Errors
/// Words about what is allowed.
pub fn size(text: &str) -> Result<[u32; 2], String> {
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

/// Reads a number.
///
/// # Errors
/// Words about what is allowed.
pub fn number(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(value) if value.abs() <= MAX_NUMBER => Ok(value),
        Ok(_) => Err(format!("`{text}` is not between -1e9 and 1e9")),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

/// An angle by which the environment is turned, in degrees.
///
/// # Errors
/// Words about what is allowed.
pub fn rotation(text: &str) -> Result<f64, String> {
    let most = EnvironmentEdit::MOST_ROTATION_DEG;
    number_within(text, -most..=most)
}

/// A factor for the environment's light.
///
/// # Errors
/// Words about what is allowed.
pub fn strength(text: &str) -> Result<f64, String> {
    number_within(text, 0.0..=EnvironmentEdit::MOST_STRENGTH)
}

fn number_within(text: &str, allowed: RangeInclusive<f64>) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if allowed.contains(&value) => Ok(value),
        Ok(_) => Err(format!("`{text}` is not between {} and {}", allowed.start(), allowed.end())),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

/// Reads a vector, `X,Y,Z`.
///
/// # Errors
/// Words about what is allowed.
pub fn vector(text: &str) -> Result<Vec3, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<f32>, String>>()?;
    match numbers[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err("write it as X,Y,Z, such as -2,1,3".into()),
    }
}

/// A vector in double precision.
///
/// # Errors
/// Words about what is allowed.
pub fn exact_vector(text: &str) -> Result<DVec3, String> {
    vector(text)?;
    let numbers = text.split(',').map(|part| part.trim().parse().map_err(|_| format!("`{part}` is not a number")));
    let numbers = numbers.collect::<Result<Vec<f64>, String>>()?;
    Ok(DVec3::from_slice(&numbers))
}

/// Reads a field of view, in degrees.
///
/// # Errors
/// Words about what is allowed.
pub fn field_of_view(text: &str) -> Result<f32, String> {
    let degrees = number(text)?;
    if (0.1..=179.0).contains(&degrees) { Ok(degrees) } else { Err("it must be 0.1 to 179 degrees".into()) }
}

/// Reads a setting, `KEY=VALUE`.
///
/// # Errors
/// Words about how it is written.
pub fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().into(), value.trim().into())),
        _ => Err("write it as KEY=VALUE".into()),
    }
}

/// The highest order of paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The order that the scene needs.
    Auto,
    /// This one.
    Exact(u32),
}

/// How bright PNG pictures are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// The mean of what is seen before the background becomes middle grey.
    Auto,
    /// In stops.
    Stops(f32),
}

/// Reads the highest order of paths.
///
/// # Errors
/// Words about what is allowed.
pub fn order(text: &str) -> Result<Order, String> {
    match text.parse() {
        _ if text == "auto" => Ok(Order::Auto),
        Ok(order @ 0..=16) => Ok(Order::Exact(order)),
        _ => Err("it must be `auto` or a whole number from 0 to 16".into()),
    }
}

/// Reads an exposure: `auto`, or stops.
///
/// # Errors
/// Words about what is allowed.
pub fn exposure(text: &str) -> Result<Exposure, String> {
    match text.parse::<f32>() {
        _ if text == "auto" => Ok(Exposure::Auto),
        Ok(stops) if stops.abs() <= 30.0 => Ok(Exposure::Stops(stops)),
        _ => Err("it must be `auto` or a number of stops from -30 to 30".into()),
    }
}

/// Reads a file or folder.
pub fn file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(no_stream)
}

/// Refuses `-`.
///
/// # Errors
/// Words about how a file of that name is written.
pub fn no_stream<T: AsRef<OsStr>>(name: T) -> Result<T, &'static str> {
    match name.as_ref() == STREAM {
        true => Err("no standard stream can stand here; `./-` names a file called `-`"),
        false => Ok(name),
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
    fn pairs_and_fields_of_view() {
        assert_eq!(key_value("a = b=c"), Ok(("a".into(), "b=c".into())));
        assert!(key_value("a").is_err() && key_value("=a").is_err());
        assert!(field_of_view("0").is_err() && field_of_view("180").is_err() && field_of_view("40").is_ok());
    }
}
