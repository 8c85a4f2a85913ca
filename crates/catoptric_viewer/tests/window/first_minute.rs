//! The first minute of a stranger: opens, saves, clicks, takes back, and has a small window.

use crate::session::{SCENE, Session, click, open, scene, settle, steps};
use crate::trial;
use catoptric_viewer::app::Viewer;
use catoptric_viewer::studio::order::Source;
use egui::{Event, Key, Modifiers, PointerButton, ViewportCommand, vec2};
use egui_kittest::kittest::Queryable;
use libtest_mimic::Trial;
use std::path::Path;

pub(crate) fn trials() -> Vec<Trial> {
    vec![
        trial("without dialogues paths are asked for in the window", asked_in_window),
        trial("changes are taken back by keys", undone),
        trial("a double click has the view turn about a point, which stays where it is", focused),
        trial("clicks, messages and failures leave the picture where it is", picture_stays),
        trial("what cannot be opened is a card with a way on", card),
        trial("in narrow windows the picture comes first", narrow),
        trial("a report on what is done, and hints that are true", hints),
    ]
}

fn window() -> Session {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    session.state_mut().ask_in_window();
    session
}

fn said(session: &Session, words: &str) -> bool {
    session.state().messages().any(|message| message.contains(words))
}

/// Types a path into the field that has the keyboard, in place of what is there, and presses Enter.
fn answer(session: &mut Session, path: &Path) {
    steps(session, 3);
    session.key_press_modifiers(Modifiers::COMMAND, Key::A);
    session.event(Event::Text(path.display().to_string()));
    steps(session, 2);
    session.key_press(Key::Enter);
    steps(session, 3);
}

fn asked_in_window() {
    let folder = tempfile::tempdir().unwrap();
    let mut session = window();
    session.key_press_modifiers(Modifiers::COMMAND, Key::S);
    steps(&mut session, 3);
    session.get_by_label("Save as .toml");
    // A save that cannot be done says why, and asks again.
    answer(&mut session, &folder.path().join("missing/room.toml"));
    session.get_by_label_contains("there is no folder");
    let file = folder.path().join("room.toml");
    answer(&mut session, &file);
    settle(&mut session, |viewer| viewer.messages().any(|message| message.starts_with("saved to ")));
    assert!(std::fs::read_to_string(&file).unwrap().contains("builtin:sphere_room"));
    assert!(session.query_by_label("Save as .toml").is_none());
    // The picture, by the button; the name is completed.
    session.get_by_label("Save PNG").click();
    steps(&mut session, 3);
    answer(&mut session, &folder.path().join("picture"));
    let picture = folder.path().join("picture.png");
    settle(&mut session, |_| picture.is_file());
    let [width, height] = session.state().wish().unwrap().size;
    assert_eq!(image::open(&picture).unwrap().into_rgb8().dimensions(), (width, height));
    // The saved file is opened.
    session.key_press_modifiers(Modifiers::COMMAND, Key::O);
    steps(&mut session, 3);
    answer(&mut session, &folder.path().join("nothing.glb"));
    session.get_by_label_contains("there is no such file");
    answer(&mut session, &file);
    settle(&mut session, |viewer| viewer.scene_name().is_some_and(|name| name.ends_with("room.toml")));
    // Nobody is asked any more, and Escape would have done.
    session.key_press_modifiers(Modifiers::COMMAND, Key::O);
    steps(&mut session, 3);
    session.key_press(Key::Escape);
    steps(&mut session, 3);
    assert!(session.query_by_label("Cancel").is_none());
}

fn undone() {
    let mut session = window();
    let middle = session.state().picture_rect().center();
    click(&mut session, middle);
    settle(&mut session, |_| true);
    while session.query_by_label("glass").is_none() {
        steps(&mut session, 1);
        std::thread::sleep(std::time::Duration::from_millis(3));
    }
    steps(&mut session, 40);
    session.get_by_label("glass").click();
    let roles = |viewer: &Viewer| viewer.wish().map_or(0, |wish| wish.changes.roles.len());
    settle(&mut session, |viewer| roles(viewer) == 1);
    steps(&mut session, 2);
    session.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut session, |viewer| roles(viewer) == 0);
    session.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    settle(&mut session, |viewer| roles(viewer) == 1);
    session.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut session, |viewer| roles(viewer) == 0);
    session.key_press_modifiers(Modifiers { shift: true, ..Modifiers::COMMAND }, Key::Z);
    settle(&mut session, |viewer| roles(viewer) == 1);
}

fn focused() {
    let mut session = window();
    let before = session.state().wish().unwrap().camera.clone();
    let at = session.state().picture_rect().center() + vec2(15.0, 10.0);
    click(&mut session, at);
    click(&mut session, at);
    settle(&mut session, |viewer| viewer.messages().any(|message| message.contains("dragging turns about")));
    assert_eq!(session.state().wish().unwrap().camera, before);
    // The ball's point under the pointer is the middle of the turn.
    let room = scene(SCENE);
    let [width, height] = session.state().wish().unwrap().size;
    let view = room.view(&before, width, height);
    let rect = session.state().picture_rect();
    let ray = view.ray(at.x - rect.left(), at.y - rect.top());
    let tracer = catoptric::light::tracer::Tracer::build(&room, |_| true);
    let hit = tracer.first_hit(&room, &ray, 0.0).unwrap();
    let point = tracer.point(&room, &ray, &hit).position;
    session.event(Event::PointerMoved(at));
    let button = |pressed, pos| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    session.event(button(true, at));
    for step in 1..=8 {
        session.event(Event::PointerMoved(at + vec2(5.0 * step as f32, 0.0)));
        session.step();
    }
    session.event(button(false, at + vec2(40.0, 0.0)));
    settle(&mut session, Viewer::is_sharp);
    let after = session.state().wish().unwrap().camera.clone();
    let distance =
        |camera: &catoptric::scene::Camera| glam::Vec3::from(camera.world_from_camera.translation).distance(point);
    assert!(after != before && (distance(&after) - distance(&before)).abs() < 1e-3 * distance(&before));
}

fn picture_stays() {
    let mut session = window();
    let before = session.state().picture_rect();
    let stays = |session: &mut Session, what: &str| {
        for _ in 0..40 {
            session.step();
            assert_eq!(session.state().picture_rect(), before, "{what}");
        }
    };
    click(&mut session, before.center());
    settle(&mut session, |viewer| viewer.places().is_some_and(|places| places.is_done));
    stays(&mut session, "a click");
    let long = format!("/somewhere/{}/scene.glb", "a_very_long_folder_name/".repeat(12));
    session.state_mut().open(Source::File(long.into()));
    settle(&mut session, |viewer| viewer.messages().any(|message| message.contains("a_very_long_folder_name")));
    stays(&mut session, "a file that is missing");
    session.get_by_label("Close").click();
    stays(&mut session, "the card is closed");
    session.key_press(Key::Escape);
    stays(&mut session, "nothing is picked");
    session.get_by_label("Copy command").click();
    stays(&mut session, "a command is copied");
    assert!(said(&session, "copied: catoptric render "));
}

fn card() {
    let mut session = window();
    session.state_mut().open(Source::File("/nowhere/vase.glb".into()));
    settle(&mut session, |viewer| viewer.messages().any(|message| message.contains("vase.glb")));
    steps(&mut session, 3);
    session.get_by_label("This was not opened");
    assert!(session.query_all_by_label("Open...").count() >= 2);
    session.get_by_label("dish").click();
    let titles = |session: &Session| -> Vec<String> {
        let commands = session.output().viewport_output.values().flat_map(|output| output.commands.iter());
        let title = |command: &ViewportCommand| match command {
            ViewportCommand::Title(title) => Some(title.clone()),
            _ => None,
        };
        commands.filter_map(title).collect()
    };
    let mut named = Vec::new();
    while session.state().scene_name() != Some("builtin:dish") {
        steps(&mut session, 1);
        named.extend(titles(&session));
        std::thread::sleep(std::time::Duration::from_millis(3));
    }
    assert!(named.iter().any(|title| title == "dish - catoptric"), "{named:?}");
    steps(&mut session, 3);
    assert!(session.query_by_label("This was not opened").is_none());
}

fn narrow() {
    let mut session = window();
    session.set_size(vec2(390.0, 780.0));
    settle(&mut session, Viewer::is_sharp);
    let alone = session.state().picture_rect();
    assert!(alone.width() > 370.0 && alone.height() > 700.0, "{alone}");
    session.get_by_label("Controls").click();
    steps(&mut session, 30);
    let beside = session.state().picture_rect();
    assert!(beside.width() == alone.width() && beside.height() > 300.0, "{beside}");
    assert!(session.query_by_label("Scene").is_some());
    session.get_by_label("Close").click();
    steps(&mut session, 3);
    assert!(session.state().picture_rect() == alone && session.query_by_label("Scene").is_none());
}

fn hints() {
    let mut session = window();
    session.get_by_label_contains("drag: turn");
    session.key_press(Key::M);
    steps(&mut session, 2);
    session.get_by_label_contains("drag an object: move it");
    // Sections that strangers look for are open; times are not.
    for label in ["environment", "Save scene", "Undo"] {
        session.get_by_label(label);
    }
    assert!(session.query_by_label_contains("bvh").is_none());
    let middle = session.state().picture_rect().center();
    session.event(Event::PointerMoved(middle));
    let button = |pressed, pos| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    session.event(button(true, middle));
    for step in 1..=30 {
        session.event(Event::PointerMoved(middle + vec2(step as f32, 0.0)));
        session.step();
    }
    settle(&mut session, |viewer| viewer.wish().is_some_and(|wish| !wish.changes.moves.is_empty()));
    session.event(button(false, middle + vec2(30.0, 0.0)));
    steps(&mut session, 2);
    session.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(&mut session, |viewer| viewer.wish().is_some_and(|wish| wish.changes.moves.is_empty()));
}
