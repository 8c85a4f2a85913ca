//! The pixels of the window on the screen.

use crate::painted::{Beside, Painted};
use crate::session::{SCENE, Session, expected, open, open_on, open_with, scene, settle, share_off, start};
use catoptric_gpu::{Context, GpuError};
use catoptric_viewer::app::Viewer;
use egui::{Event, Key, Modifiers, PointerButton, pos2};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use image::imageops;
use libtest_mimic::Trial;
use std::collections::HashMap;
use std::time::Duration;

pub(crate) fn trials() -> Vec<Trial> {
    let mut trials = vec![crate::trial("pixels of the screen are those of the picture, without a device", painted)];
    let reason = match Context::new(None) {
        Ok(_) => {
            trials.extend(crate::overlays::screens());
            trials.extend([
                crate::trial("pixels of the screen are those of the picture", pixels),
                crate::trial("the window's device draws the same, at rest and in motion", on_device),
                crate::trial("a device that nothing waits for", crate::apart::draws_without_waiting),
                crate::trial("the processor draws the window as a device does", beside_device),
            ]);
            return trials;
        }
        Err(error @ GpuError::NoAdapter) => error.to_string(),
        Err(error) => return vec![Trial::test("a device", move || Err(error.to_string().into()))],
    };
    let is_required = std::env::var_os("CATOPTRIC_REQUIRE_GPU").is_some_and(|value| value == "1");
    trials.push(crate::lacking("screen", reason, is_required));
    trials
}

/// The pixels of the picture on the screen, in red, green and blue.
fn shown(session: &mut Session) -> Vec<u8> {
    let rect = session.state().picture_rect();
    let screen = session.render().unwrap();
    if let Some(folder) = std::env::var_os("CATOPTRIC_SCREENSHOTS") {
        screen.save(std::path::Path::new(&folder).join("window.png")).unwrap();
    }
    let [width, height] = session.state().wish().unwrap().size;
    let at = |x: u32, y: u32| screen.get_pixel(rect.left() as u32 + x, rect.top() as u32 + y).0;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels.flat_map(|(x, y)| at(x, y)[..3].to_vec()).collect()
}

/// The mean difference of two pictures' values once both are blurred: of the means of squares of 24 pixels. Drafts are
/// coarse, and show the finest patterns otherwise.
fn blurred_difference(one: &[u8], other: &[u8], width: usize) -> f64 {
    let mut squares = HashMap::<_, (f64, f64)>::new();
    for (index, (one, other)) in one.iter().zip(other).enumerate() {
        let (x, y) = (index / 3 % width, index / 3 / width);
        let difference = f64::from(*one) - f64::from(*other);
        let (sum, count) = squares.entry((x / 24, y / 24, index % 3)).or_default();
        (*sum, *count) = (*sum + difference, *count + 1.0);
    }
    squares.values().map(|(sum, count)| (sum / count).abs()).sum::<f64>() / squares.len() as f64
}

fn painted() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    matches(&mut session);
}

fn pixels() {
    let mut session = open_with(WgpuTestRenderer::new(), None, start(&format!("builtin:{SCENE}"), "auto", None));
    matches(&mut session);
}

/// Compares all of the window, panels and letters too, with many kinds of things in it: a split view, a picked path, a
/// heat map, and the letters at other scales.
fn beside_device() {
    let renderer = Beside { device: WgpuTestRenderer::new(), painted: Painted::default() };
    let start = start(&format!("builtin:{SCENE}"), "environment_map", Some("auto"));
    let mut session = open_with(renderer, None, start);
    session.event(Event::PointerMoved(pos2(400.0, 320.0)));
    for pressed in [true, false] {
        let button = PointerButton::Primary;
        session.event(Event::PointerButton { pos: pos2(400.0, 320.0), button, pressed, modifiers: Modifiers::NONE });
        session.step();
    }
    settle(&mut session, Viewer::is_sharp);
    for _ in 0..30 {
        session.step();
        std::thread::sleep(Duration::from_millis(10));
    }
    compare(&mut session, "picked");
    session.key_press(Key::H);
    session.step();
    settle(&mut session, |viewer| viewer.is_sharp() && viewer.flip_mean().is_some());
    compare(&mut session, "heat");
    for scale in [1.25, 2.0] {
        session.set_pixels_per_point(scale);
        session.step();
        settle(&mut session, Viewer::is_sharp);
        compare(&mut session, &format!("scale {scale}"));
    }
}

/// Compares the two halves of a screen.
fn compare(session: &mut Session, what: &str) {
    let screen = session.render().unwrap();
    if let Some(folder) = std::env::var_os("CATOPTRIC_SCREENSHOTS") {
        screen.save(std::path::Path::new(&folder).join(format!("beside {what}.png"))).unwrap();
    }
    let width = screen.width() / 2;
    let [device, painted] = [0, width].map(|left| {
        let half = imageops::crop_imm(&screen, left, 0, width, screen.height()).to_image();
        half.pixels().flat_map(|pixel| pixel.0[..3].to_vec()).collect::<Vec<u8>>()
    });
    let off = share_off(&painted, &device, 3);
    let furthest = painted.iter().zip(&device).map(|(one, other)| one.abs_diff(*other)).max().unwrap();
    println!("{what}: {:.4} % of pixels off by more than 25 of 255, the furthest by {furthest}", off * 100.0);
    assert!(off < 0.005, "{what}: {off}");
}

/// Compares the screen with the picture that the library draws on the processor.
fn matches(session: &mut Session) {
    session.remove_cursor();
    settle(session, Viewer::is_sharp);
    let wish = session.state().wish().unwrap().clone();
    let expected = expected(&scene(SCENE), &wish, 0).to_srgb8();
    let off = share_off(&shown(session), &expected, 3);
    // The label in the corner covers some.
    let covered = 24.0 * 240.0 / (wish.size[0] * wish.size[1]) as f64;
    assert!(off < 0.005 + covered, "{off}");
}

fn on_device() {
    let device = create_render_state(default_wgpu_setup(), Default::default());
    let mut session = open_on(Some(device), &format!("builtin:{SCENE}"), "multiperspective", None);
    assert!(session.state().processor() != Some("CPU"), "{:?}", session.state().messages().collect::<Vec<_>>());
    matches(&mut session);
    // While the eye moves, textures of the device are shown as they are. It moves to and fro, so that it stays in the
    // room however long a slow machine takes for the first of them.
    for step in 0..20_000 {
        let key = if step % 2 == 0 { Key::A } else { Key::D };
        session.key_down(key);
        session.step();
        session.key_up(key);
        if session.state().picture(0).is_none() {
            break;
        }
        std::thread::sleep(Duration::from_millis(3));
    }
    assert!(session.state().picture(0).is_none(), "no draft was shown");
    let wish = session.state().picture_wish(0).unwrap().clone();
    let expected = expected(&scene(SCENE), &wish, 0).to_srgb8();
    let off = blurred_difference(&shown(&mut session), &expected, wish.size[0] as usize);
    println!("draft: {off:.2} of 255 off once blurred");
    assert!(off < 8.0, "the draft is another picture: {off} of 255 in the mean");
    matches(&mut session);
    // A method that draws on the processor alone.
    session.state_mut().choose(0, "reference").unwrap();
    settle(&mut session, |viewer| viewer.is_sharp() && viewer.processor() == Some("CPU"));
}
