//! Names of files without the folders of this machine, for reports that go to other people.

use super::content::{Outcome, Report};
use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Absolute paths that a command names, and what stands for them.
pub(crate) struct PlainNames {
    /// Beginnings of paths and what is written in their place, the longest first.
    beginnings: Vec<(String, String)>,
}

impl PlainNames {
    /// The names in the words of a command line and of files that are named elsewhere.
    pub(crate) fn new(words: &[OsString], files: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut paths: Vec<PathBuf> = files.into_iter().collect();
        for word in words.iter().map(|word| word.to_string_lossy()) {
            // Paths stand alone, or after `=` and in lists of settings.
            let starts = word.match_indices(['=', ':', ',']).map(|(at, _)| at + 1);
            let ends = |part: &str| part.split(',').next().map(PathBuf::from);
            paths.push(PathBuf::from(&*word));
            paths.extend(starts.filter_map(|at| ends(&word[at..])));
        }
        let mut beginnings: Vec<(String, String)> = Vec::new();
        for path in paths.iter().filter(|path| path.is_absolute()) {
            let Some(name) = path.file_name() else { continue };
            beginnings.push((path.display().to_string(), name.display().to_string()));
            beginnings.extend(path.parent().and_then(beginning));
        }
        beginnings.extend(env::current_dir().ok().as_deref().and_then(beginning));
        beginnings.sort_by(|a, b| b.0.len().cmp(&a.0.len()).then(a.cmp(b)));
        beginnings.dedup();
        Self { beginnings }
    }

    /// The text without these folders.
    pub(crate) fn of(&self, text: &str) -> String {
        self.beginnings.iter().fold(text.to_owned(), |text, (path, name)| replaced(&text, path, name))
    }

    /// Changes the texts of a report that may name files, but for its command.
    pub(crate) fn apply(&self, report: &mut Report) {
        let change = |text: &mut String| *text = self.of(text);
        let values = |settings: &mut serde_json::Map<String, serde_json::Value>| {
            for value in settings.values_mut() {
                if let serde_json::Value::String(text) = value {
                    change(text);
                }
            }
        };
        for entry in &mut report.entries {
            change(&mut entry.label);
            entry.variant.as_mut().map(change);
            values(&mut entry.settings);
            match &mut entry.outcome {
                Outcome::Failed(problem) => change(problem),
                Outcome::Measured(measured) => {
                    measured.stats.warnings.iter_mut().for_each(change);
                    values(&mut measured.stats.settings);
                }
            }
        }
    }
}

/// Replaces a beginning of paths where no other part of a path is before it.
fn replaced(text: &str, path: &str, name: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(path) {
        let (before, found) = rest.split_at(at);
        out += before;
        let is_inside = out.ends_with(|c: char| c.is_alphanumeric() || "._-/".contains(c));
        out += if is_inside { path } else { name };
        rest = &found[path.len()..];
    }
    out + rest
}

/// A folder with the separator after it, in whose place nothing is written; `None` for the root.
fn beginning(folder: &Path) -> Option<(String, String)> {
    folder.file_name()?;
    Some((format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), String::new()))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn folders_of_this_machine_are_left_out() {
        let words =
            ["compare", "/home/me/a b/room.glb", "--set=light_field.views=/data/v.toml,x=1", "--baked", "x.bake"];
        let words: Vec<OsString> = words.map(OsString::from).into();
        let names = PlainNames::new(&words, [PathBuf::from("/sky.hdr")]);
        let text = "'/home/me/a b/room.glb': /home/me/a b/textures/x.png, views=/data/v.toml,x=1 /sky.hdr x/data/y";
        assert_eq!(names.of(text), "'room.glb': textures/x.png, views=v.toml,x=1 sky.hdr x/data/y");
    }
}
