//! The program `catoptric`, which makes reports and bakes, on this machine.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Returns the file that `CATOPTRIC_PROGRAM` names, else the program beside this one, else the first on `PATH`; `None`
/// if there is none.
pub(super) fn find() -> Option<PathBuf> {
    let own = std::env::current_exe().ok();
    choose(std::env::var_os("CATOPTRIC_PROGRAM"), own.as_deref(), std::env::var_os("PATH"))
}

/// The same, of a file's name, this program's own file and folders as `PATH` has them.
fn choose(named: Option<OsString>, own: Option<&Path>, path: Option<OsString>) -> Option<PathBuf> {
    // A word without folders would be looked for on PATH.
    if let Some(named) = named.filter(|named| !named.is_empty()) {
        return std::path::absolute(named).ok();
    }
    let name = format!("catoptric{}", std::env::consts::EXE_SUFFIX);
    let folders = own.and_then(Path::parent).map(Path::to_path_buf).into_iter();
    let on_path = path.iter().flat_map(std::env::split_paths).filter(|folder| folder.is_absolute());
    folders.chain(on_path).map(|folder| folder.join(&name)).find(|file| is_executable(file))
}

#[cfg(unix)]
fn is_executable(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    file.metadata().is_ok_and(|about| about.is_file() && about.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_executable(file: &Path) -> bool {
    file.is_file()
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::fs::{Permissions, create_dir, set_permissions, write};
    use std::os::unix::fs::PermissionsExt;

    /// Makes a folder with an empty file of the program's name.
    fn put(folder: &Path, mode: u32) -> PathBuf {
        create_dir(folder).unwrap();
        let file = folder.join("catoptric");
        write(&file, []).unwrap();
        set_permissions(&file, Permissions::from_mode(mode)).unwrap();
        file
    }

    #[test]
    fn what_is_named_comes_before_the_neighbour_and_this_before_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let [first, second, beside] = ["first", "second", "beside"].map(|name| folder.path().join(name));
        let own = beside.join("catoptric_viewer");
        let path = || Some(std::env::join_paths([Path::new(""), Path::new("relative"), &first, &second]).unwrap());
        assert_eq!(choose(None, Some(&own), path()), None);
        // One that may not be run is none.
        put(&first, 0o644);
        let on_path = put(&second, 0o755);
        assert_eq!(choose(None, Some(&own), path()), Some(on_path.clone()));
        assert_eq!(choose(Some("".into()), None, path()), Some(on_path));
        let neighbour = put(&beside, 0o755);
        assert_eq!(choose(None, Some(&own), path()), Some(neighbour));
        // Even where it is missing: starting it says so.
        let named = choose(Some("some_program".into()), Some(&own), path()).unwrap();
        assert!(named.is_absolute() && named.ends_with("some_program"));
    }
}
