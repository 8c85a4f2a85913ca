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
    #[error("there is no {kind} `{name}`; there are: {known}")]
    Unknown {
        /// The kind of the requested item.
        kind: &'static str,
        /// The requested name.
        name: String,
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
}
