//! Radiance pictures (`.hdr`): a header of lines of text, then scanlines of colours with a common exponent.
//!
//! After Ward, "Real pixels" (Graphics Gems II, 1991), and the file formats' description that comes with Radiance.

use super::canvas::{Canvas, Radiance};
use super::colors::{Conversion, Primaries};
use glam::DVec2;

/// Scanlines of other lengths are never written component by component.
const COMPONENT_LENGTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// The contents of a header.
struct Header {
    /// The divisor of the file's values.
    exposure: [f64; 3],
    colors: Option<Conversion>,
    axes: Axes,
}

/// The order of a file's pixels: scanlines along one axis, one after the other along the other.
struct Axes {
    width: usize,
    height: usize,
    /// Scanlines are columns.
    columns_first: bool,
    from_right: bool,
    from_bottom: bool,
}

/// The picture in the bytes of a Radiance file.
pub(super) fn read(bytes: &[u8], warnings: &mut Vec<String>) -> Result<Radiance, String> {
    let (header, mut rest) = read_header(bytes)?;
    let Axes { width, height, columns_first, from_right, from_bottom } = header.axes;
    let (lines, length) = if columns_first { (width, height) } else { (height, width) };
    // The shortest scanline is a pixel and its repetitions.
    if rest.len() < lines * 4 {
        return Err(cut_off());
    }
    let mut canvas = Canvas::new(width as u64, height as u64, warnings)?;
    let mut scanline = vec![[0u8; 4]; length];
    for line in 0..lines {
        rest = read_scanline(rest, &mut scanline)?;
        for (place, pixel) in scanline.iter().enumerate() {
            let (x, y) = if columns_first { (line, place) } else { (place, line) };
            let x = if from_right { width - 1 - x } else { x };
            let y = if from_bottom { height - 1 - y } else { y };
            canvas.set(x, y, header.radiance(*pixel));
        }
    }
    Ok(canvas.into_radiance())
}

impl Header {
    fn radiance(&self, [red, green, blue, exponent]: [u8; 4]) -> [f32; 3] {
        // 2 to the power of the exponent less 136, exactly; 0 is black.
        let scale = if exponent == 0 { 0.0 } else { f64::from_bits((u64::from(exponent) + 1023 - 136) << 52) };
        let mut color = [red, green, blue].map(|mantissa| (f64::from(mantissa) * scale) as f32);
        if let Some(colors) = &self.colors {
            color = colors.of(color);
        }
        for (value, exposure) in color.iter_mut().zip(self.exposure) {
            *value = (f64::from(*value) / exposure) as f32;
        }
        color
    }
}

/// The header, and what follows it.
fn read_header(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
    let mut rest = bytes;
    let mut line = || -> Result<String, String> {
        let end = rest.iter().position(|byte| *byte == b'\n').ok_or_else(cut_off)?;
        let line = String::from_utf8_lossy(rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end])).into_owned();
        rest = &rest[end + 1..];
        Ok(line)
    };
    let mut exposure = [1.0f64; 3];
    let (mut is_xyz, mut primaries) = (false, None);
    loop {
        let text = line()?;
        if text.is_empty() {
            break;
        }
        let Some((key, value)) = text.split_once('=').filter(|_| !text.starts_with('#')) else { continue };
        match key.trim() {
            "FORMAT" => match value.trim() {
                "32-bit_rle_rgbe" => is_xyz = false,
                "32-bit_rle_xyze" => is_xyz = true,
                other => return Err(format!("FORMAT={other}: known are 32-bit_rle_rgbe and 32-bit_rle_xyze")),
            },
            // Several lines multiply.
            "EXPOSURE" => {
                let [factor] = numbers(&text, value)?;
                exposure = exposure.map(|so_far| so_far * factor);
            }
            "COLORCORR" => {
                let factors: [f64; 3] = numbers(&text, value)?;
                exposure = std::array::from_fn(|channel| exposure[channel] * factors[channel]);
            }
            "PRIMARIES" => {
                let places: [f64; 8] = numbers(&text, value)?;
                let [red, green, blue, white] =
                    std::array::from_fn(|index| DVec2::new(places[2 * index], places[2 * index + 1]));
                primaries = Some(Primaries { red, green, blue, white });
            }
            _ => {}
        }
    }
    if exposure.iter().any(|factor| !(1e-30..=1e30).contains(factor)) {
        return Err(format!("the product of its EXPOSURE and COLORCORR lines is {exposure:?}; allowed is more than 0"));
    }
    let axes = read_axes(&line()?)?;
    let primaries = if is_xyz { Some(Primaries::XYZ) } else { primaries };
    let colors = primaries.and_then(Primaries::to_rec_709);
    Ok((Header { exposure, colors, axes }, rest))
}

/// The numbers of a header's line.
fn numbers<const N: usize>(line: &str, text: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    <[f64; N]>::try_from(numbers)
        .ok()
        .filter(|numbers| numbers.iter().all(|number| number.is_finite()))
        .ok_or_else(|| format!("header line `{line}`: needs {N} number{}", if N == 1 { "" } else { "s" }))
}

/// Reads a line such as `-Y 512 +X 1024`: the first axis counts scanlines, x to the right and y up.
fn read_axes(line: &str) -> Result<Axes, String> {
    let wrong = || format!("header line `{line}`: must give the size, such as `-Y 512 +X 1024`");
    let words: Vec<&str> = line.split_whitespace().collect();
    let [first, first_count, second, second_count] = words[..] else { return Err(wrong()) };
    let count = |text: &str| text.parse::<u32>().map(|count| count as usize).map_err(|_| wrong());
    let (first_count, second_count) = (count(first_count)?, count(second_count)?);
    let columns_first = first.ends_with('X');
    let [x, y] = if columns_first { [first, second] } else { [second, first] };
    if !["+X", "-X"].contains(&x) || !["+Y", "-Y"].contains(&y) {
        return Err(wrong());
    }
    let (width, height) = if columns_first { (first_count, second_count) } else { (second_count, first_count) };
    super::canvas::check_sides(width as u64, height as u64)?;
    Ok(Axes { width, height, columns_first, from_right: x == "-X", from_bottom: y == "+Y" })
}

/// Reads a scanline in either encoding; what follows it.
fn read_scanline<'a>(bytes: &'a [u8], scanline: &mut [[u8; 4]]) -> Result<&'a [u8], String> {
    match bytes {
        [2, 2, high, low, rest @ ..] if *high < 128 && COMPONENT_LENGTHS.contains(&scanline.len()) => {
            let length = usize::from(*high) << 8 | usize::from(*low);
            if length != scanline.len() {
                return Err(format!("a scanline has {length} pixels where the header says {}", scanline.len()));
            }
            read_components(rest, scanline)
        }
        _ => read_pixels(bytes, scanline),
    }
}

/// Reads the four components one after the other, each as runs and literal bytes.
fn read_components<'a>(mut bytes: &'a [u8], scanline: &mut [[u8; 4]]) -> Result<&'a [u8], String> {
    for component in 0..4 {
        let mut place = 0;
        while place < scanline.len() {
            let (&code, rest) = bytes.split_first().ok_or_else(cut_off)?;
            let is_run = code > 128;
            let count = usize::from(if is_run { code - 128 } else { code });
            if count == 0 || count > scanline.len() - place {
                return Err("is broken: a run ends beyond its scanline; save it again".into());
            }
            let (values, rest) = rest.split_at_checked(if is_run { 1 } else { count }).ok_or_else(cut_off)?;
            for offset in 0..count {
                scanline[place + offset][component] = values[if is_run { 0 } else { offset }];
            }
            (place, bytes) = (place + count, rest);
        }
    }
    Ok(bytes)
}

/// Reads pixels as they are, or with the repetitions of the older encoding: 1, 1, 1 and a count, of which following
/// ones are more significant.
fn read_pixels<'a>(mut bytes: &'a [u8], scanline: &mut [[u8; 4]]) -> Result<&'a [u8], String> {
    let (mut place, mut shift) = (0usize, 0u32);
    while place < scanline.len() {
        let (pixel, rest) = bytes.split_first_chunk::<4>().ok_or_else(cut_off)?;
        bytes = rest;
        if pixel[..3] != [1; 3] {
            scanline[place] = *pixel;
            (place, shift) = (place + 1, 0);
            continue;
        }
        let count = usize::from(pixel[3]).checked_shl(shift).unwrap_or(usize::MAX);
        if place == 0 || count > scanline.len() - place || shift > 24 {
            return Err("is broken: a repetition ends beyond its scanline; save it again".into());
        }
        let last = scanline[place - 1];
        scanline[place..place + count].fill(last);
        (place, shift) = (place + count, shift + 8);
    }
    Ok(bytes)
}

fn cut_off() -> String {
    "ends too early: it is cut off; save or download it again".into()
}
