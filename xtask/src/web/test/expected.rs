//! Pictures that pages are held to: drawn by the program `catoptric`, which draws as the library does. It is built
//! first, unless `CATOPTRIC_PROGRAM` names one.

use crate::command::run;
use anyhow::{Context, Result, ensure};
use png::{Decoder, Transformations};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::process::Command;

/// Settings of a method by their names.
pub(super) type Settings = BTreeMap<&'static str, Value>;

/// An opaque picture.
pub(super) struct Picture {
    width: usize,
    /// Numbers a pixel, of which the first three are red, green and blue.
    channels: usize,
    /// Rows from the top.
    bytes: Vec<u8>,
}

impl Picture {
    /// The picture in a PNG file with colours.
    pub(super) fn read(file: &[u8]) -> Result<Self> {
        let mut decoder = Decoder::new(Cursor::new(file));
        decoder.set_transformations(Transformations::normalize_to_color8());
        let mut reader = decoder.read_info().context("no PNG")?;
        let mut bytes = vec![0; reader.output_buffer_size().context("a large PNG")?];
        let info = reader.next_frame(&mut bytes).context("no PNG")?;
        let channels = info.color_type.samples();
        ensure!(channels >= 3, "a PNG without colours");
        Ok(Self { width: info.width as usize, channels, bytes })
    }

    /// Red, green and blue of a pixel.
    pub(super) fn pixel(&self, x: u32, y: u32) -> &[u8] {
        let start = (y as usize * self.width + x as usize) * self.channels;
        &self.bytes[start..start + 3]
    }
}

/// Names the program where it is built already.
const PROGRAM: &str = "CATOPTRIC_PROGRAM";

/// Builds the program, unless one is named.
pub(super) fn build() -> Result<()> {
    if std::env::var_os(PROGRAM).is_some() {
        return Ok(());
    }
    run(Command::new(env!("CARGO")).args(["build", "--locked", "-p", "catoptric_cli"]))
}

fn program() -> Command {
    if let Some(path) = std::env::var_os(PROGRAM) {
        return Command::new(path);
    }
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--locked", "--quiet", "-p", "catoptric_cli", "--"]);
    cargo
}

/// A method's picture of the room, as the page's camera sees it.
pub(super) fn drawn(method: &str, settings: &Settings, camera: &Value, [width, height]: [u32; 2]) -> Result<Picture> {
    let place: Vec<f64> = camera["place"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    // The columns of a matrix: to the right, upward, backward, and the eye.
    let place: [f64; 12] = place.try_into().ok().context("no place of the camera")?;
    let target = [0, 1, 2].map(|axis| place[9 + axis] - place[6 + axis]);
    let fov_y = camera["fov_y"].as_f64().context("no field of view")?;
    let vector = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let folder = tempfile::tempdir().context("no folder for a picture")?;
    let path = folder.path().join("picture.png");
    let mut program = program();
    program.args(["render", "builtin:sphere_room", "--quiet", "--backend", "cpu", "--samples", "4", "--order", "2"]);
    program.args(["--size", &format!("{width}x{height}")]);
    program.args(["--eye", &vector(&place[9..]), "--target", &vector(&target), "--up", &vector(&place[3..6])]);
    program.args(["--fov", &fov_y.to_degrees().to_string(), "--method", method]);
    for (name, value) in settings {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        program.args(["--set", &format!("{name}={value}")]);
    }
    run(program.arg("-o").arg(&path))?;
    Picture::read(&std::fs::read(&path).context("no picture was written")?)
}
