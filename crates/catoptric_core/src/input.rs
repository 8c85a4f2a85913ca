//! Reading files whole, in one place for all readers.

use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// The bytes of a plain file of at most `limit` bytes.
///
/// # Errors
/// Errors of the system; [`ErrorKind::IsADirectory`] for folders, [`ErrorKind::InvalidInput`] for pipes and devices,
/// which may never end, and [`ErrorKind::FileTooLarge`].
pub fn read_file(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    // Before it is opened, as opening a pipe waits for its writer, and again: it may have changed.
    check(&fs::metadata(path)?, limit)?;
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    check(&metadata, limit)?;
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    file.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn check(metadata: &Metadata, limit: u64) -> io::Result<()> {
    let (kind, problem) = if metadata.is_dir() {
        (ErrorKind::IsADirectory, "is a folder, no file".into())
    } else if !metadata.is_file() {
        (ErrorKind::InvalidInput, "is a pipe or device, no plain file; copy it into a file first".into())
    } else if metadata.len() > limit {
        (ErrorKind::FileTooLarge, format!("has {} bytes; at most {limit} are allowed", metadata.len()))
    } else {
        return Ok(());
    };
    Err(io::Error::new(kind, problem))
}
