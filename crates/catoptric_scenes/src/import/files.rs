//! Reading files that a user or a scene names, with a limit on their size.

use catoptric_core::error::SceneError;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The largest scene, buffer or picture file that is read.
pub(super) const MAX_SCENE_BYTES: u64 = 2 << 30;

/// Finds the files that a scene names, such as buffers and pictures.
pub trait Resolver: Sync {
    /// The bytes of a file by its name relative to the scene; a file of more than `limit` bytes is an error.
    ///
    /// # Errors
    /// [`SceneError`] when there is no such file or it is too large.
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError>;
}

/// Finds files relative to a folder.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// The folder in which a file lies.
    pub fn of(file: &Path) -> Self {
        Self { path: file.parent().map(Path::to_path_buf).unwrap_or_default() }
    }
}

impl Resolver for Folder {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        let path = self.path.join(name);
        if Path::new(name).is_absolute() {
            let problem = format!("names the absolute path `{name}`; write it relative to the scene");
            return Err(SceneError::invalid(path.display().to_string(), "path", problem));
        }
        read(&path, limit)
    }
}

/// For scenes that must stand alone: every other file is missing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Resolver for NoFiles {
    fn read(&self, name: &str, _limit: u64) -> Result<Vec<u8>, SceneError> {
        Err(SceneError::invalid(name, "path", "other files cannot be read here; embed them in the scene"))
    }
}

/// All bytes of a plain file of at most `limit` bytes.
pub(super) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, SceneError> {
    let failed = |source| SceneError::Read { path: path.to_path_buf(), source };
    let invalid = |problem: String| SceneError::invalid(path.display().to_string(), "file", problem);
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    // Devices and pipes may never end.
    if !metadata.is_file() {
        return Err(invalid("is no plain file".into()));
    }
    if metadata.len() > limit {
        return Err(invalid(format!("has {} bytes; at most {limit} are allowed", metadata.len())));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    file.take(limit).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// The text of a plain file of at most `limit` bytes.
pub(super) fn read_text(path: &Path, limit: u64) -> Result<String, SceneError> {
    let bytes = read(path, limit)?;
    text(&path.display().to_string(), &bytes).map(str::to_owned)
}

/// The text that a file's bytes are; `name` is for messages.
pub(super) fn text<'a>(name: &str, bytes: &'a [u8]) -> Result<&'a str, SceneError> {
    std::str::from_utf8(bytes)
        .map_err(|error| SceneError::invalid(name, "file", format!("byte {} is no UTF-8 text", error.valid_up_to())))
}
