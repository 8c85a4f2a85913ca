//! What is seen on the screen.

use crate::session::{SCENE, Session, expected, open, open_on, scene, settle, share_off};
use catoptric_gpu::{Context, GpuError};
use catoptric_viewer::app::Viewer;
use egui::Key;
use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};
use libtest_mimic::Trial;
use std::collections::HashMap;
use std::time::Duration;

pub(crate) fn trials() -> Vec<Trial> {
    let reason = match Context::new(None) {
        Ok(_) => {
            return vec![
                crate::trial("pixels of the screen are those of the picture", pixels),
                crate::trial("the window's device draws the same, at rest and in motion", on_device),
                crate::trial("a device that nothing waits for", crate::apart::draws_without_waiting),
            ];
        }
        Err(error @ GpuError::NoAdapter) => error.to_string(),
        Err(error) => return vec![Trial::test("a device", move || Err(error.to_string().into()))],
    };
    let is_required = std::env::var_os("CATOPTRIC_REQUIRE_GPU").is_some_and(|value| value == "1");
    let trial = Trial::test(format!("screen ({reason})"), move || Err(reason.into()));
    vec![trial.with_ignored_flag(!is_required)]
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

fn pixels() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    matches(&mut session);
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
