//! What can go wrong with input and environment; a bug panics instead, an expected numerical miss is a counted value.

use std::path::PathBuf;

/// A scene, picture or environment that cannot be used. The message names the file, the field and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be read.
    #[error("{}: cannot read it: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file could not be written.
    #[error("{}: cannot write it: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A field of the file is missing, wrong or out of range.
    #[error("{file}: {field}: {problem}")]
    Invalid {
        /// The file, or the built-in scene's name.
        file: String,
        /// The field at fault, such as `accessors[3].count`.
        field: String,
        /// What is wrong with it and what is allowed.
        problem: String,
    },
    /// The file needs something this program does not have.
    #[error("{file}: needs {feature}, which is not supported: {remedy}")]
    Unsupported {
        /// The file.
        file: String,
        /// What it needs, such as the name of a glTF extension.
        feature: String,
        /// What the user can do about it.
        remedy: String,
    },
    /// The scene, camera or light asked for does not exist.
    #[error("there is no {kind} `{name}`; there are: {known}")]
    Unknown {
        /// What kind of thing was asked for.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
}

impl SceneError {
    /// A wrong field of a file.
    pub fn invalid(file: impl Into<String>, field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { file: file.into(), field: field.into(), problem: problem.into() }
    }
}

/// A picture that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No method has this id.
    #[error("there is no method `{id}`; the methods are: {known}")]
    UnknownMethod {
        /// The id asked for.
        id: String,
        /// The ids that exist.
        known: String,
    },
    /// A setting of a method is unknown or has a value that is not allowed.
    #[error("method `{method}`: {problem}")]
    Setting {
        /// The method's id.
        method: &'static str,
        /// What is wrong, and which settings or values there are.
        problem: String,
    },
    /// The number of samples a pixel is not one that the rasteriser can take.
    #[error("samples = {samples}: methods that rasterise take 1, 2, 4, 8 and 16 samples a pixel")]
    Samples {
        /// The number asked for.
        samples: u32,
    },
    /// The picture asked for is outside what the method can draw.
    #[error("method `{method}` cannot do this: {problem}")]
    Limit {
        /// The method's id.
        method: &'static str,
        /// Which limit is passed and what is allowed.
        problem: String,
    },
}
