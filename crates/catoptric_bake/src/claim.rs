//! A folder that several programs bake into at once, and that the last one removes.

use crate::error::BakeError;
use crate::plan::{PLAN_NAME, Plan};
use crate::store::{LocalStore, Store};
use crate::unit;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The file that is locked. It holds nothing.
const LOCK_NAME: &str = "lock";

/// A hold on a folder for one bake: while there is one, no other program removes what is in it.
///
/// The hold is a lock of the operating system, so programs that are killed hold nothing. On file systems that have no
/// locks nothing is removed.
#[derive(Debug)]
pub struct Claim {
    store: LocalStore,
    lock: Option<File>,
}

impl Claim {
    /// Takes hold of a folder, which is created where it is missing; waits for a program that is removing it.
    ///
    /// # Errors
    /// [`BakeError::Write`] when it cannot be created.
    pub fn new(folder: impl Into<PathBuf>) -> Result<Self, BakeError> {
        let folder = folder.into();
        loop {
            let store = LocalStore::create_folder(&folder)?;
            match Self::locked(&folder.join(LOCK_NAME)) {
                Ok(Some(lock)) => return Ok(Self { store, lock: Some(lock) }),
                // The folder was removed since it was created or locked.
                Ok(None) => {}
                Err(error) if error.kind() == ErrorKind::Unsupported => return Ok(Self { store, lock: None }),
                Err(error) => return Err(BakeError::write_path(&folder.join(LOCK_NAME), error)),
            }
        }
    }

    /// The file with a shared lock; `None` if it has been removed.
    fn locked(path: &Path) -> io::Result<Option<File>> {
        let file = match OpenOptions::new().create(true).truncate(false).write(true).open(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            file => file?,
        };
        file.lock_shared()?;
        // A program that had it to itself may have removed it: the lock is on a file without a name then.
        Ok(is_at(&file, path)?.then_some(file))
    }

    /// The folder's store.
    pub fn store(&self) -> &LocalStore {
        &self.store
    }

    /// Removes what a finished bake is no longer needed for, unless other programs are at work on it; returns true if
    /// it did. What is not the bake's, and what cannot be removed, stays.
    pub fn remove(self, plan: &Plan) -> bool {
        let Self { store, lock: Some(lock) } = self else { return false };
        // Two that get here at once cannot both fail: one of them is the last to let go.
        if lock.unlock().is_err() {
            return false;
        }
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock | TryLockError::Error(_)) => return false,
        }
        // Another one may have removed it in between, and a third one begun anew.
        if !is_at(&lock, &store.folder().join(LOCK_NAME)).unwrap_or(false) {
            return false;
        }
        let count = plan.identity.unit_count();
        let units = (0..count).map(|number| unit::file_name(number, count));
        let left_over = store.left_over().unwrap_or_default().into_iter().map(|entry| entry.name);
        // The lock's file is the last: until then others wait for it.
        for name in units.chain(left_over).chain([PLAN_NAME, LOCK_NAME].map(str::to_owned)) {
            let _ = fs::remove_file(store.folder().join(name));
        }
        let _ = fs::remove_dir(store.folder());
        true
    }
}

/// True if an open file is the one at a path.
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    let (open, named) = match fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        named => (file.metadata()?, named?),
    };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Ok((open.dev(), open.ino()) == (named.dev(), named.ino()))
    }
    // Elsewhere open files cannot be removed.
    #[cfg(not(unix))]
    Ok(open.len() == named.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{RunOptions, run};
    use crate::testing::{plan, work};

    #[test]
    fn the_last_one_removes_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let parts = folder.path().join("parts");
        let plan = plan(&[8; 3]);
        let (first, second) = (Claim::new(&parts).unwrap(), Claim::new(&parts).unwrap());
        plan.publish(first.store()).unwrap();
        run(&plan, first.store(), &work(&plan), &RunOptions::default()).unwrap();
        assert!(!first.remove(&plan), "the second one is at work");
        assert_eq!(run(&plan, second.store(), &work(&plan), &RunOptions::default()).unwrap().skipped, 3);
        assert!(second.remove(&plan) && !parts.exists());
        // Files that are not the bake's stay.
        let claim = Claim::new(&parts).unwrap();
        fs::write(parts.join("notes.txt"), b"mine").unwrap();
        assert!(claim.remove(&plan));
        assert_eq!(fs::read_dir(&parts).unwrap().count(), 1);
        fs::write(folder.path().join("file"), b"").unwrap();
        assert!(matches!(Claim::new(folder.path().join("file")), Err(BakeError::Write { .. })));
    }

    #[test]
    fn many_that_come_and_go_never_lose_what_one_of_them_needs() {
        let folder = tempfile::tempdir().unwrap();
        let parts = folder.path().join("parts");
        let plan = plan(&[64; 4]);
        let removed: usize = std::thread::scope(|scope| {
            let bake = || {
                let round = || {
                    let claim = Claim::new(&parts).unwrap();
                    plan.publish(claim.store()).unwrap();
                    run(&plan, claim.store(), &work(&plan), &RunOptions::default()).unwrap();
                    assert!(crate::status(&plan, claim.store(), crate::Check::Contents).unwrap().is_complete());
                    claim.remove(&plan)
                };
                (0..40).filter(|_| round()).count()
            };
            let bakers: Vec<_> = (0..4).map(|_| scope.spawn(bake)).collect();
            bakers.into_iter().map(|baker| baker.join().unwrap()).sum()
        });
        assert!(removed > 0 && !parts.exists(), "{removed}");
    }
}
