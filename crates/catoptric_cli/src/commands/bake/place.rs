//! Places that plans and units are published in, as the command line names them: a folder or an object store.

use crate::failure::Failure;
use catoptric_bake::{LocalStore, Store};
use std::path::Path;

/// The store of a place that has a plan.
pub(super) fn open(place: &str) -> Result<Box<dyn Store>, Failure> {
    match is_address(place) {
        true => object_store(place),
        false => Ok(Box::new(LocalStore::open(place)?)),
    }
}

/// The store of a place that a plan is to be published in; a folder is created where it is missing.
pub(super) fn create(place: &str) -> Result<Box<dyn Store>, Failure> {
    match is_address(place) {
        true => object_store(place),
        false => Ok(Box::new(LocalStore::create_folder(place)?)),
    }
}

/// Refuses what is no place, before any work.
pub(super) fn check(place: &str) -> Result<(), Failure> {
    if is_address(place) { object_store(place).map(drop) } else { Ok(()) }
}

/// True for the address of an object store, such as `s3://bucket/prefix`; all else is a folder.
fn is_address(place: &str) -> bool {
    place.contains("://")
}

#[cfg(feature = "cloud")]
fn object_store(address: &str) -> Result<Box<dyn Store>, Failure> {
    use catoptric_bake_cloud::ObjectStore;
    // Others are not for it.
    let variables =
        std::env::vars_os().filter_map(|(name, value)| name.into_string().ok().zip(value.into_string().ok()));
    Ok(Box::new(ObjectStore::open(address, ObjectStore::PATIENCE, variables)?))
}

#[cfg(not(feature = "cloud"))]
fn object_store(address: &str) -> Result<Box<dyn Store>, Failure> {
    Err(without_cloud(address))
}

/// The refusal of what only programs with the feature `cloud` can do.
#[cfg(not(feature = "cloud"))]
pub(super) fn without_cloud(subject: &str) -> Failure {
    Failure::input(format!(
        "{subject}: this program was built without object stores and the scripts of clusters: get it with them by \
        `cargo install catoptric_cli --features cloud` (or build it with `--features cloud`), or bake in a folder that \
        all machines see, with `bake run FOLDER --shard I/N` on each"
    ))
}

/// Refuses what no file can be called, before any work.
pub(super) fn check_file(path: &Path) -> Result<(), Failure> {
    let parent = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let problem = match () {
        () if path.is_dir() => "it is a folder; name a file".to_owned(),
        () if !parent.is_dir() => format!("the folder {} does not exist; create it first", parent.display()),
        () => return Ok(()),
    };
    Err(Failure::input(format!("{}: {problem}", path.display())))
}
