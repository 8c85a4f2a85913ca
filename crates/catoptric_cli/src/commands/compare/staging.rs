//! The folder of a report: its files appear when all are there.

use crate::failure::Failure;
use crate::report;
use catoptric::output::{self, NewFolders, TemporaryFolder};
use std::path::{Path, PathBuf};

/// A hidden folder beside the report's files, in which they are made before any of them appears.
pub(super) struct Staging {
    // In this order: the report's folder goes if it is empty then.
    hidden: TemporaryFolder,
    _new: NewFolders,
    folder: PathBuf,
    /// Files of the report that is replaced.
    earlier: Vec<String>,
}

impl Staging {
    /// For files of these names. Only files of an earlier report are ever replaced or removed.
    pub(super) fn new(folder: &Path, names: &[String]) -> Result<Self, Failure> {
        let fail = |error: std::io::Error| {
            Failure::input(format!("--report {}: cannot write into the folder: {error}", folder.display()))
        };
        let mut new = NewFolders::default();
        new.create(folder).map_err(fail)?;
        let earlier = match report::files_of(folder) {
            Some(earlier) => earlier,
            None => {
                let is_foreign = |name: std::ffi::OsString| !output::is_temporary(&name.to_string_lossy());
                let mut names =
                    std::fs::read_dir(folder).map_err(fail)?.filter_map(|entry| Some(entry.ok()?.file_name()));
                if let Some(name) = names.find(|name| is_foreign(name.clone())) {
                    let name = name.display();
                    return Err(Failure::usage(format!(
                        "--report {}: the folder has other files, such as `{name}`; name a new or empty one",
                        folder.display()
                    )));
                }
                Vec::new()
            }
        };
        let is_foreign = |name: &&String| !earlier.contains(name) && folder.join(name).symlink_metadata().is_ok();
        if let Some(name) = names.iter().find(is_foreign) {
            return Err(Failure::usage(format!(
                "--report {}: the folder's `{name}` is of no report and would be replaced; name another folder",
                folder.display()
            )));
        }
        let hidden = TemporaryFolder::within(folder).map_err(fail)?;
        Ok(Self { hidden, _new: new, folder: folder.into(), earlier })
    }

    pub(super) fn path(&self) -> &Path {
        self.hidden.path()
    }

    /// Moves all files to where they belong, the page last.
    pub(super) fn publish(self) -> Result<(), Failure> {
        let fail = |error: std::io::Error| {
            Failure::input(format!("--report {}: cannot move files into it: {error}", self.folder.display()))
        };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(self.path()).map_err(fail)? {
            names.push(entry.map_err(fail)?.file_name());
        }
        names.sort_by_key(|name| name == report::PAGE);
        for name in self.earlier.iter().filter(|name| !names.iter().any(|new| new == name.as_str())) {
            // A file that is missing already is as good as removed.
            let _ = std::fs::remove_file(self.folder.join(name));
        }
        for name in names {
            output::move_file(&self.path().join(&name), &self.folder.join(&name)).map_err(fail)?;
        }
        Ok(())
    }
}
