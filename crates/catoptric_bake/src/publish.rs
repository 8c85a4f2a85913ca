//! Files that appear whole or not at all, and stay after a power cut.

use catoptric::output::Temporary;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::Path;

/// Creates a file unless there is one of that name; returns true if it did.
pub(crate) fn create_new(path: &Path, bytes: &[u8]) -> io::Result<bool> {
    let mut file = Temporary::beside(path)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    match fs::hard_link(file.path(), path) {
        Ok(()) => drop(file),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => return Ok(false),
        Err(error) if has_no_links(&error) => {
            if !rename_to_new(file, path, &error)? {
                return Ok(false);
            }
        }
        Err(error) => return Err(error),
    }
    sync_folder(path)?;
    Ok(true)
}

/// The errors of file systems without hard links, such as FAT.
fn has_no_links(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::PermissionDenied | ErrorKind::Unsupported | ErrorKind::TooManyLinks)
}

/// The way without hard links: a rename that fails if the name is taken is one step of the file system as well
/// (renameat2 of Linux, renamex_np of macOS, MoveFileEx of Windows). It comes second, since network file systems
/// support links better.
fn rename_to_new(file: Temporary, path: &Path, no_links: &io::Error) -> io::Result<bool> {
    match file.publish_new(path) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(false),
        Err(error) if has_no_links(&error) => Err(io::Error::new(
            error.kind(),
            format!(
                "the file system can neither link ({no_links}) nor rename without overwriting ({error}), so two \
                writers could destroy each other's work; use a folder of another file system"
            ),
        )),
        Err(error) => Err(error),
    }
}

/// Puts a temporary file in the place of a path, also of a file that is there, or into a device.
pub(crate) fn replace(file: Temporary, path: &Path) -> io::Result<()> {
    file.as_file().sync_all()?;
    file.publish(path)?;
    sync_folder(path)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A new name survives a power cut only once its folder is on the disk.
fn sync_folder(path: &Path) -> io::Result<()> {
    // Elsewhere folders cannot be opened, and names are written with the files.
    if !cfg!(unix) {
        return Ok(());
    }
    match File::open(folder_of(path)).and_then(|folder| folder.sync_all()) {
        // Some network file systems cannot; their servers write names at once.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        result => result,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renames_where_links_are_missing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        let no_links = io::Error::from(ErrorKind::Unsupported);
        assert!(has_no_links(&no_links));
        for (bytes, is_new) in [(b"one", true), (b"two", false)] {
            let mut file = Temporary::beside(&path).unwrap();
            file.write_all(bytes).unwrap();
            assert_eq!(rename_to_new(file, &path, &no_links).unwrap(), is_new);
        }
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn replaces_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        fs::write(&path, b"old").unwrap();
        let mut file = Temporary::beside(&path).unwrap();
        file.write_all(b"new").unwrap();
        replace(file, &path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        let missing = Temporary::beside(&folder.path().join("no/x")).unwrap_err().to_string();
        assert!(missing.contains("does not exist; create it first"), "{missing}");
    }

    #[cfg(unix)]
    #[test]
    fn others_can_read_what_is_published() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, usual) = (folder.path().join("x"), folder.path().join("usual"));
        assert!(create_new(&path, b"x").unwrap());
        fs::write(&usual, b"").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&usual));
    }
}
