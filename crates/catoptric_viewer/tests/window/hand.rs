//! Mouse, keys and files that are dropped: none of it needs a device.

use crate::session::{SCENE, choose_parallax_box, expected, open, scene, settle};
use crate::trial;
use catoptric::scene::Role;
use catoptric_viewer::app::Viewer;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use libtest_mimic::Trial;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(crate) fn trials() -> Vec<Trial> {
    vec![
        trial("dragging turns the view about the pivot", dragging_turns),
        trial("the wheel goes nearer and keys fly", wheel_and_keys),
        trial("another method and other settings are drawn", method_and_settings),
        trial("the split view compares with the reference", split_view),
        trial("a picked object becomes glass", pick_and_role),
        trial("however far the panels are pulled, the picture stays", pulled_panels),
        trial("files are dropped, and broken ones told in words", dropped_files),
    ]
}

/// The middle of the picture.
fn middle(viewer: &Viewer) -> Pos2 {
    viewer.picture_rect().center()
}

fn button(at: Pos2, pressed: bool, button: PointerButton) -> Event {
    Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE }
}

fn pulled_panels() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    let before = session.state().picture_rect();
    let edge = before.left_center() - vec2(3.0, 0.0);
    session.event(Event::PointerMoved(edge));
    session.step();
    session.event(button(edge, true, PointerButton::Primary));
    session.step();
    for step in 1..=40 {
        session.event(Event::PointerMoved(edge + vec2(10.0 * step as f32, 0.0)));
        session.step();
    }
    session.event(button(edge + vec2(400.0, 0.0), false, PointerButton::Primary));
    settle(&mut session, Viewer::is_sharp);
    let after = session.state().picture_rect();
    assert!(after.width() < before.width() && after.width() > 100.0, "{before} {after}");
}

fn dragging_turns() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    let before = session.state().wish().unwrap().clone();
    let at = middle(session.state());
    session.event(Event::PointerMoved(at));
    session.event(button(at, true, PointerButton::Primary));
    session.step();
    for step in 1..=8 {
        session.event(Event::PointerMoved(at + vec2(5.0 * step as f32, 1.0)));
        session.step();
    }
    session.event(button(at + vec2(40.0, 1.0), false, PointerButton::Primary));
    settle(&mut session, Viewer::is_sharp);
    let after = session.state().wish().unwrap().clone();
    let scene = scene(SCENE);
    let pivot = before.camera.point_looked_at(&scene.bounds);
    let eye =
        |wish: &catoptric_viewer::studio::order::Wish| glam::Vec3::from(wish.camera.world_from_camera.translation);
    let [one, other] = [eye(&before), eye(&after)].map(|eye| eye - pivot);
    assert!((one.length() - other.length()).abs() < 1e-3 * one.length(), "{one} {other}");
    // Half a turn a height.
    let turned = one.angle_between(other).to_degrees();
    let wanted = 180.0 * 40.0 / session.state().picture_rect().height();
    assert!((0.6 * wanted..1.05 * wanted).contains(&turned), "{turned} of {wanted}");
    // The picture shows that view.
    assert_eq!(session.state().picture(0).unwrap(), &expected(&scene, &after, 0));
}

fn wheel_and_keys() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    let place = |viewer: &Viewer| glam::Vec3::from(viewer.wish().unwrap().camera.world_from_camera.translation);
    let start = place(session.state());
    session.event(Event::PointerMoved(middle(session.state())));
    session.event(Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: vec2(0.0, 60.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    settle(&mut session, Viewer::is_sharp);
    let nearer = place(session.state());
    assert!(nearer.distance(start) > 0.01, "{start} {nearer}");
    session.key_down(Key::S);
    (0..10).for_each(|_| session.step());
    session.key_up(Key::S);
    settle(&mut session, Viewer::is_sharp);
    let back = place(session.state());
    let axis = glam::Vec3::from(session.state().wish().unwrap().camera.world_from_camera.matrix3.z_axis);
    assert!((back - nearer).dot(axis) > 0.01, "{nearer} {back}");
    // All in view again, then as the scene's camera sees it.
    session.key_press(Key::Num1);
    settle(&mut session, |viewer| viewer.is_sharp() && place(viewer) == start);
}

fn method_and_settings() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    session.get_by_value("auto").click();
    session.step();
    session.step();
    session.get_by_label("environment_map").click();
    settle(&mut session, |viewer| {
        viewer.is_sharp() && viewer.wish().is_some_and(|wish| wish.sides[0].method == "environment_map")
    });
    let wish = session.state().wish().unwrap().clone();
    let scene = scene(SCENE);
    assert_eq!(session.state().picture(0).unwrap(), &expected(&scene, &wish, 0));
    choose_parallax_box(&mut session);
    let boxed = session.state().wish().unwrap().clone();
    assert_eq!(boxed.sides[0].settings["parallax"].as_str(), Some("box"));
    assert_eq!(session.state().picture(0).unwrap(), &expected(&scene, &boxed, 0));
    assert_ne!(expected(&scene, &wish, 0), expected(&scene, &boxed, 0));
}

fn split_view() {
    let mut session = open(&format!("builtin:{SCENE}"), "environment_map", None);
    session.key_press(Key::H);
    settle(&mut session, |viewer| viewer.is_sharp() && viewer.flip_mean().is_some());
    let error = session.state().flip_mean().unwrap();
    assert!(error > 0.005, "{error}");
    assert_eq!(session.state().wish().unwrap().sides[1].method, "reference");
    session.key_press(Key::X);
    settle(&mut session, |viewer| viewer.wish().is_some_and(|wish| wish.sides.len() == 1));
}

fn pick_and_role() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    // The ball is in the middle.
    let at = middle(session.state());
    session.event(Event::PointerMoved(at));
    session.event(button(at, true, PointerButton::Primary));
    session.step();
    session.event(button(at, false, PointerButton::Primary));
    while session.query_by_label("glass").is_none() {
        session.step();
        std::thread::sleep(std::time::Duration::from_millis(3));
    }
    // The panel opens slowly.
    (0..40).for_each(|_| session.step());
    session.get_by_label("glass").click();
    settle(&mut session, |viewer| {
        viewer.is_sharp() && viewer.wish().is_some_and(|wish| !wish.changes.roles.is_empty())
    });
    let change = session.state().wish().unwrap().changes.roles[0].clone();
    assert_eq!(change.role, Role::Lens);
    let object = scene(SCENE).objects.iter().any(|object| object.name == change.name);
    assert!(object, "{}", change.name);
    // Then it is moved: its point under the pointer stays there.
    session.key_press(Key::M);
    session.event(button(at, true, PointerButton::Primary));
    session.step();
    for step in 1..=30 {
        session.event(Event::PointerMoved(at + vec2(step as f32, 0.0)));
        session.step();
    }
    settle(&mut session, |viewer| viewer.wish().is_some_and(|wish| !wish.changes.moves.is_empty()));
    session.event(button(at + vec2(30.0, 0.0), false, PointerButton::Primary));
    settle(&mut session, Viewer::is_sharp);
    let wish = session.state().wish().unwrap();
    let view = catoptric::scene::View::new(&wish.camera, wish.size[0], wish.size[1], 1e-6);
    let by = wish.changes.moves[&change.name];
    let center = scene(SCENE).objects.iter().find(|object| object.name == change.name).unwrap().bounds.center();
    let [before, after] = [center, center + by].map(|point| view.pixel_of(point).unwrap());
    let moved = after - before;
    // The ball's point is nearer than its centre.
    assert!((20.0..32.0).contains(&moved.x) && moved.y.abs() < 1.0, "{moved}");
}

/// A file that lies on the disk.
#[derive(Debug)]
struct OnDisk(PathBuf);

impl egui::DroppedFile for OnDisk {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

fn dropped_files() {
    let mut session = open(&format!("builtin:{SCENE}"), "auto", None);
    let folder = tempfile::tempdir().unwrap();
    let drop_file = |session: &mut crate::session::Session, name: &str, content: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        session.input_mut().dropped_files.push(Arc::new(OnDisk(path)));
        session.step();
    };
    drop_file(&mut session, "broken.glb", "this is no scene");
    settle(&mut session, |viewer| viewer.messages().any(|message| message.contains("broken.glb")));
    // The old scene stays.
    assert!(session.state().picture(0).is_some());
    let ball = "[[reflector]]\nname = 'ball'\nsurface = 'sphere'\ncenter = [0, 0, 0]\nradius = 1\n";
    drop_file(&mut session, "ball.toml", ball);
    settle(&mut session, |viewer| viewer.is_sharp() && viewer.wish().is_some_and(|wish| wish.scene == 3));
    session.get_by_label_contains("1 objects");
}
