//! Random input, the same in every run: nothing panics, nothing stops, no frame of the window takes long.
//!
//! `CATOPTRIC_RANDOM_SECONDS` is how long it goes on (a few seconds otherwise), `CATOPTRIC_RANDOM_SCENES` a folder of
//! which all scenes are opened, broken ones too. Runs of ten minutes and more also check the time of frames, and that
//! memory does not grow: now and then the same scene is opened, which takes as much then as before.

use crate::session::{Session, open, settle};
use catoptric::methods;
use catoptric_scenes::builtin;
use catoptric_viewer::studio::order::Source;
use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, TouchPhase, pos2, vec2};
use egui_kittest::kittest::Queryable;
use libtest_mimic::Trial;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A frame of the window that takes longer is a failure of long runs.
const LONGEST_FRAME: Duration = Duration::from_secs(2);

/// Memory may grow by this factor after the first sixth of a long run, in the mean.
const GROWTH: f64 = 1.1;

/// The longest time between looks at the memory.
const BETWEEN_RESTS: Duration = Duration::from_secs(120);

/// The scene between others, with which memory is compared.
const AT_REST: &str = "sphere_room?tess=12";

/// Keys that move the eye as long as they are held.
const FLIGHT: [Key; 6] = [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E];

pub(crate) fn trials() -> Vec<Trial> {
    vec![crate::trial("random input for a while", random_input)]
}

/// Numbers that look random (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// The scenes that are opened: built-in ones, or all files of a folder, and broken ones.
fn sources(broken: &Path) -> Vec<Source> {
    let mut sources: Vec<Source> = match std::env::var_os("CATOPTRIC_RANDOM_SCENES") {
        Some(folder) => files(Path::new(&folder)).into_iter().map(Source::File).collect(),
        None => Vec::new(),
    };
    sources.extend(builtin::all().iter().map(|info| Source::Builtin(format!("{}?tess=12", info.name))));
    for (name, content) in [("cut.glb", &b"glTF\x02\0\0\0"[..]), ("empty.obj", b""), ("wrong.toml", b"gltf = 3")] {
        let path = broken.join(name);
        std::fs::write(&path, content).unwrap();
        sources.push(Source::File(path));
    }
    sources.push(Source::File(broken.join("missing.glb")));
    sources
}

/// All scenes in a folder and those in it, in order.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if path.is_dir() {
            found.extend(files(&path));
        } else if ["glb", "gltf", "obj", "toml"].contains(&extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The memory of this process in megabytes, where the system tells.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches(" kB").parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}

fn random_input() {
    let seconds = std::env::var("CATOPTRIC_RANDOM_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(8.0);
    let duration = Duration::from_secs_f64(seconds);
    let folder = tempfile::tempdir().unwrap();
    let sources = sources(folder.path());
    let mut session = open(&format!("builtin:{AT_REST}"), "auto", None);
    let mut random = Random(7);
    let (start, mut longest, mut at_rest) = (Instant::now(), (Duration::ZERO, String::new()), Vec::new());
    let mut next_rest = (duration / 6).min(BETWEEN_RESTS);
    while start.elapsed() < duration {
        let done = act(&mut session, &mut random, &sources);
        for _ in 0..1 + random.below(6) {
            let step = Instant::now();
            session.step();
            session.render().unwrap();
            if step.elapsed() > longest.0 {
                longest = (step.elapsed(), done.clone());
            }
            std::thread::sleep(Duration::from_millis(4));
        }
        if start.elapsed() > next_rest {
            next_rest += (duration / 6).min(BETWEEN_RESTS);
            rest(&mut session);
            // Where the system does not tell, nothing is compared.
            let megabytes = memory().unwrap_or(0.0);
            at_rest.push((start.elapsed(), megabytes));
            println!("{:.0?}: {megabytes:.0} MB at rest; longest frame {longest:?}", start.elapsed());
        }
    }
    if seconds >= 600.0 {
        assert!(longest.0 <= LONGEST_FRAME, "{longest:?}");
        // Single looks differ by a tenth and more, as free pages lie between used ones: what grows shows in the mean.
        let mean = |is_early: bool| {
            // A rest is a bit later than it was due.
            let part = duration / 6 + BETWEEN_RESTS / 2;
            let of_part = at_rest.iter().filter(|(time, _)| (*time < part) == is_early);
            let looks: Vec<f64> = of_part.map(|(_, megabytes)| *megabytes).collect();
            looks.iter().sum::<f64>() / looks.len().max(1) as f64
        };
        assert!(mean(false) <= GROWTH * mean(true), "{at_rest:?} MB");
    }
}

/// Lets go of everything and opens a scene: what draws is still there. A picture becomes sharp only where nothing
/// flies.
fn rest(session: &mut Session) {
    FLIGHT.into_iter().for_each(|key| session.key_up(key));
    session.event(Event::PointerGone);
    session.set_size(vec2(620.0, 800.0));
    session.state_mut().open(Source::Builtin(AT_REST.into()));
    session.state_mut().choose(0, "auto").unwrap();
    session.state_mut().choose(1, "").unwrap();
    let name = format!("builtin:{AT_REST}");
    settle(session, |viewer| viewer.is_sharp() && viewer.scene_name() == Some(&*name));
}

/// Does something, and says what.
fn act(session: &mut Session, random: &mut Random, sources: &[Source]) -> String {
    let rect = session.state().picture_rect();
    let at = pos2(rect.left() + rect.width() * random.unit(), rect.top() + rect.height() * random.unit());
    let button = [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle][random.below(3)];
    let press = |pressed| Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE };
    let what = random.below(13);
    match what {
        0..4 => {
            session.event(Event::PointerMoved(at));
            session.event(press(true));
            session.step();
            for _ in 0..random.below(12) {
                let by = vec2(random.unit() - 0.5, random.unit() - 0.5) * 120.0;
                session.event(Event::PointerMoved(at + by));
                session.step();
            }
            session.event(press(false));
        }
        4 => session.event(Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta: vec2(0.0, (random.unit() - 0.5) * 300.0),
            phase: TouchPhase::Move,
            source: MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        }),
        5 => session.key_down(FLIGHT[random.below(FLIGHT.len())]),
        6 => FLIGHT.into_iter().for_each(|key| session.key_up(key)),
        7 => {
            let keys = [Key::F, Key::Space, Key::M, Key::X, Key::H, Key::P, Key::Escape, Key::Num1, Key::Num2];
            session.key_press(keys[random.below(keys.len())]);
        }
        8 => {
            let id = methods::all()[random.below(methods::all().len())].id;
            session.state_mut().choose(random.below(2), id).unwrap();
        }
        9 => {
            let labels =
                ["glass", "mirror", "plain", "Undo all changes", "tiles", "reflection groups", "virtual triangles"];
            let label = labels[random.below(labels.len())];
            let node = session.query_all_by_label(label).next();
            if let Some(node) = node {
                node.click();
            }
        }
        10 => {
            let source = sources[random.below(sources.len())].clone();
            let said = format!("{source:?} was opened");
            session.state_mut().open(source);
            return said;
        }
        11 => {
            // Windows become as small as can be, too.
            let size = vec2(1.0 + 899.0 * random.unit(), 1.0 + 899.0 * random.unit());
            session.set_size(size);
        }
        _ => session.event(Event::PointerGone),
    }
    format!("input {what} on {:?}", session.state().scene_name())
}
