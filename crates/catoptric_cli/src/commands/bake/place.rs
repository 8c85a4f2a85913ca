//! Places that plans and units are published in, as the command line names them: a folder or an object store.

use crate::failure::Failure;
use catoptric_bake::{LocalStore, Store};

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
pub(super) fn is_address(place: &str) -> bool {
    place.contains("://")
}

#[cfg(feature = "object_stores")]
fn object_store(address: &str) -> Result<Box<dyn Store>, Failure> {
    use catoptric_bake::ObjectStore;
    // Others are not for it.
    let variables =
        std::env::vars_os().filter_map(|(name, value)| name.into_string().ok().zip(value.into_string().ok()));
    Ok(Box::new(ObjectStore::open(address, ObjectStore::PATIENCE, variables)?))
}

#[cfg(not(feature = "object_stores"))]
fn object_store(address: &str) -> Result<Box<dyn Store>, Failure> {
    Err(Failure::input(format!(
        "{address}: this program was built without object stores (its feature `object_stores`); name a folder that all \
        machines see, or build it with them"
    )))
}
