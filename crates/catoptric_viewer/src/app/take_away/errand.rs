//! Work that the program `catoptric` does beside the window: reports and bakes. Drawing goes on.

use super::super::state::errand::{Errand, Task};
use super::super::state::{Viewer, ViewerEvent};
use super::{command, scene_file};
use crate::studio::order::{Drawn, Opening, Order, Wish};
use catoptric::methods;
use eframe::egui::{ProgressBar, Ui};
use glam::DVec3;
use std::ffi::OsString;
use std::path::Path;
use tempfile::TempDir;

/// The message where the program `catoptric` was not found: that it is needed, and how to get it.
const NO_PROGRAM: &str = "this needs the program `catoptric`: install it (cargo install catoptric_cli), or put it \
                          beside the viewer, and start the viewer again";

impl Viewer {
    /// Has a report made that compares what is shown with the reference, and shows it in the browser.
    pub fn make_report(&mut self, folder: &Path) {
        self.send_errand(Task::Report, folder);
    }

    /// Has the left side's precomputation made, for any time later, and uses it.
    pub fn bake(&mut self, file: &Path) {
        self.send_errand(Task::Bake, file);
    }

    /// True while a report or a bake is being made.
    pub fn has_errands(&self) -> bool {
        !self.errands.is_empty()
    }

    /// Ends the making of reports and bakes. What a bake has got so far stays, and is gone on with the next time.
    pub fn call_errands_off(&mut self) {
        self.errands.iter_mut().for_each(Errand::call_off);
    }

    /// Why a task cannot be done now; `None` if it can.
    pub(super) fn hindrance(&self, task: Task) -> Option<&'static str> {
        let can_bake = || methods::find(&self.choices[0].method).is_ok_and(|info| info.bake.is_some());
        match (&self.program, &self.sent) {
            (None, _) => Some(NO_PROGRAM),
            (_, None) => Some("once there is a picture"),
            _ if task == Task::Bake && !can_bake() => Some("the left method precomputes nothing for files"),
            _ => None,
        }
    }

    pub(super) fn send_errand(&mut self, task: Task, target: &Path) {
        let Some(program) = self.program.clone() else { return self.say(NO_PROGRAM) };
        let Some(wish) = self.sent.clone() else { return };
        let camera = self.camera.filter(|_| self.scene.as_ref().is_some_and(|scene| scene.cameras.len() > 1));
        let origin = self.scene.as_ref().map_or(DVec3::ZERO, |scene| scene.origin);
        let scene = |path: &Path| scene_file::text((&wish, origin), (&self.source, &self.opened), path);
        let words = words(task, target, (&wish, camera, &self.opened), scene);
        let begin = |words| Errand::begin(task, target, &program, words, self.window.clone());
        match words.and_then(begin) {
            Ok(errand) => self.errands.push(errand),
            Err(problem) => self.say(problem),
        }
    }

    /// Learns what has become of errands.
    pub(in crate::app) fn follow_errands(&mut self) {
        let mut ended = Vec::new();
        self.errands.retain_mut(|errand| match errand.end() {
            Some(end) => {
                ended.push((errand.task, errand.target.clone(), end));
                false
            }
            None => true,
        });
        for (task, target, end) in ended {
            match (task, end) {
                (_, Err(problem)) => self.say(problem),
                (Task::Bake, Ok(_)) => {
                    self.note(format!("bake saved to {}", target.display()));
                    self.link.send(Order::UseBake { path: target });
                }
                (Task::Report, Ok(remark)) => {
                    let page = target.join("report.html");
                    let page = std::path::absolute(&page).unwrap_or(page);
                    self.tell(ViewerEvent::Report(&page));
                    self.note(format!("report saved to {}{remark}", page.display()));
                }
            }
        }
    }
}

/// Shows what is at work.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    for errand in &mut viewer.errands {
        ui.horizontal(|ui| {
            let (stage, share) = &errand.stage;
            let seconds = errand.since.elapsed().as_secs();
            let text = format!("{} {stage} {seconds} s", errand.task.word());
            match share {
                Some(share) => ui.add(ProgressBar::new(*share).desired_width(180.0).text(text)),
                None => ui.label(text),
            };
            if ui.button("Stop").clicked() {
                errand.call_off();
            }
        });
    }
}

/// The words for a task, with the folder of the scene file that they name; `scene` makes its text, told its path.
///
/// # Errors
/// Reasons why something cannot be told to the program.
fn words(
    task: Task,
    target: &Path,
    (wish, camera, opened): (&Wish, Option<usize>, &Opening),
    scene: impl FnOnce(&Path) -> Result<String, String>,
) -> Result<(TempDir, Vec<OsString>), String> {
    let fail = |error: std::io::Error| format!("{} {error}", task.word());
    let folder = tempfile::tempdir().map_err(fail)?;
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, scene(&path)?).map_err(fail)?;
    let mut words: Vec<OsString> = Vec::new();
    match task {
        Task::Report => {
            words.extend(["compare".into(), path.into(), "--report".into(), target.into()]);
            // Devices are left to the window.
            words.push("--backend=cpu".into());
            words.extend(command::beside_scene_file(opened).into_iter().map(OsString::from));
            words.extend(wish.clip.map(|index| format!("--animation={index}").into()));
            words.extend(command::view(wish, camera)?.into_iter().map(OsString::from));
            words.extend(wish.sides.iter().map(|side| format!("--method={}", with_settings(side)).into()));
        }
        Task::Bake => {
            words.extend(["bake".into(), path.into(), "-o".into(), target.into()]);
            words.extend(command::method(&wish.sides[0]).into_iter().map(OsString::from));
            words.push(format!("--order={}", wish.sides[0].quality.order).into());
        }
    }
    Ok((folder, words))
}

/// A method with its settings, as `compare` takes them.
fn with_settings(drawn: &Drawn) -> String {
    let settings: Vec<String> = command::settings(drawn).collect();
    match settings.is_empty() {
        true => drawn.method.clone(),
        false => format!("{}:{}", drawn.method, settings.join(",")),
    }
}
