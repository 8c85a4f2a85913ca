//! The pictures of the window in docs/viewer.md, made where `CATOPTRIC_SCREENSHOTS_OF_DOCS` names their folder.

use crate::session::{Session, Start, click, open_as, settle, start, steps};
use catoptric_viewer::app::Viewer;
use catoptric_viewer::studio::order::{Opening, Source};
use egui::{Event, Key, Modifiers, PointerButton, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use image::{RgbaImage, imageops};
use libtest_mimic::Trial;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// The window's size but for narrow ones.
const SIZE: Vec2 = vec2(916.0, 716.0);

/// The harness's margin around the window's content.
const MARGIN: u32 = 8;

/// Levels of each channel: fewer make smaller files.
const LEVELS: f32 = 25.0;

/// Colours of a picture: fewer make smaller files.
const COLORS: usize = 128;

/// Brings a window into a state.
type Make = fn() -> Session;

/// Larger files are refused.
const MOST_BYTES: u64 = 150_000;

pub(crate) fn trials() -> Vec<Trial> {
    let Some(folder) = std::env::var_os("CATOPTRIC_SCREENSHOTS_OF_DOCS").map(PathBuf::from) else { return Vec::new() };
    let all: [(&str, Make); 12] = [
        ("01-first", first),
        ("02-split", split),
        ("03-heat", heat),
        ("04-picked", picked),
        ("05-moved", moved),
        ("06-sky", sky),
        ("07-glass", glass),
        ("08-save", save),
        ("09-not-opened", not_opened),
        ("10-light-panels", light_panels),
        ("11-phone", phone),
        ("12-phone-controls", phone_controls),
    ];
    let picture = move |(name, make): (&str, Make)| {
        let path = folder.join(format!("viewer-{name}.png"));
        Trial::test(format!("screenshot {name}"), move || {
            let mut session = make();
            session.remove_cursor();
            steps(&mut session, 2);
            write(&path, &session.render()?);
            Ok(())
        })
    };
    all.into_iter().map(picture).collect()
}

fn window(start: Start) -> Session {
    let mut session = open_as(None, start);
    session.state_mut().ask_in_window();
    session.set_size(SIZE);
    settle(&mut session, Viewer::is_sharp);
    session
}

fn of(scene: &str, against: Option<&str>) -> Session {
    window(Start { order: None, ..start(scene, "auto", against) })
}

fn first() -> Session {
    of("builtin:sphere_room", None)
}

fn split() -> Session {
    window(start("builtin:sphere_room", "environment_map", Some("auto")))
}

fn heat() -> Session {
    let mut session = window(start("builtin:sphere_room", "environment_map", Some("reference")));
    session.key_press(Key::H);
    settle(&mut session, |viewer| viewer.is_sharp() && viewer.flip_mean().is_some());
    session
}

fn picked() -> Session {
    let mut session = window(start("builtin:sphere_room", "auto", None));
    let at = session.state().picture_rect().center() + vec2(40.0, 30.0);
    click(&mut session, at);
    settle(&mut session, |viewer| viewer.places().is_some_and(|places| places.is_done));
    steps(&mut session, 60);
    session
}

fn moved() -> Session {
    let mut session = of("builtin:sphere_room", None);
    session.key_press(Key::M);
    let middle = session.state().picture_rect().center();
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    session.event(Event::PointerMoved(middle));
    session.event(Event::PointerButton { pos: middle, button, pressed: true, modifiers });
    for step in 1..=40 {
        session.event(Event::PointerMoved(middle + vec2(2.0 * step as f32, 0.0)));
        steps(&mut session, 1);
    }
    settle(&mut session, |viewer| viewer.wish().is_some_and(|wish| !wish.changes.moves.is_empty()));
    settle(&mut session, Viewer::is_sharp);
    session
}

fn sky() -> Session {
    let opening = Opening { environment: Some("sky".into()), ..Opening::default() };
    window(Start { opening, order: None, ..start("builtin:two_spheres", "auto", None) })
}

fn glass() -> Session {
    of("builtin:glass_sphere", Some("reference"))
}

fn save() -> Session {
    let mut session = of("builtin:vase", None);
    session.key_press_modifiers(Modifiers::COMMAND, Key::S);
    steps(&mut session, 3);
    session.key_press_modifiers(Modifiers::COMMAND, Key::A);
    session.event(Event::Text("/missing/vase-2.toml".into()));
    steps(&mut session, 2);
    session.key_press(Key::Enter);
    steps(&mut session, 4);
    session
}

fn not_opened() -> Session {
    let mut session = of("builtin:sphere_room", None);
    session.state_mut().open(Source::File("/home/visitor/downloads/models/collection/vase.glb".into()));
    settle(&mut session, |viewer| viewer.messages().any(|message| message.contains("vase.glb")));
    steps(&mut session, 4);
    session
}

fn light_panels() -> Session {
    let mut session = of("builtin:dish", None);
    session.get_by_label("light panels").click();
    steps(&mut session, 4);
    session
}

fn phone() -> Session {
    let mut session = of("builtin:sphere_room", Some("reference"));
    session.set_size(vec2(390.0, 700.0));
    settle(&mut session, Viewer::is_sharp);
    session
}

fn phone_controls() -> Session {
    let mut session = phone();
    session.get_by_label("Controls").click();
    steps(&mut session, 30);
    settle(&mut session, Viewer::is_sharp);
    session
}

/// Writes a small PNG, of few colours.
fn write(path: &Path, picture: &RgbaImage) {
    let picture =
        imageops::crop_imm(picture, MARGIN, MARGIN, picture.width() - 2 * MARGIN, picture.height() - 2 * MARGIN);
    let picture = picture.to_image();
    let level = |value: u8| ((f32::from(value) / 255.0 * LEVELS).round() / LEVELS * 255.0).round() as u8;
    let colors: Vec<[u8; 3]> = picture.pixels().map(|pixel| [0, 1, 2].map(|channel| level(pixel.0[channel]))).collect();
    let mut counts: BTreeMap<[u8; 3], usize> = BTreeMap::new();
    colors.iter().for_each(|color| *counts.entry(*color).or_default() += 1);
    let distance = |one: &[u8; 3], other: &[u8; 3]| -> u32 {
        one.iter().zip(other).map(|(a, b)| u32::from(a.abs_diff(*b)).pow(2)).sum()
    };
    // One after the other those that are common and far from all before.
    let mut left: Vec<(f64, [u8; 3], u32)> =
        counts.iter().map(|(color, count)| ((*count as f64).sqrt(), *color, u32::MAX)).collect();
    let mut palette: Vec<[u8; 3]> = Vec::new();
    while palette.len() < COLORS.min(counts.len()) {
        let score = |(weight, _, distance): &(f64, [u8; 3], u32)| weight * f64::from(*distance);
        let (_, next, _) = *left.iter().max_by(|one, other| score(one).total_cmp(&score(other))).unwrap();
        left.iter_mut().for_each(|(_, color, nearest)| *nearest = (*nearest).min(distance(color, &next)));
        palette.push(next);
    }
    let nearest = |color: &[u8; 3]| (0..palette.len()).min_by_key(|index| distance(color, &palette[*index])).unwrap();
    let indices: BTreeMap<[u8; 3], u8> = counts.keys().map(|color| (*color, nearest(color) as u8)).collect();
    let bytes: Vec<u8> = colors.iter().map(|color| indices[color]).collect();
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path).unwrap()), picture.width(), picture.height());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.concat());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
    let bytes = std::fs::metadata(path).unwrap().len();
    assert!(bytes <= MOST_BYTES, "{}: {bytes} bytes", path.display());
}
