//! The baked file: all units of a bake in one, mapped into memory, refused unless every bit is as it was written.

mod layout;
#[cfg(test)]
mod tests;

pub use layout::{ALIGNMENT, FORMAT_VERSION};
pub(crate) use layout::{HASH_BYTES, Layout};

use crate::error::BakeError;
use crate::plan::Identity;
use crate::plan_hash::PlanHash;
use memmap2::{Mmap, MmapMut};
use rayon::prelude::*;
use std::fmt;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;

/// A bake, ready to be looked up. Threads may share it.
///
/// The file must not change while it is open: its bytes are those of the disk, not a copy. Merging replaces a file by
/// rename, so an open one stays as it was, and nothing of ours writes into one. If somebody truncates it in place,
/// reading what is gone kills the process (SIGBUS on Unix; Windows does not let them); if somebody writes into it,
/// later look-ups return that unchecked. If that cannot be ruled out, copy the file first.
pub struct BakedFile {
    map: Mmap,
    identity: Identity,
    units: Vec<Range<usize>>,
}

impl fmt::Debug for BakedFile {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fields = formatter.debug_struct("BakedFile");
        fields.field("method", &self.identity.method).field("units", &self.units.len()).finish_non_exhaustive()
    }
}

impl BakedFile {
    /// Maps a baked file and checks it whole, on all cores: that reads it once, at the speed of the disk.
    ///
    /// # Errors
    /// [`BakeError::Absent`], [`BakeError::NoFile`] (a folder, say), [`BakeError::Read`], [`BakeError::Foreign`]
    /// (another kind of file, or an empty one), [`BakeError::Version`], [`BakeError::Length`] (truncated or longer),
    /// [`BakeError::Damaged`], and [`BakeError::Invalid`] for one that no program of ours has written.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, BakeError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let fail = |source: std::io::Error| match source.kind() {
            ErrorKind::NotFound => BakeError::Absent { file: file.clone(), remedy: "bake first, or correct the path" },
            _ => BakeError::read(file.clone(), source),
        };
        // Looked at before it is opened: opening a pipe would wait for its writer.
        let metadata = fs::metadata(path).map_err(fail)?;
        if !metadata.is_file() {
            let (kind, remedy) = if metadata.is_dir() {
                ("a folder", "merge the bake in it into a file first, or name a file in it")
            } else {
                ("a pipe or device", "copy it into a file first")
            };
            return Err(BakeError::NoFile { file, kind, remedy });
        }
        let opened = File::open(path).map_err(fail)?;
        // SAFETY: the map is only read, as plain bytes, for which any values are allowed. That nobody changes the file
        // meanwhile is a guarantee that no operating system gives; this type's documentation requires it and names what
        // happens.
        #[allow(unsafe_code, reason = "files cannot be mapped otherwise, and copies would not fit into memory")]
        let map = unsafe { Mmap::map(&opened) }.map_err(fail)?;
        let (identity, units) = check(&file, &map)?;
        Ok(Self { map, identity, units })
    }

    /// The same from memory, which is copied; `file` names it in messages.
    ///
    /// # Errors
    /// As for [`Self::open`].
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Self, BakeError> {
        let (identity, units) = check(file, bytes)?;
        // A map has the alignment that a vector has not.
        let copy = MmapMut::map_anon(bytes.len()).and_then(|mut copy| {
            copy.copy_from_slice(bytes);
            copy.make_read_only()
        });
        let map = copy.map_err(|error| BakeError::read(file, error))?;
        Ok(Self { map, identity, units })
    }

    /// The identity of the bake.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// The bake's name: the hash of the plan that it was made by.
    pub fn plan_hash(&self) -> PlanHash {
        self.identity.hash()
    }

    /// The number of units.
    pub fn unit_count(&self) -> u64 {
        self.units.len() as u64
    }

    /// The payload of a unit, at a multiple of [`ALIGNMENT`] in memory.
    ///
    /// # Panics
    /// Unless `number` is below [`Self::unit_count`].
    pub fn unit(&self, number: u64) -> &[u8] {
        &self.map[self.units[number as usize].clone()]
    }

    /// The bytes of the whole file.
    pub fn file_bytes(&self) -> u64 {
        self.map.len() as u64
    }
}

/// Reads and checks all of a file; gives its identity and where its payloads are.
fn check(file: &str, bytes: &[u8]) -> Result<(Identity, Vec<Range<usize>>), BakeError> {
    let head = layout::read_head(file, bytes)?;
    let ends = head.units.iter().skip(1).map(|unit| unit.0.start).chain([head.footer]);
    let gaps: Vec<Range<usize>> = head.units.iter().zip(ends).map(|(unit, end)| unit.0.end..end).collect();
    // The first, so that the message is the same at any thread count.
    let problem = (0..head.units.len()).into_par_iter().find_map_first(|number| {
        let (place, hash) = &head.units[number];
        if blake3::hash(&bytes[place.clone()]) != *hash {
            return Some((number, "its hash does not fit"));
        }
        let is_zero = bytes[gaps[number].clone()].iter().all(|&byte| byte == 0);
        (!is_zero).then_some((number, "what follows it is not zero"))
    });
    if let Some((number, problem)) = problem {
        let part = format!("unit {number} ({})", head.identity.units[number].name);
        return Err(BakeError::Damaged { file: file.into(), part, problem });
    }
    Ok((head.identity, head.units.into_iter().map(|unit| unit.0).collect()))
}
