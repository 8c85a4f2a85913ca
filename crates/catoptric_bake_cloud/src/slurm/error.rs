//! Bakes that cannot be submitted.

use catoptric::error::SceneError;
use std::io;

/// A bake that cannot be submitted.
#[derive(Debug, thiserror::Error)]
pub enum SlurmError {
    /// An option for `sbatch` is not one for these scripts.
    #[error("{option}: {problem}")]
    Option {
        /// The option.
        option: String,
        /// The fault, and what is allowed.
        problem: &'static str,
    },
    /// A path is one that scripts cannot contain.
    #[error("{path}: job scripts need a path of Unicode without control characters and backslashes; rename it")]
    Path {
        /// The path, as far as it is Unicode.
        path: String,
    },
    /// The folder of scripts and messages cannot be made.
    #[error("{folder}: cannot create it: {source}")]
    Folder {
        /// The folder.
        folder: String,
        /// The message of the operating system.
        source: io::Error,
    },
    /// A script cannot be written.
    #[error(transparent)]
    Write(#[from] SceneError),
    /// `sbatch` cannot be started, or has refused a job.
    #[error("sbatch: {problem}")]
    Refused {
        /// The fault, and the remedy where there is one.
        problem: String,
    },
    /// The array is submitted, the job after it is not.
    #[error(
        "{source}; job {array} is submitted already, without the job that merges: cancel it (scancel {array}), or wait \
        for it and merge"
    )]
    Half {
        /// The number of the array.
        array: String,
        /// The fault of the job after it.
        source: Box<SlurmError>,
    },
}
