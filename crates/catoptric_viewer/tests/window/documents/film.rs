//! The moving picture of the README, made where `CATOPTRIC_FILM` names its file (`.png`): the split view, with the eye
//! and the divider in motion.

use crate::session::{Start, open_as, settle};
use catoptric_viewer::app::Viewer;
use egui::{Event, Modifiers, PointerButton, pos2, vec2};
use image::RgbaImage;
use libtest_mimic::Trial;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

const FRAMES: usize = 24;

/// Milliseconds that a frame is shown.
const FRAME_MS: u16 = 110;

/// Levels of each channel: fewer make smaller files.
const LEVELS: f32 = 31.0;

pub(crate) fn trials() -> Vec<Trial> {
    let Some(path) = std::env::var_os("CATOPTRIC_FILM").map(PathBuf::from) else { return Vec::new() };
    vec![Trial::test("the film of the README", move || {
        film(&path);
        Ok(())
    })]
}

fn film(path: &Path) {
    let start =
        Start { panels: false, ..crate::session::start("builtin:sphere_room", "environment_map", Some("auto")) };
    let mut session = open_as(None, start);
    session.set_size(vec2(496.0, 326.0));
    session.remove_cursor();
    let mut frames: Vec<RgbaImage> = Vec::new();
    for frame in 0..FRAMES {
        // There and back again: the eye turns, and the divider is drawn to the left and to the right.
        let angle = frame as f32 / FRAMES as f32 * std::f32::consts::TAU;
        let rect = session.state().picture_rect();
        let middle = rect.center() + vec2(0.0, 60.0);
        let by = vec2(8.0 * angle.cos(), 0.0);
        drag(&mut session, middle + vec2(-60.0, 0.0), by);
        session.state_mut().set_divider(0.5 + 0.22 * angle.sin());
        session.remove_cursor();
        settle(&mut session, Viewer::is_sharp);
        let rect = session.state().picture_rect();
        let [left, top, width, height] = [rect.left(), rect.top(), rect.width(), rect.height()].map(|at| at as u32);
        frames.push(image::imageops::crop_imm(&session.render().unwrap(), left, top, width, height).to_image());
    }
    write(path, &frames);
}

fn drag(session: &mut crate::session::Session, from: egui::Pos2, by: egui::Vec2) {
    let button = |at, pressed| Event::PointerButton {
        pos: at,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    session.event(Event::PointerMoved(from));
    session.event(button(from, true));
    session.step();
    // Beyond what counts as a click first, then where it is to end.
    for at in [from + vec2(0.0, 7.0), from, from + by] {
        session.event(Event::PointerMoved(pos2(at.x, at.y)));
        session.step();
    }
    session.event(button(from + by, false));
    session.step();
}

/// Writes an animated PNG.
fn write(path: &Path, frames: &[RgbaImage]) {
    let (width, height) = frames[0].dimensions();
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path).unwrap()), width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.set_animated(frames.len() as u32, 0).unwrap();
    encoder.set_frame_delay(FRAME_MS, 1000).unwrap();
    let mut writer = encoder.write_header().unwrap();
    for frame in frames {
        let level = |value: u8| ((f32::from(value) / 255.0 * LEVELS).round() / LEVELS * 255.0).round() as u8;
        let rgb: Vec<u8> = frame.pixels().flat_map(|pixel| [0, 1, 2].map(|channel| level(pixel.0[channel]))).collect();
        writer.write_image_data(&rgb).unwrap();
    }
    writer.finish().unwrap();
}
