//! Work that the program `catoptric` does beside the window, in a process of its own: reports and bakes. The window
//! waits for nothing of it, and drawing goes on.

use super::super::{Viewer, ViewerEvent};
use super::{command, scene_file};
use crate::studio::order::{Drawn, Opening, Order, Wish};
use catoptric::methods;
use eframe::egui::{Context, ProgressBar, Ui};
use glam::DVec3;
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Instant;
use tempfile::TempDir;

/// What is missing where the program is, and how it gets there.
const NO_PROGRAM: &str = "this needs the program `catoptric`: install it (cargo install catoptric_cli), or put it \
                          beside the viewer, and start the viewer again";

/// The answer of a program of the window's version to `--version`.
const VERSION: &str = concat!("catoptric ", env!("CARGO_PKG_VERSION"));

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::app) enum Task {
    /// What is shown is compared with the reference: a folder with a page.
    Report,
    /// The left side's precomputation.
    Bake,
}

/// A program at work.
pub(in crate::app) struct Errand {
    task: Task,
    /// What it makes.
    target: PathBuf,
    program: Child,
    /// Holds the scene file that it reads.
    _folder: TempDir,
    lines: Receiver<String>,
    /// Reads these; returns what is to be said of the program if it has failed. Taken then.
    reader: Option<JoinHandle<Option<String>>>,
    /// The present stage and its share.
    stage: (String, Option<f32>),
    /// Its last words that are no progress.
    last_words: String,
    since: Instant,
    is_called_off: bool,
}

/// A line of progress, as the program prints them.
#[derive(serde::Deserialize)]
struct Line {
    subject: String,
    stage: String,
    done: u64,
    of: u64,
}

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
        match Errand::begin(task, target, &program, (&wish, camera, &self.opened), scene, self.window.clone()) {
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

impl Task {
    fn word(self) -> &'static str {
        match self {
            Self::Report => "report:",
            Self::Bake => "bake:",
        }
    }
}

impl Errand {
    /// Starts the program; `scene` makes the text of a scene file, told its path.
    ///
    /// # Errors
    /// What cannot be told to the program, and programs that cannot be started.
    fn begin(
        task: Task,
        target: &Path,
        program: &Path,
        (wish, camera, opened): (&Wish, Option<usize>, &Opening),
        scene: impl FnOnce(&Path) -> Result<String, String>,
        window: Option<Context>,
    ) -> Result<Self, String> {
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
        words.push("--progress=lines".into());
        let file = program.to_path_buf();
        let mut program = niced(program)
            .args(words)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{}: {error}", program.display()))?;
        let (sender, lines) = channel();
        let said = program.stderr.take();
        let reader = std::thread::spawn(move || {
            let wake_up = || window.iter().for_each(Context::request_repaint);
            said.into_iter().for_each(|said| read_lines(BufReader::new(said), &sender, wake_up));
            let remark = other_version(&file);
            // The end of lines is the end of all.
            drop(sender);
            wake_up();
            remark
        });
        let (stage, since, is_called_off) = ((String::new(), None), Instant::now(), false);
        let (target, last_words, reader) = (target.to_path_buf(), String::new(), Some(reader));
        Ok(Self { task, target, program, _folder: folder, lines, reader, stage, last_words, since, is_called_off })
    }

    /// How it has ended, with a remark or a problem; `None` while it goes on.
    fn end(&mut self) -> Option<Result<String, String>> {
        loop {
            match self.lines.try_recv() {
                Ok(line) => match serde_json::from_str(&line) {
                    Ok(Line { subject, stage, done, of }) => {
                        let share = (of > 0).then(|| done as f32 / of as f32);
                        self.stage = (format!("{subject} {stage}"), share);
                    }
                    // Units of bakes are told in JSON, too.
                    Err(_) if line.starts_with('{') => {}
                    Err(_) => self.last_words = line,
                },
                Err(TryRecvError::Empty) => return None,
                // Nothing is said after the end.
                Err(TryRecvError::Disconnected) => break,
            }
        }
        let code = match self.program.try_wait() {
            Ok(None) => return None,
            Ok(Some(status)) => status.code(),
            Err(error) => return Some(Err(format!("{} {error}", self.task.word()))),
        };
        let words = self.last_words.trim_start_matches("error: ");
        Some(match (self.task, code) {
            _ if self.is_called_off => Err(format!("{} stopped", self.task.word())),
            (_, Some(0)) => Ok(String::new()),
            // Some method has failed; the report says why.
            (Task::Report, Some(1)) if self.target.join("report.html").is_file() => Ok(format!("; {words}")),
            _ => {
                let remark = self.reader.take().and_then(|reader| reader.join().ok()).flatten();
                Err(format!("{} {words}{}", self.task.word(), remark.unwrap_or_default()))
            }
        })
    }

    /// Ends it, with time to tidy up where the system knows how to ask for that.
    fn call_off(&mut self) {
        self.is_called_off = true;
        #[cfg(unix)]
        if let Some(id) = i32::try_from(self.program.id()).ok().and_then(rustix::process::Pid::from_raw) {
            // It may have ended by itself.
            let _ = rustix::process::kill_process(id, rustix::process::Signal::TERM);
        }
        #[cfg(not(unix))]
        let _ = self.program.kill();
    }
}

impl Drop for Errand {
    fn drop(&mut self) {
        // Nobody would hear of it any more.
        if let Ok(None) = self.program.try_wait() {
            self.call_off();
        }
    }
}

/// A command of low priority, where there are such: drawing comes first.
fn niced(program: &Path) -> Command {
    let has_nice = cfg!(unix) && Path::new("/usr/bin/nice").is_file();
    if !has_nice {
        return Command::new(program);
    }
    let mut command = Command::new("/usr/bin/nice");
    command.arg("-n").arg("10").arg(program);
    command
}

/// Hands lines on until there are no more, and wakes the window up for each.
fn read_lines(lines: impl BufRead, sender: &Sender<String>, wake_up: impl Fn()) {
    for line in lines.lines().map_while(Result::ok) {
        if sender.send(line).is_err() {
            return;
        }
        wake_up();
    }
}

/// Returns a remark about a program that is not of the window's version.
fn other_version(program: &Path) -> Option<String> {
    let answer = Command::new(program).arg("--version").stdin(Stdio::null()).output();
    let is_same = answer.is_ok_and(|answer| answer.stdout.trim_ascii() == VERSION.as_bytes());
    (!is_same).then(|| format!("; {} is not `{VERSION}`, which belongs to this viewer", program.display()))
}

/// A method with its settings, as `compare` takes them.
fn with_settings(drawn: &Drawn) -> String {
    let settings: Vec<String> = command::settings(drawn).collect();
    match settings.is_empty() {
        true => drawn.method.clone(),
        false => format!("{}:{}", drawn.method, settings.join(",")),
    }
}
