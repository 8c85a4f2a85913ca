//! A bake as an array job of Slurm.
//!
//! Slurm starts the tasks of a lost machine again, crashed ones it does not. So a second job waits for the array,
//! however that ends, submits what is missing again, and merges.

mod error;
mod place;
mod script;

pub use error::SlurmError;
pub use script::SlurmScripts;

use catoptric::output;
use std::ffi::OsStr;
use std::fs;
use std::io::{ErrorKind, Write};
use std::process::Command;

/// The numbers of the jobs of a bake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlurmJobs {
    /// The array, a task a shard.
    pub array: String,
    /// The job after it, which makes what is missing again and merges.
    pub finish: String,
}

impl SlurmScripts {
    /// Writes the scripts and submits them.
    ///
    /// # Errors
    /// [`SlurmError::Folder`], [`SlurmError::Write`], [`SlurmError::Refused`] if nothing is submitted,
    /// [`SlurmError::Half`] if the array alone is.
    pub fn submit(&self) -> Result<SlurmJobs, SlurmError> {
        let folder = self.folder();
        fs::create_dir_all(folder)
            .map_err(|source| SlurmError::Folder { folder: folder.display().to_string(), source })?;
        for (path, text) in self.files() {
            output::write_file(&path, |writer| writer.write_all(text.as_bytes()))?;
        }
        let array = sbatch(&[OsStr::new("--parsable"), self.bake_path().as_os_str()])?;
        let dependency = format!("--dependency=afterany:{array}");
        let finish = sbatch(&[OsStr::new("--parsable"), OsStr::new(&dependency), self.finish_path().as_os_str()]);
        match finish {
            Ok(finish) => Ok(SlurmJobs { array, finish }),
            Err(source) => Err(SlurmError::Half { array, source: Box::new(source) }),
        }
    }
}

/// Submits a job; returns its number.
fn sbatch(words: &[&OsStr]) -> Result<String, SlurmError> {
    let refused = |problem: String| SlurmError::Refused { problem };
    let ended = Command::new("sbatch").args(words).output().map_err(|error| match error.kind() {
        ErrorKind::NotFound => refused(
            "there is no such program here; submit on a machine of the cluster that has Slurm's commands (Debian's \
            package slurm-client), or take the scripts that --dry-run prints there"
                .into(),
        ),
        _ => refused(format!("cannot start it: {error}")),
    })?;
    let said = String::from_utf8_lossy(&ended.stderr);
    // With several clusters the number is followed by `;` and the cluster's name.
    let number: String = String::from_utf8_lossy(&ended.stdout).chars().take_while(char::is_ascii_digit).collect();
    if ended.status.success() && !number.is_empty() {
        return Ok(number);
    }
    let remedy = match said.contains("job array") {
        true => "; give fewer --tasks: `scontrol show config` says how many an array may have (MaxArraySize)",
        false => "",
    };
    Err(refused(format!("{} ({}){remedy}", said.trim().replace('\n', "; "), ended.status)))
}
