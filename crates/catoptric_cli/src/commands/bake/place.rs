//! Places that plans and units are published in, as the command line names them.

use crate::failure::Failure;
use catoptric_bake::{LocalStore, Store};
use std::path::Path;

/// The store of a place that has a plan.
pub(super) fn open(place: &str) -> Result<Box<dyn Store>, Failure> {
    Ok(Box::new(LocalStore::open(folder(place)?)?))
}

/// The store of a place that a plan is to be published in; a folder is created where it is missing.
pub(super) fn create(place: &str) -> Result<Box<dyn Store>, Failure> {
    Ok(Box::new(LocalStore::create_folder(folder(place)?)?))
}

/// Refuses what is no place, before any work.
pub(super) fn check(place: &str) -> Result<(), Failure> {
    folder(place).map(drop)
}

/// True for the address of an object store, such as `s3://bucket/prefix`; all else is a folder.
pub(super) fn is_address(place: &str) -> bool {
    place.contains("://")
}

/// The folder that a place is.
fn folder(place: &str) -> Result<&Path, Failure> {
    match place.split_once("://") {
        Some((scheme, _)) => Err(Failure::input(format!(
            "{place}: this version bakes into folders, not into {scheme}: stores; name a folder that all machines see"
        ))),
        None => Ok(Path::new(place)),
    }
}
