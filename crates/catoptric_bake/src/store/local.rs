//! A folder as a store.

use super::{Created, Entry, Store, check_name};
use crate::error::BakeError;
use crate::publish;
use catoptric::input::read_file;
use catoptric::output;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// The largest file that is read whole: plans and units are far smaller.
const MAX_BYTES: u64 = 8 << 30;

/// A folder of a local or network file system.
///
/// A file is written under a temporary name in the same folder, flushed to the disk, linked to its name, which fails
/// if there is one already, and the folder is flushed. No reader gets a part of it, also not after a power cut.
#[derive(Clone, Debug)]
pub struct LocalStore {
    folder: PathBuf,
}

impl LocalStore {
    /// The store of a folder, which is created where it is missing.
    ///
    /// # Errors
    /// [`BakeError::Write`] when it cannot be created, also when a file has its name.
    pub fn create_folder(folder: impl Into<PathBuf>) -> Result<Self, BakeError> {
        let folder = folder.into();
        fs::create_dir_all(&folder).map_err(|error| BakeError::write_path(&folder, error))?;
        Ok(Self { folder })
    }

    /// The store of a folder that exists.
    ///
    /// # Errors
    /// [`BakeError::Absent`] when it does not, [`BakeError::Read`] when it is no folder.
    pub fn open(folder: impl Into<PathBuf>) -> Result<Self, BakeError> {
        let folder = folder.into();
        let file = folder.display().to_string();
        match fs::metadata(&folder) {
            Ok(metadata) if metadata.is_dir() => Ok(Self { folder }),
            Ok(_) => {
                Err(BakeError::read(file, io::Error::new(ErrorKind::NotADirectory, "is a file, not a bake's folder")))
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                Err(BakeError::Absent { file, remedy: "a bake begins with a plan: make one there first" })
            }
            Err(error) => Err(BakeError::read(file, error)),
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn path(&self, name: &str) -> Result<PathBuf, BakeError> {
        check_name(name, &self.place(name))?;
        Ok(self.folder.join(name))
    }

    /// The folder's files whose names `choose` takes.
    fn entries(&self, choose: impl Fn(&str) -> bool) -> Result<Vec<Entry>, BakeError> {
        let fail = |error| BakeError::read(self.folder.display().to_string(), error);
        let mut entries = Vec::new();
        for entry in fs::read_dir(&self.folder).map_err(fail)? {
            let entry = entry.map_err(fail)?;
            let Some(name) = entry.file_name().to_str().filter(|name| choose(name)).map(String::from) else { continue };
            // Links are followed, so that a folder of links to units is as good as the units.
            match fs::metadata(entry.path()) {
                Ok(metadata) if metadata.is_file() => entries.push(Entry { name, bytes: metadata.len() }),
                Ok(_) => {}
                // Removed since the folder was read, as temporary files are.
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(fail(error)),
            }
        }
        Ok(entries)
    }
}

impl Store for LocalStore {
    fn create(&self, name: &str, bytes: &[u8]) -> Result<Created, BakeError> {
        let path = self.path(name)?;
        let created = publish::create_new(&path, bytes).map_err(|error| BakeError::write_path(&path, error))?;
        Ok(if created { Created::New } else { Created::Existed })
    }

    fn get(&self, name: &str) -> Result<Option<Vec<u8>>, BakeError> {
        let path = self.path(name)?;
        match read_file(&path, MAX_BYTES) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(BakeError::read(path.display().to_string(), error)),
        }
    }

    fn list(&self) -> Result<Vec<Entry>, BakeError> {
        self.entries(|name| !output::is_temporary(name))
    }

    fn remove(&self, name: &str) -> Result<(), BakeError> {
        let path = self.path(name)?;
        match fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(BakeError::write_path(&path, error)),
            _ => Ok(()),
        }
    }

    fn place(&self, name: &str) -> String {
        if name.is_empty() { self.folder.display().to_string() } else { self.folder.join(name).display().to_string() }
    }

    fn left_over(&self) -> Result<Vec<Entry>, BakeError> {
        self.entries(output::is_temporary)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_writer_wins() {
        let folder = tempfile::tempdir().unwrap();
        let store = LocalStore::create_folder(folder.path().join("a/b")).unwrap();
        assert_eq!(store.create("x.bin", b"one").unwrap(), Created::New);
        assert_eq!(store.create("x.bin", b"other").unwrap(), Created::Existed);
        assert_eq!(store.get("x.bin").unwrap().unwrap(), b"one");
        assert_eq!(store.list().unwrap(), [Entry { name: "x.bin".into(), bytes: 3 }]);
        assert!(store.left_over().unwrap().is_empty());
        store.remove("x.bin").unwrap();
        store.remove("x.bin").unwrap();
        assert_eq!(store.get("x.bin").unwrap(), None);
        assert_eq!(store.create("x.bin", b"third").unwrap(), Created::New);
    }

    #[test]
    fn of_many_writers_at_once_one_wins() {
        let folder = tempfile::tempdir().unwrap();
        let store = LocalStore::open(folder.path()).unwrap();
        let won: Vec<u8> = std::thread::scope(|scope| {
            let writers: Vec<_> = (0..8u8)
                .map(|writer| {
                    let store = &store;
                    scope.spawn(move || (writer, store.create("x.bin", &[writer; 5000]).unwrap()))
                })
                .collect();
            let results = writers.into_iter().map(|writer| writer.join().unwrap());
            results.filter(|result| result.1 == Created::New).map(|result| result.0).collect()
        });
        assert_eq!(won.len(), 1);
        assert_eq!(store.get("x.bin").unwrap().unwrap(), vec![won[0]; 5000]);
        assert!(store.left_over().unwrap().is_empty());
    }

    #[test]
    fn temporaries_of_killed_writers_are_no_units() {
        let folder = tempfile::tempdir().unwrap();
        let store = LocalStore::open(folder.path()).unwrap();
        fs::write(folder.path().join(".catoptric-123456.tmp"), b"half").unwrap();
        fs::create_dir(folder.path().join("folder")).unwrap();
        assert!(store.list().unwrap().is_empty());
        let left_over = store.left_over().unwrap();
        assert_eq!((left_over.len(), left_over[0].bytes), (1, 4));
    }

    #[test]
    fn folders_and_names_that_cannot_be_used_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"").unwrap();
        assert!(matches!(LocalStore::create_folder(&file), Err(BakeError::Write { .. })));
        assert!(LocalStore::open(&file).unwrap_err().to_string().contains("not a bake's folder"));
        let missing = LocalStore::open(folder.path().join("missing")).unwrap_err().to_string();
        assert!(missing.contains("missing: there is no such file"), "{missing}");
        let store = LocalStore::open(folder.path()).unwrap();
        for name in ["", ".hidden", "../up", "a/b", "a\\b", "ö"] {
            assert!(matches!(store.create(name, b""), Err(BakeError::Invalid { .. })), "{name}");
            assert!(store.get(name).is_err() && store.remove(name).is_err());
        }
        let gone = LocalStore { folder: folder.path().join("gone") };
        assert!(gone.list().unwrap_err().to_string().contains("gone"));
        assert!(gone.create("x", b"").unwrap_err().to_string().contains("gone"));
    }
}
