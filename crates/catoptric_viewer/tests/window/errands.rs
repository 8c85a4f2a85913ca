//! Reports and bakes that are made beside the window.

use crate::session::{Session, Start, expected, open, open_as, scene, settle, share_off, start};
use crate::trial;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use catoptric::methods;
use catoptric_bake::{BakedFile, MethodBake};
use catoptric_viewer::app::Viewer;
use egui::{DroppedFile, Event, Modifiers, PointerButton, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use libtest_mimic::Trial;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

/// A window's frame, while something is at work beside it, takes no longer.
const LONGEST_FRAME: Duration = Duration::from_secs(2);

const SCENE: &str = "sphere_room?tess=8";

/// The file of the program `catoptric` beside the viewer's, where cargo builds both; or what is wrong with it.
pub(crate) static PROGRAM: LazyLock<Result<PathBuf, String>> = LazyLock::new(|| {
    let name = format!("catoptric{}", std::env::consts::EXE_SUFFIX);
    let program = Path::new(VIEWER).with_file_name(name);
    let answer = Command::new(&program).arg("--version").output();
    match answer.is_ok_and(|answer| answer.status.success()) {
        true => Ok(program),
        false => Err("no answer of target/*/catoptric: cargo build -p catoptric_cli".to_owned()),
    }
});

/// The viewer's own file.
const VIEWER: &str = env!("CARGO_BIN_EXE_catoptric_viewer");

pub(crate) fn trials() -> Vec<Trial> {
    let all: [(&str, fn()); 4] = [
        ("a report is made beside the window", report),
        ("a bake is made beside the window and used, as are dropped ones that are whole", bake),
        ("what is called off ends, and is gone on with", called_off),
        ("the hand is answered while a bake runs and the reference sharpens", answered),
    ];
    let is_required = std::env::var_os("CI").is_some();
    let made = all.into_iter().map(|(name, test)| match &*PROGRAM {
        Ok(_) => trial(name, test),
        Err(reason) => crate::lacking(name, reason.clone(), is_required),
    });
    made.chain([trial("where the program is missing or another one this is said", without_program)]).collect()
}

/// Lets time go on until no errand is left; looks at the picture meanwhile.
fn wait(session: &mut Session) {
    let start = Instant::now();
    while session.state().has_errands() {
        let step = Instant::now();
        session.step();
        assert!(step.elapsed() < LONGEST_FRAME);
        assert!(start.elapsed() < Duration::from_secs(300), "it does not end");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn messages(session: &Session) -> String {
    session.state().messages().collect::<Vec<_>>().join("\n")
}

fn report() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("a report");
    let mut session = open(&format!("builtin:{SCENE}"), "auto", Some("environment_map"));
    session.state_mut().make_report(&place);
    assert!(session.state().has_errands());
    wait(&mut session);
    let page = std::fs::read_to_string(place.join("report.html")).unwrap();
    assert!(page.contains("environment_map") && page.contains("auto"), "{}", messages(&session));
    assert!(messages(&session).contains("report.html"));
    // The report is of the same view.
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(place.join("report.json")).unwrap()).unwrap();
    let [width, height] = session.state().wish().unwrap().size;
    assert_eq!((&report[0]["size"][0], &report[0]["size"][1]), (&width.into(), &height.into()));
    // In the page are the reference, and each method with its differences.
    let pictures: Vec<&str> = page.split("data:image/png;base64,").skip(1).collect();
    let png = BASE64_STANDARD.decode(pictures[1].split('"').next().unwrap()).unwrap();
    let drawn = image::load_from_memory(&png).unwrap().into_rgba8();
    // The camera went through words: some edge may fall on another side of a sample.
    assert!(share_off(drawn.as_raw(), session.state().pixels(0).unwrap(), 4) < 1e-3);
}

fn bake() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.bake");
    let mut session = open_as(None, small_light_field(None));
    let before = session.state().pixels(0).unwrap().to_vec();
    assert_eq!(session.state().processor(), Some("CPU"));
    session.state_mut().bake(&file);
    wait(&mut session);
    settle(&mut session, |viewer| viewer.processor() == Some("CPU, baked") && viewer.is_sharp());
    // The bake is of the scene that was shown, and shows the same.
    let wish = session.state().wish().unwrap().clone();
    let (scene, drawn) = (scene(SCENE), &wish.sides[0]);
    let info = methods::find("light_field").unwrap();
    let asked = MethodBake::new(info, &drawn.settings, &scene, drawn.quality).unwrap();
    asked.check(&BakedFile::open(&file).unwrap(), "the bake").unwrap();
    assert!(session.state().pixels(0).unwrap() == before, "another picture");
    assert!(*session.state().picture(0).unwrap() == expected(&scene, &wish, 0), "not the library's");
    // A scene that the bake does not fit is drawn without it, and the user is told so.
    session.state_mut().open(catoptric_viewer::studio::order::Source::Builtin("sphere_room?tess=6".into()));
    settle(&mut session, |viewer| viewer.processor() == Some("CPU") && viewer.is_sharp());
    assert!(messages(&session).contains("is the bake of something else"), "{}", messages(&session));
    dropped(&file, &before);
}

/// A window of a light field that is captured and baked in no time.
fn small_light_field(against: Option<&str>) -> Start {
    let settings = "st = 4\nuv = 16".parse().unwrap();
    Start { settings, ..start(&format!("builtin:{SCENE}"), "light_field", against) }
}

/// A file that is dropped onto the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|problem| problem.to_string())
    }
}

/// A bake of the picture `before`, and the same with a wrong bit, are dropped on another window.
fn dropped(file: &Path, before: &[u8]) {
    let damaged = file.with_file_name("damaged.bake");
    let mut bytes = std::fs::read(file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&damaged, bytes).unwrap();
    // Nothing is used that was not dropped.
    let mut session = open_as(None, small_light_field(None));
    assert!(session.state().pixels(0).unwrap() == before, "another picture");
    session.input_mut().dropped_files.push(Arc::new(Dropped(damaged)));
    settle(&mut session, |viewer| viewer.messages().any(|message| message.contains("damaged.bake")));
    settle(&mut session, Viewer::is_sharp);
    assert_eq!(session.state().processor(), Some("CPU"), "{}", messages(&session));
    session.input_mut().dropped_files.push(Arc::new(Dropped(file.to_owned())));
    settle(&mut session, |viewer| viewer.processor() == Some("CPU, baked") && viewer.is_sharp());
    assert!(session.state().pixels(0).unwrap() == before, "another picture");
}

fn called_off() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.bake");
    let mut session = open("builtin:sphere_room", "auto", None);
    session.state_mut().choose(0, "light_field").unwrap();
    settle(&mut session, Viewer::is_sharp);
    session.state_mut().bake(&file);
    for _ in 0..20 {
        session.step();
        std::thread::sleep(Duration::from_millis(5));
    }
    session.state_mut().call_errands_off();
    wait(&mut session);
    assert!(messages(&session).contains("bake: stopped"), "{}", messages(&session));
    assert!(!file.exists());
    // The same again goes on to the end.
    session.state_mut().bake(&file);
    wait(&mut session);
    assert!(file.is_file(), "{}", messages(&session));
}

fn without_program() {
    let start = |program| Start { program, ..start(&format!("builtin:{SCENE}"), "light_field", None) };
    let mut session = open_as(None, start(None));
    let buttons = ["Report...", "Bake..."];
    for name in buttons {
        assert!(session.get_by_label(name).accesskit_node().is_disabled());
        session.get_by_label(name).hover();
        (0..60).for_each(|_| session.step());
        assert!(session.query_by_label_contains("cargo install catoptric_cli").is_some(), "{name} says nothing");
    }
    session.state_mut().make_report(Path::new("report"));
    assert!(!session.state().has_errands() && messages(&session).contains("cargo install catoptric_cli"));
    // The viewer's own program is not the one that is needed.
    let mut session = open_as(None, start(Some(VIEWER.into())));
    assert!(buttons.iter().all(|name| !session.get_by_label(name).accesskit_node().is_disabled()));
    let folder = tempfile::tempdir().unwrap();
    session.state_mut().bake(&folder.path().join("room.bake"));
    wait(&mut session);
    assert!(messages(&session).contains("is not `catoptric "), "{}", messages(&session));
}

fn answered() {
    let folder = tempfile::tempdir().unwrap();
    let mut session = open_as(None, small_light_field(Some("reference")));
    let at = session.state().picture_rect().left_center() + vec2(40.0, 0.0);
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    let press = |pressed| Event::PointerButton { pos: at, button, pressed, modifiers };
    session.event(Event::PointerMoved(at));
    session.event(press(true));
    session.step();
    let first = session.state().wish().unwrap().camera.clone();
    let (mut frames, mut answered, mut seen) = (Vec::new(), 0, 0);
    for step in 1..=60 {
        // Where a bake ends sooner than the hand, the next one runs.
        if !session.state().has_errands() {
            session.state_mut().bake(&folder.path().join(format!("{step}.bake")));
        }
        let before = session.state().wish().unwrap().clone();
        session.event(Event::PointerMoved(at + vec2((step % 30) as f32 * 7.0, 0.0)));
        let start = Instant::now();
        session.step();
        session.render().unwrap();
        frames.push(start.elapsed());
        // The wish is another one by the end of the frame, and some picture follows the hand.
        answered += usize::from(*session.state().wish().unwrap() != before);
        seen += usize::from(session.state().picture_wish(0).is_some_and(|of| of.camera != first));
        std::thread::sleep(Duration::from_millis(12));
    }
    session.event(press(false));
    session.state_mut().call_errands_off();
    wait(&mut session);
    // None of them failed.
    let said = messages(&session);
    assert!(said.lines().all(|line| !line.starts_with("bake:") || line == "bake: stopped"), "{said}");
    frames.sort();
    let [middle, most] = [frames[frames.len() / 2], frames[frames.len() - 1]];
    println!("a frame of the window after a move of the hand: {middle:.1?}, at most {most:.1?}");
    // A drag begins some way from where the button went down.
    assert!(most < LONGEST_FRAME && answered >= 58 && seen > 0, "{most:?}, {answered} answered, {seen} seen");
}
