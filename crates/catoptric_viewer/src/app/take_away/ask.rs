//! Paths that the user is asked for: by the system's dialogue, or in the window where no service shows one.

use super::super::Viewer;
use super::errand::Task;
use super::files::{self, Make};
use crate::studio::order::{Opening, Source};
use eframe::egui::{Align2, Context, Key, TextEdit, Ui, Window};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// Nobody calls a dialogue off so soon: one that ends by then was never shown.
const SOONEST: Duration = Duration::from_millis(400);

/// What a path is for.
pub(in crate::app) enum Purpose {
    /// A scene or a bake to be opened.
    Open,
    /// A picture of light from infinity.
    Environment,
    /// A file to be saved.
    Save {
        /// The name that is proposed.
        name: String,
        /// The extension of its kind.
        extension: &'static str,
        /// Makes its content.
        make: Make,
    },
    /// What the program makes.
    Task(Task),
}

/// A path that is not known yet.
pub(in crate::app) struct Question {
    purpose: Purpose,
    asked: Asked,
}

/// Where the user is asked.
enum Asked {
    /// By the system; nothing comes if the user has changed their mind.
    Dialogue(Receiver<Option<PathBuf>>, Instant),
    /// In the window.
    Window {
        path: String,
        /// Why the last answer cannot be taken.
        problem: String,
        /// The field is to have the keyboard.
        is_new: bool,
    },
}

impl Purpose {
    fn title(&self) -> String {
        match self {
            Self::Open => "Open a scene or a bake".into(),
            Self::Environment => "A picture of light from infinity".into(),
            Self::Save { extension, .. } => format!("Save as .{extension}"),
            Self::Task(Task::Report) => "A folder for the report".into(),
            Self::Task(Task::Bake) => "A file for the bake".into(),
        }
    }

    /// The name that is proposed; empty for what is there already.
    fn name(&self) -> &str {
        match self {
            Self::Open | Self::Environment => "",
            Self::Save { name, .. } => name,
            Self::Task(Task::Report) => "report",
            Self::Task(Task::Bake) => "scene.bake",
        }
    }

    /// Has the system ask, which takes as long as the user likes.
    fn dialogue(&self) -> impl FnOnce() -> Option<PathBuf> + Send + 'static {
        let dialogue = rfd::FileDialog::new().set_title(self.title());
        let (dialogue, is_open) = match self {
            Self::Open => {
                let kinds = &["glb", "gltf", "obj", "ply", "stl", "toml", "bake"];
                (dialogue.add_filter("scenes and bakes", kinds), true)
            }
            Self::Environment => (dialogue.add_filter("pictures", &["hdr", "exr", "png", "jpg", "jpeg", "webp"]), true),
            Self::Save { name, extension, .. } => {
                (dialogue.set_file_name(name).add_filter(*extension, &[extension]), false)
            }
            Self::Task(Task::Report) => (dialogue.set_file_name(self.name()), false),
            Self::Task(Task::Bake) => (dialogue.set_file_name(self.name()).add_filter("bakes", &["bake"]), false),
        };
        move || if is_open { dialogue.pick_file() } else { dialogue.save_file() }
    }

    /// The path that an answer stands for.
    ///
    /// # Errors
    /// Words about why it cannot be taken.
    fn check(&self, answer: &str) -> Result<PathBuf, String> {
        let answer = answer.trim();
        if answer.is_empty() {
            return Err("type a path".into());
        }
        let home = answer.strip_prefix("~/").and_then(|rest| Some(std::env::home_dir()?.join(rest)));
        let mut path = home.unwrap_or_else(|| answer.into());
        match self {
            Self::Open | Self::Environment if path.is_dir() => {
                return Err("this is a folder: add the name of a file in it".into());
            }
            Self::Open | Self::Environment if !path.exists() => return Err("there is no such file".into()),
            Self::Open | Self::Environment | Self::Task(Task::Report) => return Ok(path),
            Self::Save { extension, .. } if path.extension().is_none() && !path.is_dir() => {
                path.set_extension(extension);
            }
            Self::Save { .. } | Self::Task(Task::Bake) => {}
        }
        if path.is_dir() {
            return Err("this is a folder: add the name of a file".into());
        }
        match path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
            Some(folder) => Err(format!("there is no folder {}: make it, or choose another one", folder.display())),
            None => Ok(path),
        }
    }
}

impl Viewer {
    /// Has paths asked for in the window, whatever dialogues the system may have.
    pub fn ask_in_window(&mut self) {
        self.has_dialogues = false;
    }

    /// Asks for a path.
    pub(in crate::app) fn ask(&mut self, purpose: Purpose) {
        let asked = if self.has_dialogues {
            let (sender, answer) = channel();
            let (dialogue, window) = (purpose.dialogue(), self.window.clone());
            std::thread::spawn(move || {
                // The window may be gone by then.
                let _ = sender.send(dialogue());
                window.iter().for_each(Context::request_repaint);
            });
            Asked::Dialogue(answer, Instant::now())
        } else {
            self.asked_in_window(&purpose)
        };
        self.questions.push(Question { purpose, asked });
    }

    /// The question in the window, with a path that is proposed.
    fn asked_in_window(&self, purpose: &Purpose) -> Asked {
        let own = match &self.source {
            Source::File(file) => std::path::absolute(file).ok().and_then(|file| Some(file.parent()?.to_path_buf())),
            _ => None,
        };
        let folder = own.or_else(|| std::env::current_dir().ok()).unwrap_or_default();
        let path = free(&folder.join(purpose.name()));
        Asked::Window { path: path.display().to_string(), problem: String::new(), is_new: true }
    }

    /// True while a dialogue of the system is open, or is being waited for.
    pub(in crate::app) fn has_dialogue(&self) -> bool {
        self.questions.iter().any(|question| matches!(question.asked, Asked::Dialogue(..)))
    }

    /// Asks in the window what dialogues ask that have not been answered.
    pub(in crate::app) fn give_dialogues_up(&mut self) {
        for mut question in std::mem::take(&mut self.questions) {
            if matches!(question.asked, Asked::Dialogue(..)) {
                question.asked = self.asked_in_window(&question.purpose);
            }
            self.questions.push(question);
        }
    }

    /// Learns what dialogues have come to.
    pub(in crate::app) fn follow_dialogues(&mut self) {
        for question in std::mem::take(&mut self.questions) {
            let Asked::Dialogue(answer, since) = &question.asked else {
                self.questions.push(question);
                continue;
            };
            match answer.try_recv() {
                Ok(Some(path)) => self.take_path(question.purpose, path),
                Ok(None) if since.elapsed() < SOONEST => {
                    self.has_dialogues = false;
                    self.ask(question.purpose);
                }
                Ok(None) | Err(TryRecvError::Disconnected) => {}
                Err(TryRecvError::Empty) => self.questions.push(question),
            }
        }
    }

    /// Does what a path was asked for.
    fn take_path(&mut self, purpose: Purpose, path: PathBuf) {
        match purpose {
            Purpose::Open => self.open_file(&path),
            Purpose::Environment => self.light(Opening { environment: Some(path), ..self.opened.clone() }),
            Purpose::Save { make, .. } => self.saves.push(files::write(path, make, self.window.clone())),
            Purpose::Task(task) => self.send_errand(task, &path),
        }
    }

    /// Shows the first question that is asked in the window.
    pub(in crate::app) fn show_question(&mut self, ctx: &Context) {
        let is_here = |question: &Question| matches!(question.asked, Asked::Window { .. });
        let Some(index) = self.questions.iter().position(is_here) else { return };
        let question = &mut self.questions[index];
        let window = Window::new(question.purpose.title()).collapsible(false).resizable(false);
        let width = (ctx.content_rect().width() - 40.0).clamp(120.0, 460.0);
        let window = window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).default_width(width).max_width(width);
        match window.show(ctx, |ui| question.show(ui, width)).and_then(|shown| shown.inner).unwrap_or(Answer::None) {
            Answer::None => {}
            Answer::Cancel => drop(self.questions.remove(index)),
            Answer::Path(path) => {
                let question = self.questions.remove(index);
                self.take_path(question.purpose, path);
            }
        }
    }
}

/// What the user has done about a question.
enum Answer {
    None,
    Cancel,
    Path(PathBuf),
}

impl Question {
    fn show(&mut self, ui: &mut Ui, width: f32) -> Answer {
        let Asked::Window { path, problem, is_new } = &mut self.asked else { return Answer::None };
        let verb = match &self.purpose {
            Purpose::Open | Purpose::Environment => "Open",
            Purpose::Save { .. } | Purpose::Task(Task::Bake) if Path::new(path.trim()).is_file() => "Replace",
            Purpose::Save { .. } => "Save",
            Purpose::Task(_) => "Make",
        };
        let name = ui.label("path").id;
        let field = ui.add(TextEdit::singleline(path).desired_width(width)).labelled_by(name);
        if std::mem::take(is_new) {
            field.request_focus();
        }
        let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        let is_left = ui.input(|input| input.key_pressed(Key::Escape));
        if !problem.is_empty() {
            ui.colored_label(ui.visuals().warn_fg_color, problem.as_str());
        }
        let (is_done, is_off) = ui.horizontal(|ui| (ui.button(verb).clicked(), ui.button("Cancel").clicked())).inner;
        match () {
            () if is_off || is_left => Answer::Cancel,
            () if is_done || is_entered => match self.purpose.check(path) {
                Ok(path) => Answer::Path(path),
                Err(reason) => {
                    (*problem, *is_new) = (reason, true);
                    Answer::None
                }
            },
            () => Answer::None,
        }
    }
}

/// A path that nothing has: with a number before its extension where there is something.
fn free(path: &Path) -> PathBuf {
    let Some(stem) = path.file_stem().filter(|_| path.is_file() || path.join("report.html").is_file()) else {
        return path.to_path_buf();
    };
    let extension = path.extension().map(|extension| format!(".{}", extension.display())).unwrap_or_default();
    let numbered = |number: u32| path.with_file_name(format!("{}-{number}{extension}", stem.display()));
    (2..10_000).map(numbered).find(|path| !path.exists()).unwrap_or_else(|| path.to_path_buf())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_checked_and_completed() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        std::fs::write(place("picture.png"), []).unwrap();
        let save = Purpose::Save { name: "picture.png".into(), extension: "png", make: Box::new(|_| Ok(Vec::new())) };
        let check = |purpose: &Purpose, path: PathBuf| purpose.check(&path.display().to_string());
        assert_eq!(check(&save, place("a")), Ok(place("a.png")));
        assert_eq!(check(&save, place("a.exr")), Ok(place("a.exr")));
        assert_eq!(free(&place("picture.png")), place("picture-2.png"));
        assert_eq!(free(&place("other.png")), place("other.png"));
        let problem = |purpose: &Purpose, path: PathBuf| check(purpose, path).unwrap_err();
        assert!(problem(&save, place("missing/a.png")).contains("there is no folder"));
        assert!(problem(&save, folder.path().into()).contains("is a folder"));
        assert!(problem(&Purpose::Open, place("a.glb")).contains("there is no such file"));
        assert!(problem(&Purpose::Open, folder.path().into()).contains("is a folder"));
        assert_eq!(check(&Purpose::Open, place("picture.png")), Ok(place("picture.png")));
        assert!(Purpose::Open.check("  ").is_err());
    }
}
