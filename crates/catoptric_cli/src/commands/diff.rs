//! `catoptric diff`: how far two pictures differ.

use super::{columns, pretty};
use crate::args::DiffArgs;
use crate::failure::{Failure, Output};
use crate::terminal::Terminal;
use catoptric::error::SceneError;
use catoptric::framebuffer::{Framebuffer, linear_from_srgb};
use catoptric::metrics::{Comparison, PictureError, heat_map_rgb8};
use catoptric::output;
use catoptric::picture;
use serde::Serialize;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Exit code of pictures that differ more than is allowed.
const TOO_FAR: u8 = 3;

#[derive(Serialize)]
struct Difference<'a> {
    a: &'a Path,
    b: &'a Path,
    size: [u32; 2],
    #[serde(flatten)]
    error: PictureError,
    /// Pixels of which red, green or blue are not the same.
    differing_pixels: usize,
    /// One is linear and was rounded to 8-bit sRGB for the other.
    rounded: Option<&'a Path>,
    max_flip: Option<f64>,
}

pub(crate) fn run(args: &DiffArgs, terminal: &Terminal) -> Result<Output, Failure> {
    let (a, b) = (args.test.as_path(), args.reference.as_path());
    if let Some(heat) = &args.output
        && let Some(input) = [a, b].into_iter().find(|input| output::is_same_file(input, heat))
    {
        return Err(Failure::usage(format!("{}: is both a picture to compare and the output", input.display())));
    }
    let (mut test, mut reference) = (read(a)?, read(b)?);
    let rounded = match (is_linear(a)?, is_linear(b)?) {
        (true, false) => Some((&mut test, a)),
        (false, true) => Some((&mut reference, b)),
        _ => None,
    };
    let rounded = rounded.map(|(picture, path)| {
        *picture = as_png(picture);
        path
    });
    let size = |picture: &Framebuffer| format!("{}x{}", picture.width, picture.height);
    if (test.width, test.height) != (reference.width, reference.height) {
        let (of_a, of_b) = (size(&test), size(&reference));
        let problem = format!("{} has {of_a} pixels, {} has {of_b}: sizes must agree", a.display(), b.display());
        return Err(Failure::input(problem));
    }
    let comparison = Comparison::new(&test, &reference)?;
    let error = comparison.whole().ok_or_else(|| Failure::input(format!("{}: has no pixels", a.display())))?;
    if let Some(path) = &args.output {
        picture::write_rgb8(path, comparison.width, comparison.height, &heat_map_rgb8(&comparison.flip))?;
    }
    let differs = |(a, b): &(&[f32; 4], &[f32; 4])| a[..3] != b[..3];
    let found = Difference {
        a,
        b,
        size: [test.width, test.height],
        error,
        differing_pixels: test.pixels.iter().zip(&reference.pixels).filter(differs).count(),
        rounded,
        max_flip: args.max_flip,
    };
    let is_too_far = args.max_flip.is_some_and(|most| error.flip_mean > most);
    let text = match args.format.json {
        true => pretty(&found)?,
        false => terminal.unless_quiet(as_text(&found, is_too_far)),
    };
    Ok(Output { text, code: if is_too_far { TOO_FAR } else { 0 } })
}

fn read(path: &Path) -> Result<Framebuffer, Failure> {
    Ok(picture::read(path)?)
}

/// True for files of linear radiance: OpenEXR and Radiance HDR, by their first bytes.
pub(super) fn is_linear(path: &Path) -> Result<bool, Failure> {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(4).read_to_end(&mut start));
    read.map_err(|source| SceneError::Read { path: path.into(), source })?;
    Ok(start == [0x76, 0x2f, 0x31, 0x01] || start.starts_with(b"#?"))
}

/// The picture as it comes back from a PNG file.
pub(super) fn as_png(picture: &Framebuffer) -> Framebuffer {
    let bytes = picture.to_srgb8();
    let linear = |byte: u8| linear_from_srgb(f32::from(byte) / 255.0);
    let pixels = bytes.chunks_exact(3).map(|pixel| [linear(pixel[0]), linear(pixel[1]), linear(pixel[2]), 1.0]);
    Framebuffer::of_pixels(picture.width, picture.height, pixels.collect())
}

fn as_text(found: &Difference<'_>, is_too_far: bool) -> String {
    let PictureError { flip_mean, flip_p99, rmse, over_0_1 } = found.error;
    let most = found.max_flip.filter(|_| is_too_far);
    let most = most.map_or_else(String::new, |most| format!("  more than --max-flip {most}"));
    let [width, height] = found.size.map(|side| side as usize);
    let rows = [
        ("FLIP mean", format!("{flip_mean:.5}{most}")),
        ("FLIP p99", format!("{flip_p99:.5}")),
        ("RMSE, linear", format!("{rmse:.6}")),
        ("off by over 0.1", format!("{:.3} % of the pixels", over_0_1 * 100.0)),
        ("different", format!("{} of {} pixels", found.differing_pixels, width * height)),
    ];
    let mut text = columns(&rows.map(|(name, value)| vec![name.to_owned(), value]));
    if let Some(path) = found.rounded {
        text += &format!("{}: linear, compared as the .png that it would be (exposure 0, tone none)\n", path.display());
    }
    text
}
