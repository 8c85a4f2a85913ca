//! Writing of files.

use catoptric_core::error::SceneError;
use catoptric_core::output::{NewFolders, check_writable, is_same_file, move_file, write_file};
use std::fs;
use std::io::{self, Write};
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn write(path: &Path, text: &str) -> Result<(), SceneError> {
    write_file(path, |writer| writer.write_all(text.as_bytes()))
}

#[test]
fn failures_name_the_file_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no/where.png");
    for error in [write(&missing, "").unwrap_err(), check_writable(&missing).unwrap_err()] {
        let message = error.to_string();
        assert!(message.contains("where.png") && message.contains("does not exist"), "{message}");
    }
    assert!(check_writable(folder.path()).unwrap_err().to_string().contains("folder"));
    let failing = write_file(&folder.path().join("b.txt"), |_| Err(io::Error::other("full")));
    assert!(failing.unwrap_err().to_string().contains("full"));
    assert!(names(folder.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn symbolic_links_stay_and_their_files_are_replaced() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("deep")).unwrap();
    fs::write(path("deep/old"), "old").unwrap();
    for (link, target) in [("one", "deep/old"), ("two", "one"), ("new", "deep/new"), ("circle", "circle")] {
        symlink(target, path(link)).unwrap();
    }
    write(&path("two"), "text").unwrap();
    write(&path("new"), "more").unwrap();
    assert_eq!(fs::read_to_string(path("deep/old")).unwrap(), "text");
    assert_eq!(fs::read_to_string(path("deep/new")).unwrap(), "more");
    assert!(["one", "two", "new"].iter().all(|link| path(link).is_symlink()));
    assert!(write(&path("circle"), "").unwrap_err().to_string().contains("link to itself"));
    fs::write(path("from"), "moved").unwrap();
    move_file(&path("from"), &path("one")).unwrap();
    assert!(path("one").is_symlink() && fs::read_to_string(path("deep/old")).unwrap() == "moved");
    assert_eq!(names(folder.path()), ["circle", "deep", "new", "one", "two"]);
    assert!(is_same_file(&path("two"), &path("deep/../deep/old")) && !is_same_file(&path("two"), &path("new")));
}

#[test]
fn spellings_of_one_file_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    assert!(is_same_file(&path("a/b"), &path("./c/../a/./b")) && !is_same_file(&path("a/b"), &path("b")));
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_through() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("link");
    std::os::unix::fs::symlink("/dev/full", &link).unwrap();
    check_writable(&link).unwrap();
    let message = write(&link, "text").unwrap_err().to_string();
    assert!(message.contains("link") && message.contains("No space"), "{message}");
    write(Path::new("/dev/null"), "text").unwrap();
    assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
    assert_eq!(names(folder.path()), ["link"]);
}

#[test]
fn folders_that_stay_empty_go() {
    let folder = tempfile::tempdir().unwrap();
    let mut folders = NewFolders::default();
    folders.create(&folder.path().join("a/b")).unwrap();
    folders.create(&folder.path().join("c/d")).unwrap();
    write(&folder.path().join("c/file"), "").unwrap();
    drop(folders);
    assert_eq!((names(folder.path()), names(&folder.path().join("c"))), (vec!["c".into()], vec!["file".into()]));
}
