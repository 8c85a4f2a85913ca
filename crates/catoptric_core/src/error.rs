//! Errors of scenes and pictures; a bug panics instead, an expected numerical miss is a counted value.

use std::path::PathBuf;

/// A scene, picture or environment that cannot be used. The message names the file, the field and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be read.
    #[error("{}: cannot read it: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's message.
        source: std::io::Error,
    },
    /// The file could not be written.
    #[error("{}: cannot write it: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The operating system's message.
        source: std::io::Error,
    },
    /// A field of the file is missing, wrong or out of range.
    #[error("{file}: {field}: {problem}")]
    Invalid {
        /// The file, or the built-in scene's name.
        file: String,
        /// The field at fault, such as `accessors[3].count`.
        field: String,
        /// The fault, and the values that are allowed.
        problem: String,
    },
    /// The file needs something this program does not have.
    #[error("{file}: needs {feature}, which is not supported: {remedy}")]
    Unsupported {
        /// The file.
        file: String,
        /// The missing feature, such as the name of a glTF extension.
        feature: String,
        /// The remedy for the user.
        remedy: String,
    },
    /// The requested scene, camera or light does not exist.
    #[error("there is no {kind} `{name}`{hint}; there are: {known}")]
    Unknown {
        /// The kind of the requested item.
        kind: &'static str,
        /// The requested name.
        name: String,
        /// The name that was probably meant, as [`did_you_mean`] says it.
        hint: String,
        /// The names that exist.
        known: String,
    },
}

impl SceneError {
    /// The message without the name of the file, for warnings that stand beside it.
    pub fn without_file(&self) -> String {
        match self {
            Self::Read { source, .. } => format!("cannot be read: {source}"),
            Self::Invalid { field, problem, .. } => format!("{field}: {problem}"),
            other => other.to_string(),
        }
    }

    /// A wrong field of a file.
    pub fn invalid(file: impl Into<String>, field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { file: file.into(), field: field.into(), problem: problem.into() }
    }

    /// The error about a name that is none of those known; `listed` is how the message lists them.
    pub fn unknown<'a>(
        kind: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
        listed: impl Into<String>,
    ) -> Self {
        Self::Unknown { kind, name: name.into(), hint: did_you_mean(name, known), known: listed.into() }
    }
}

/// Names of more letters are compared with no others, so that files with many long ones are refused as fast.
const MAX_LETTERS: usize = 64;

/// The name that was probably meant by one that is not known, as an addition to a message about it:
/// ` (did you mean `ball`?)`, or empty where none is like it.
///
/// Alike are names that differ in a third of their letters at most (in one at least), and those that begin with three
/// letters or more of what was given. Capital letters and the stars of patterns do not count.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let plain = |name: &str| name.trim().trim_matches('*').to_lowercase();
    let given = plain(name);
    let letters = given.chars().count();
    if letters == 0 || letters > MAX_LETTERS {
        return String::new();
    }
    let most = (letters / 3).max(1);
    let distance = |other: &str| {
        let other_letters = other.chars().count();
        let is_near = other_letters.abs_diff(letters) <= most;
        let by_letters = is_near.then(|| strsim::osa_distance(&given, other)).filter(|distance| *distance <= most);
        by_letters.or((letters >= 3 && other.starts_with(&given)).then_some(most))
    };
    let alike = known.into_iter().filter(|known| known.len() <= 4 * MAX_LETTERS);
    let alike = alike.filter_map(|known| Some((distance(&plain(known))?, known)));
    alike.min().map_or_else(String::new, |(_, known)| format!(" (did you mean `{known}`?)"))
}
