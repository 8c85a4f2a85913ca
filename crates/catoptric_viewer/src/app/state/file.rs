//! Files on their way: what is saved, and in browsers what is chosen.

use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

/// Makes a file's content, told the path where it will be.
pub(in crate::app) type Make = Box<dyn FnOnce(&Path) -> Result<Vec<u8>, String> + Send>;

/// The outcome of saving a file: its path, or a problem; nothing if the user has changed their mind.
pub(in crate::app) type Saved = Receiver<Result<PathBuf, String>>;

/// The outcome of a choice: names and contents of files, or a problem; nothing if the user has changed their mind.
#[cfg(target_family = "wasm")]
pub(in crate::app) type Choice = Receiver<Result<Contents, String>>;

/// Names and contents of files.
#[cfg(target_family = "wasm")]
pub(in crate::app) type Contents = Vec<(String, Vec<u8>)>;
