//! Outputs as files, in one place for all writers.
//!
//! Files appear by rename: a reader gets the old file or the whole new one, never a part of it. Symbolic links stay,
//! and the file behind them is replaced; devices and pipes are written through. Temporary files and folders are
//! registered, so that a program that is told to stop can remove them: [`exit`].

use crate::error::SceneError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Seek, Write};
use std::ops::{Deref, DerefMut};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

const PREFIX: &str = ".catoptric-";
const SUFFIX: &str = ".tmp";
/// More symbolic links in a row are a circle.
const MAX_LINKS: usize = 40;
/// Folders into which another thread moves a file meanwhile are removed in a further attempt.
const ATTEMPTS: usize = 8;

/// True if a name is that of a [`Temporary`].
pub fn is_temporary(name: &str) -> bool {
    name.starts_with(PREFIX) && name.ends_with(SUFFIX)
}

/// Writes a file through `fill`; it appears under its name when it is complete, and not at all when something fails.
///
/// # Errors
/// [`SceneError::Write`] when the folder is missing or not writable, the name is a folder's, or `fill` fails.
pub fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), SceneError> {
    replace(path, fill).map_err(|source| SceneError::Write { path: path.into(), source })
}

/// Writes through `fill` into a stream, such as standard output, when it is complete, and nothing when `fill` fails.
///
/// # Errors
/// Errors of the system and of `fill`.
pub fn write_stream(
    stream: &mut impl Write,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = tempfile::tempfile()?;
    filled(&mut file, fill)?;
    copy(&mut file, stream)
}

fn replace(path: &Path, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    match Destination::of(path)? {
        Destination::Device => {
            let mut file = tempfile::tempfile()?;
            filled(&mut file, fill)?;
            copy_to_device(&mut file, path)
        }
        Destination::File(target) => {
            let mut file = Temporary::beside(&target)?;
            filled(file.as_file_mut(), fill)?;
            file.rename(&target)
        }
    }
}

fn filled(file: &mut File, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::new(file);
    fill(&mut writer).and_then(|()| writer.flush())
}

/// Finds out whether a file of this name could be written now; leaves nothing behind. For use before long work.
///
/// # Errors
/// [`SceneError::Write`] as for [`write_file`].
pub fn check_writable(path: &Path) -> Result<(), SceneError> {
    let check = || match Destination::of(path)? {
        Destination::Device => Ok(()),
        Destination::File(target) => Temporary::beside(&target).map(drop),
    };
    check().map_err(|source| SceneError::Write { path: path.into(), source })
}

/// Moves a file to another path, also to another file system; there it replaces files and is copied into devices.
///
/// # Errors
/// The errors of the file system, and one for a folder of that name.
pub fn move_file(from: &Path, to: &Path) -> io::Result<()> {
    let copied = |writer: &mut BufWriter<&mut File>| io::copy(&mut File::open(from)?, writer).map(drop);
    match Destination::of(to)? {
        Destination::Device => replace(to, copied)?,
        Destination::File(target) => match fs::rename(from, &target) {
            Err(error) if error.kind() == ErrorKind::CrossesDevices => replace(to, copied)?,
            result => return result,
        },
    }
    fs::remove_file(from)
}

/// True if two paths lead to one file, by whatever links and spellings. Devices can be written to several times.
pub fn is_same_file(one: &Path, other: &Path) -> bool {
    let place = |path: &Path| match Destination::of(path) {
        Ok(Destination::File(target)) => Some(whole(&target)),
        _ => None,
    };
    place(one).is_some_and(|place_of_one| Some(place_of_one) == place(other))
}

/// The place that a path leads to.
enum Destination {
    /// A file behind all symbolic links, there already or not: it is replaced.
    File(PathBuf),
    /// A device, pipe or socket: it is written through.
    Device,
}

impl Destination {
    fn of(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => Err(io::Error::new(ErrorKind::IsADirectory, "it is a folder")),
            Ok(metadata) if !metadata.is_file() => Ok(Self::Device),
            // Missing files and what has no metadata are found out when they are written.
            _ => behind_links(path).map(Self::File),
        }
    }
}

fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&path) {
            Ok(target) => path = folder_of(&path).join(target),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("it is a symbolic link to itself"))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The path from the root without links, `.` and `..`; its last parts need not exist.
fn whole(path: &Path) -> PathBuf {
    let mut whole = PathBuf::new();
    for component in std::path::absolute(path).unwrap_or_else(|_| path.into()).components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => drop(whole.pop()),
            part => {
                whole.push(part);
                whole = whole.canonicalize().unwrap_or(whole);
            }
        }
    }
    whole
}

fn copy_to_device(file: &mut File, path: &Path) -> io::Result<()> {
    copy(file, &mut OpenOptions::new().write(true).open(path)?)
}

fn copy(file: &mut File, stream: &mut impl Write) -> io::Result<()> {
    file.rewind()?;
    io::copy(file, stream)?;
    stream.flush()
}

/// A temporary file, removed when it is dropped or when the program ends by [`exit`].
#[derive(Debug)]
pub struct Temporary {
    // In this order: the file goes before its entry.
    file: NamedTempFile,
    entry: Entry,
}

impl Temporary {
    /// A file in the folder of a path.
    ///
    /// # Errors
    /// The errors of the file system, and one for a missing folder.
    pub fn beside(path: &Path) -> io::Result<Self> {
        let folder = folder_of(path);
        if !folder.is_dir() {
            let problem = format!("the folder {} does not exist; create it first", folder.display());
            return Err(io::Error::new(ErrorKind::NotFound, problem));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        // Temporary files are private; results are as readable as any new file of the user.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut registry = registry();
        let file = builder.tempfile_in(folder)?;
        let entry = registry.enter(Leftover::File(file.path().into()));
        Ok(Self { file, entry })
    }

    /// Puts it in the place of a path: of the file there, behind symbolic links, or into the device there.
    ///
    /// # Errors
    /// The errors of the file system, and one for a folder of that name.
    pub fn publish(mut self, path: &Path) -> io::Result<()> {
        match Destination::of(path)? {
            Destination::Device => copy_to_device(self.file.as_file_mut(), path),
            Destination::File(target) => self.rename(&target),
        }
    }

    /// Gives it a name that is free.
    ///
    /// # Errors
    /// [`ErrorKind::AlreadyExists`] for names that are taken; those of the system.
    pub fn publish_new(self, path: &Path) -> io::Result<()> {
        self.file.persist_noclobber(path).map(drop).map_err(|error| error.error)
    }

    fn rename(self, target: &Path) -> io::Result<()> {
        let Self { file, entry } = self;
        let result = match file.persist(target) {
            Err(failed) if failed.error.kind() == ErrorKind::CrossesDevices => {
                let mut near = Self::beside(target)?;
                let mut file = failed.file;
                file.rewind()?;
                io::copy(&mut file, &mut near.file)?;
                near.as_file().sync_all()?;
                near.file.persist(target)
            }
            result => result,
        };
        drop(entry);
        result.map(drop).map_err(|error| error.error)
    }
}

impl Deref for Temporary {
    type Target = NamedTempFile;

    fn deref(&self) -> &NamedTempFile {
        &self.file
    }
}

impl DerefMut for Temporary {
    fn deref_mut(&mut self) -> &mut NamedTempFile {
        &mut self.file
    }
}

/// A hidden folder, removed with all that is in it when it is dropped or when the program ends by [`exit`].
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: tempfile::TempDir,
    _entry: Entry,
}

impl TemporaryFolder {
    /// A folder in another one.
    ///
    /// # Errors
    /// The errors of the file system.
    pub fn within(folder: &Path) -> io::Result<Self> {
        let mut registry = registry();
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(folder)?;
        let _entry = registry.enter(Leftover::Folder(folder.path().into()));
        Ok(Self { folder, _entry })
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Folders that were made for outputs. Those that are empty when this is dropped, or when the program ends by [`exit`],
/// are removed.
#[derive(Debug, Default)]
pub struct NewFolders {
    /// From the outermost.
    folders: Vec<(PathBuf, Entry)>,
}

impl NewFolders {
    /// Makes a folder, and those around it, where they are missing.
    ///
    /// # Errors
    /// The errors of the file system.
    pub fn create(&mut self, folder: &Path) -> io::Result<()> {
        let missing: Vec<&Path> =
            folder.ancestors().take_while(|it| !it.as_os_str().is_empty() && !it.exists()).collect();
        let mut registry = registry();
        for folder in missing.into_iter().rev() {
            let entry = registry.enter(Leftover::EmptyFolder(folder.into()));
            self.folders.push((folder.into(), entry));
        }
        fs::create_dir_all(folder)
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        while let Some((folder, _)) = self.folders.pop() {
            // Folders with something in them stay.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// A part of the file system that must not stay.
#[derive(Debug)]
enum Leftover {
    File(PathBuf),
    Folder(PathBuf),
    EmptyFolder(PathBuf),
}

impl Leftover {
    fn remove(&self) {
        let _ = match self {
            Self::File(path) => fs::remove_file(path),
            Self::Folder(path) => {
                (0..ATTEMPTS).find_map(|_| fs::remove_dir_all(path).ok()).ok_or_else(|| io::Error::other("in use"))
            }
            Self::EmptyFolder(path) => fs::remove_dir(path),
        };
    }
}

struct Registry {
    next: u64,
    leftovers: Vec<(u64, Leftover)>,
}

static REGISTRY: Mutex<Registry> = Mutex::new(Registry { next: 0, leftovers: Vec::new() });

fn registry() -> MutexGuard<'static, Registry> {
    REGISTRY.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Registry {
    fn enter(&mut self, leftover: Leftover) -> Entry {
        self.next += 1;
        self.leftovers.push((self.next, leftover));
        Entry { number: self.next }
    }
}

/// An entry of the registry: the leftover is registered while this lives.
#[derive(Debug)]
struct Entry {
    number: u64,
}

impl Drop for Entry {
    fn drop(&mut self) {
        registry().leftovers.retain(|(number, _)| *number != self.number);
    }
}

/// Removes what is temporary, and ends the program. Other threads make nothing temporary meanwhile.
pub fn exit(code: i32) -> ! {
    // Held until the end.
    let registry = registry();
    // Later leftovers may lie in earlier ones, so they go first.
    registry.leftovers.iter().rev().for_each(|(_, leftover)| leftover.remove());
    std::process::exit(code)
}

/// A word of a command line as shells take it: quoted where it has to be.
pub fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}
