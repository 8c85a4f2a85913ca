//! Stores in which plans and units are published: a folder, or anything with the operations of an object store.

mod local;

pub use local::LocalStore;

use crate::error::BakeError;

/// The outcome of creating a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Created {
    /// The file is there now, whole.
    New,
    /// There was one already; it is as it was.
    Existed,
}

/// A file of a store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The file's name.
    pub name: String,
    /// The size of the file in bytes.
    pub bytes: u64,
}

/// A place in which plans and units are published. Names are flat: no folders within.
///
/// Only operations of object stores are needed: nothing is overwritten, appended to, locked or renamed.
pub trait Store: Sync {
    /// Publishes a file, whole or not at all, unless there is one of that name. Once it has returned the file survives
    /// a power cut. Of several writers at once one gets [`Created::New`].
    ///
    /// # Errors
    /// [`BakeError::Full`] for a full disk, [`BakeError::Write`] otherwise.
    fn create(&self, name: &str, bytes: &[u8]) -> Result<Created, BakeError>;

    /// The bytes of a file; returns `None` if there is no such file.
    ///
    /// # Errors
    /// [`BakeError::Read`].
    fn get(&self, name: &str) -> Result<Option<Vec<u8>>, BakeError>;

    /// All files that have been published, in any order.
    ///
    /// # Errors
    /// [`BakeError::Read`].
    fn list(&self) -> Result<Vec<Entry>, BakeError>;

    /// Removes a file; that it was gone already is no error.
    ///
    /// For damaged units alone: since nothing is overwritten, the bad one must go before a good one can be created in
    /// its place. Two writers that do so at once may remove each other's good unit, and publish it again: at worst a
    /// unit is missing, never wrong, and the next run makes it.
    ///
    /// # Errors
    /// [`BakeError::Write`].
    fn remove(&self, name: &str) -> Result<(), BakeError>;

    /// A file's path or address, for messages; the store's own for an empty name.
    fn place(&self, name: &str) -> String;

    /// Temporary files: of writers at work, or left over by ones that were killed. They are never taken for units and
    /// may be deleted when no writer is at work.
    ///
    /// # Errors
    /// [`BakeError::Read`].
    fn left_over(&self) -> Result<Vec<Entry>, BakeError> {
        Ok(Vec::new())
    }
}

/// Refuses names that some file system or object store would not take as they are, for what implements [`Store`]:
/// letters, digits, `-`, `_` and `.` are allowed, and no `.` at the beginning. `place` names the file in the message.
///
/// # Errors
/// [`BakeError::Invalid`].
pub fn check_name(name: &str, place: &str) -> Result<(), BakeError> {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    if name.is_empty() || name.starts_with('.') || !name.bytes().all(plain) {
        let problem = "may have letters, digits, `-`, `_` and `.`, and not begin with a `.`";
        return Err(BakeError::invalid(place, "name", problem));
    }
    Ok(())
}
