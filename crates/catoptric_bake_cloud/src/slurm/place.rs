//! Names and paths that follow from the place of a plan: a folder, or the address of an object store.

use crate::object::is_address;
use std::path::{Path, PathBuf};

/// The last part of a place's name, without the `.parts` that folders of units usually have.
pub(super) fn name(place: &str) -> &str {
    let last = place.trim_end_matches('/').rsplit('/').next().unwrap_or_default();
    let name = last.strip_suffix(".parts").unwrap_or(last);
    if name.trim_matches('.').is_empty() { "scene" } else { name }
}

/// The file beside the place.
pub(super) fn default_output(place: &str) -> PathBuf {
    let file = format!("{}.bake", name(place));
    if is_address(place) { file.into() } else { absolute(Path::new(place)).with_file_name(file) }
}

/// A place as other machines find it.
pub(super) fn whole_place(place: &str) -> PathBuf {
    if is_address(place) { place.into() } else { absolute(Path::new(place)) }
}

/// The folder of scripts and messages: that of the plan; for plans in object stores one in the current folder.
pub(super) fn script_folder(place: &str) -> PathBuf {
    let folder = format!("{}.slurm", name(place));
    if is_address(place) { absolute(Path::new(&folder)) } else { absolute(Path::new(place)) }
}

pub(super) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_lie_beside_their_place() {
        assert_eq!(default_output("/a/room.parts/"), Path::new("/a/room.bake"));
        assert_eq!(default_output("/a/room"), Path::new("/a/room.bake"));
        assert_eq!(default_output("s3://bucket/rooms/room.parts"), Path::new("room.bake"));
        assert_eq!(script_folder("/a/room.parts"), Path::new("/a/room.parts"));
        assert!(script_folder("s3://bucket/room").ends_with("room.slurm") && script_folder("s3://b/c").is_absolute());
        assert_eq!((name("."), name("s3://bucket/"), whole_place("s3://b/c")), ("scene", "bucket", "s3://b/c".into()));
    }
}
