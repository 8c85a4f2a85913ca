//! The errors of bakes; a bug panics instead. Messages name the file, the field and the remedy.

use crate::unit::UnitFault;
use std::io;
use std::path::Path;

/// A plan, unit, store or baked file that cannot be used, or work that failed.
///
/// Files are named as their store names them: by path, or by address.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// The file could not be read.
    #[error("{file}: cannot read it: {source}")]
    Read {
        /// The file.
        file: String,
        /// The message of the operating system or of the store's server.
        source: io::Error,
    },
    /// The file could not be written.
    #[error("{file}: cannot write it: {source}")]
    Write {
        /// The file.
        file: String,
        /// The message of the operating system or of the store's server.
        source: io::Error,
    },
    /// The disk is full, or the user's share of it.
    #[error(
        "{file}: cannot write it: {source}; free some space or raise the quota, then run again: \
         what is published already is kept"
    )]
    Full {
        /// The file.
        file: String,
        /// The message of the operating system.
        source: io::Error,
    },
    /// There is no such file.
    #[error("{file}: there is no such file; {remedy}")]
    Absent {
        /// The file.
        file: String,
        /// The way to make it.
        remedy: &'static str,
    },
    /// A folder, pipe or device stands where a file is wanted.
    #[error("{file}: is {kind}, not a baked file; {remedy}")]
    NoFile {
        /// The path of the folder, pipe or device.
        file: String,
        /// The kind of thing that it is, such as `a folder`.
        kind: &'static str,
        /// The remedy for the user.
        remedy: &'static str,
    },
    /// The file is of another kind.
    #[error("{file}: is no baked file but {kind}; {remedy}")]
    Foreign {
        /// The file.
        file: String,
        /// The format that it seems to have.
        kind: &'static str,
        /// The remedy for the user.
        remedy: &'static str,
    },
    /// The file was made by a program with another format of such files.
    #[error(
        "{file}: {field} is {found}, this program reads {known}; read it with the program that made it, or bake again"
    )]
    Version {
        /// The file.
        file: String,
        /// The kind of version, such as `format version`.
        field: &'static str,
        /// The version found.
        found: u32,
        /// The version that this program reads.
        known: u32,
    },
    /// The file is shorter or longer than its head declares.
    #[error("{file}: has {found} bytes where {expected} belong: {problem}; copy or merge it again")]
    Length {
        /// The file.
        file: String,
        /// The right number of bytes.
        expected: u64,
        /// The number found.
        found: u64,
        /// `missing` or `too much`.
        problem: &'static str,
    },
    /// A hash does not fit: bits have changed since the file was written.
    #[error("{file}: {part} is damaged: {problem}; copy or merge it again")]
    Damaged {
        /// The file.
        file: String,
        /// The part of it, such as `unit 3 (row 3)`.
        part: String,
        /// The check that failed.
        problem: &'static str,
    },
    /// A field is missing, wrong or out of range.
    #[error("{file}: {field}: {problem}")]
    Invalid {
        /// The file, or the name of what was given.
        file: String,
        /// The field at fault, such as `identity.units[3].bytes`.
        field: String,
        /// The fault, and what is allowed.
        problem: String,
    },
    /// The store holds the bake of another plan.
    #[error("{file}: is the plan of another bake: {difference}; use another place, or ask for what was planned there")]
    OtherPlan {
        /// The plan in the store.
        file: String,
        /// The first difference.
        difference: String,
    },
    /// The file is the bake of another scene, method or settings.
    #[error("{file}: is the bake of something else: {difference}; bake again, or ask for what it is of")]
    OtherBake {
        /// The file.
        file: String,
        /// The first difference.
        difference: String,
    },
    /// A unit in the store is whole, but not the one that belongs there; it is not replaced.
    #[error("{file}: {fault}; it is whole, so it is left alone: move it away, then run again")]
    Misplaced {
        /// The unit's file.
        file: String,
        /// The reason why the file is not the unit that belongs there.
        fault: UnitFault,
    },
    /// The unit was published before and differs from what was computed now.
    #[error(
        "{file}: unit {number} ({name}) was published by another writer and differs from what was computed here; \
         the work is not deterministic, which is a bug to report: two machines, threads or versions gave other bits"
    )]
    Differs {
        /// The unit's file.
        file: String,
        /// The unit's number.
        number: u64,
        /// The unit's name in the plan.
        name: String,
    },
    /// Again and again the unit was gone or bad just after it was there.
    #[error("{file}: other writers remove it as often as it is published; is the store sound? then run again")]
    Contended {
        /// The unit's file.
        file: String,
    },
    /// The work made a unit of another size than planned.
    #[error(
        "unit {number} ({name}): the work gave {found} bytes where the plan says {planned}; plan again, or report a bug"
    )]
    Size {
        /// The unit's number.
        number: u64,
        /// The unit's name in the plan.
        name: String,
        /// The size in the plan.
        planned: u64,
        /// The size of what the work gave.
        found: u64,
    },
    /// The work failed.
    #[error("unit {number} ({name}): {problem}")]
    Work {
        /// The unit's number.
        number: u64,
        /// The unit's name in the plan.
        name: String,
        /// The message of the work.
        problem: String,
    },
    /// Units are missing or bad, so there is nothing to merge yet.
    #[error(
        "{place}: {missing} of {total} units are missing and {bad} are bad ({first}); run again to make them, then \
        merge"
    )]
    Incomplete {
        /// The store.
        place: String,
        /// The number of missing units.
        missing: u64,
        /// The number of bad units.
        bad: u64,
        /// The number of units of the plan.
        total: u64,
        /// The first few of them.
        first: String,
    },
    /// The text or the environment names no shard.
    #[error("{place}: {problem}")]
    Shard {
        /// The source of the value: the text, or the environment variable.
        place: String,
        /// The fault, and what is allowed.
        problem: String,
    },
}

impl BakeError {
    /// A wrong field.
    pub fn invalid(file: impl Into<String>, field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Invalid { file: file.into(), field: field.into(), problem: problem.into() }
    }

    /// A failed read.
    pub fn read(file: impl Into<String>, source: io::Error) -> Self {
        Self::Read { file: file.into(), source }
    }

    /// A failed write; a full disk or an exhausted quota is [`BakeError::Full`].
    pub fn write(file: impl Into<String>, source: io::Error) -> Self {
        let file = file.into();
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::Full { file, source },
            _ => Self::Write { file, source },
        }
    }

    pub(crate) fn write_path(path: &Path, source: io::Error) -> Self {
        Self::write(path.display().to_string(), source)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of Linux: ENOSPC, EDQUOT, EACCES.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_of_its_own() {
        for (number, full) in [(28, true), (122, true), (13, false)] {
            let error = BakeError::write("a/b.bin", io::Error::from_raw_os_error(number));
            assert_eq!(matches!(error, BakeError::Full { .. }), full, "{error}");
            assert!(error.to_string().contains("a/b.bin"));
            assert_eq!(error.to_string().contains("free some space"), full);
        }
    }
}
