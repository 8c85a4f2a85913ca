//! Paths that the user is asked for, by the system's dialogue or in the window.

use super::errand::Task;
use super::file::Make;
use eframe::egui::{Key, TextEdit, Ui};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// The purpose of a path.
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
    /// A file that the program makes.
    Task(Task),
}

/// A path that is not known yet.
pub(in crate::app) struct Question {
    pub(in crate::app) purpose: Purpose,
    pub(in crate::app) asked: Asked,
}

/// Where the user is asked.
pub(in crate::app) enum Asked {
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
    pub(in crate::app) fn title(&self) -> String {
        match self {
            Self::Open => "Open a scene or a bake".into(),
            Self::Environment => "A picture of light from infinity".into(),
            Self::Save { extension, .. } => format!("Save as .{extension}"),
            Self::Task(Task::Report) => "A folder for the report".into(),
            Self::Task(Task::Bake) => "A file for the bake".into(),
        }
    }

    /// The name that is proposed; empty for what is there already.
    pub(in crate::app) fn name(&self) -> &str {
        match self {
            Self::Open | Self::Environment => "",
            Self::Save { name, .. } => name,
            Self::Task(Task::Report) => "report",
            Self::Task(Task::Bake) => "scene.bake",
        }
    }

    /// Has the system ask, which takes as long as the user likes.
    pub(in crate::app) fn dialogue(&self) -> impl FnOnce() -> Option<PathBuf> + Send + 'static {
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
    pub(in crate::app) fn check(&self, answer: &str) -> Result<PathBuf, String> {
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

/// The user's answer to a question.
pub(in crate::app) enum Answer {
    None,
    Cancel,
    Path(PathBuf),
}

impl Question {
    pub(in crate::app) fn show(&mut self, ui: &mut Ui, width: f32) -> Answer {
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
pub(in crate::app) fn free(path: &Path) -> PathBuf {
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
