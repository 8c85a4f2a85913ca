//! Merges the units of a bake into one file.

use crate::container::{ALIGNMENT, HASH_BYTES, Layout};
use crate::error::BakeError;
use crate::plan::Plan;
use crate::publish;
use crate::status::{Check, Listing, Status, status};
use crate::store::Store;
use crate::unit;
use catoptric::output::Temporary;
use serde::Serialize;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// The result of a merge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Merged {
    /// The number of units.
    pub units: u64,
    /// The bytes of the file.
    pub bytes: u64,
}

/// Merges all units of a plan into a baked file ([`BakedFile`](crate::BakedFile)), one at a time. The file appears by
/// rename, whole or not at all, and replaces one of that name.
///
/// The file's bits follow from the plan's identity and the units alone, in whatever order, shards and threads these
/// were made.
///
/// # Errors
/// [`BakeError::Incomplete`] when a unit is missing or bad; [`BakeError::Full`] and [`BakeError::Write`] for the
/// output; those of the store.
pub fn merge(plan: &Plan, store: &dyn Store, output: &Path) -> Result<Merged, BakeError> {
    merge_through(plan, store, output, output)
}

/// The same through a temporary file beside `beside`, which must be on the file system of the output: a program that is
/// killed while it merges leaves it there, and [`LocalStore::left_over`](Store::left_over) finds it if that is in the
/// store's folder.
///
/// # Errors
/// As for [`merge`].
pub fn merge_through(plan: &Plan, store: &dyn Store, beside: &Path, output: &Path) -> Result<Merged, BakeError> {
    let fail = |error: io::Error| BakeError::write_path(output, error);
    if output.is_dir() {
        return Err(fail(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder; name a file")));
    }
    let place = store.place("");
    plan.identity.validate(&place)?;
    refuse_incomplete(&status(plan, store, Check::Sizes)?, &place)?;
    let contended = |name: &str| BakeError::Contended { file: store.place(name) };
    // One may be gone again, to be replaced by a run that is still going on.
    let sizes = Listing::read(plan, store)?.payload_bytes().ok_or_else(|| contended(""))?;
    let layout = Layout::of(&plan.identity, &sizes)
        .ok_or_else(|| BakeError::invalid(&place, "identity.units", "no file can be as large as all of them"))?;

    let mut file = Temporary::beside(beside).map_err(fail)?;
    let mut writer = BufWriter::new(file.as_file_mut());
    // The head has the hashes of all units, so it is written last.
    writer.seek(SeekFrom::Start(layout.payloads)).map_err(fail)?;
    let hash = plan.hash();
    let mut hashes: Vec<[u8; HASH_BYTES]> = Vec::with_capacity(layout.units.len());
    for (number, unit) in layout.units.iter().enumerate() {
        let name = unit::file_name(number as u64, plan.identity.unit_count());
        let bytes = store.get(&name)?;
        let decoded = bytes.as_deref().map(|bytes| plan.identity.units[number].decode(bytes, hash, number as u64));
        let Some(Ok(payload)) = decoded.filter(|found| found.is_ok_and(|found| found.len() as u64 == sizes[number]))
        else {
            // All of them are read, so that all bad ones are reported at once.
            refuse_incomplete(&status(plan, store, Check::Contents)?, &place)?;
            // A run that is still going on has replaced the unit meanwhile.
            return Err(contended(&name));
        };
        hashes.push(blake3::hash(payload).into());
        writer.write_all(payload).and_then(|()| fill(&mut writer, unit.end)).map_err(fail)?;
    }
    let head = layout.head(&hashes);
    let footer = blake3::hash(&head);
    let finish =
        writer.write_all(footer.as_bytes()).and_then(|()| writer.rewind()).and_then(|()| writer.write_all(&head));
    finish.and_then(|()| writer.flush()).map_err(fail)?;
    drop(writer);
    publish::replace(file, output).map_err(fail)?;
    Ok(Merged { units: plan.identity.unit_count(), bytes: layout.file_bytes })
}

/// Takes the payloads of all units of a plan, one after the other, once all are there and whole.
///
/// # Errors
/// [`BakeError::Incomplete`] when a unit is missing or bad, those of the store, and those of `take`.
pub fn for_each_unit<E: From<BakeError>>(
    plan: &Plan,
    store: &dyn Store,
    mut take: impl FnMut(u64, &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let place = store.place("");
    plan.identity.validate(&place)?;
    refuse_incomplete(&status(plan, store, Check::Contents)?, &place)?;
    let hash = plan.hash();
    for number in 0..plan.identity.unit_count() {
        let name = unit::file_name(number, plan.identity.unit_count());
        let bytes = store.get(&name)?;
        let decoded = bytes.as_deref().map(|bytes| plan.identity.units[number as usize].decode(bytes, hash, number));
        let Some(Ok(payload)) = decoded else {
            // A run that is still going on has replaced the unit meanwhile.
            return Err(BakeError::Contended { file: store.place(&name) }.into());
        };
        take(number, payload)?;
    }
    Ok(())
}

/// Zeros from an offset to the next multiple of the alignment.
fn fill(writer: &mut impl Write, from: u64) -> io::Result<()> {
    let zeros = [0; ALIGNMENT as usize];
    writer.write_all(&zeros[..(from.next_multiple_of(ALIGNMENT) - from) as usize])
}

fn refuse_incomplete(status: &Status, place: &str) -> Result<(), BakeError> {
    if status.is_complete() {
        return Ok(());
    }
    let (missing, bad) = (status.missing, status.bad.len() as u64);
    Err(BakeError::Incomplete { place: place.into(), missing, bad, total: status.total, first: status.first_few() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::BakedFile;
    use crate::run::{RunOptions, run};
    use crate::testing::{MemoryStore, payload, plan, work};

    fn names(folder: &Path) -> Vec<String> {
        let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.collect()
    }

    #[test]
    fn the_merged_file_holds_all_units() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.bake");
        // Empty ones, ones as long as the alignment, and around it.
        let (plan, store) = (plan(&[0, 1, 63, 64, 65, 0, 200]), MemoryStore::default());
        run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
        std::fs::write(&output, b"an older one").unwrap();
        let merged = merge(&plan, &store, &output).unwrap();
        assert_eq!(merged, Merged { units: 7, bytes: std::fs::metadata(&output).unwrap().len() });
        let baked = BakedFile::open(&output).unwrap();
        assert_eq!((baked.identity(), baked.plan_hash()), (&plan.identity, plan.hash()));
        assert_eq!((baked.unit_count(), baked.file_bytes()), (7, merged.bytes));
        for number in 0..7 {
            assert_eq!(baked.unit(number), payload(&plan, number));
            assert_eq!(baked.unit(number).as_ptr() as u64 % ALIGNMENT, 0);
        }
        assert_eq!(names(folder.path()), ["a.bake"]);
    }

    #[test]
    fn missing_and_bad_units_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.bake");
        let (plan, store) = (plan(&[8; 12]), MemoryStore::default());
        run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
        // Both have the right size, so they are found while the file is being written.
        for name in ["unit-000004.bin", "unit-000009.bin"] {
            store.files.lock().unwrap().get_mut(name).unwrap()[66] ^= 1;
        }
        let message = merge(&plan, &store, &output).unwrap_err().to_string();
        assert!(message.contains("0 of 12 units are missing and 2 are bad"), "{message}");
        assert!(message.contains("unit-000004.bin is damaged") && message.contains("unit-000009.bin"), "{message}");
        for number in 0..8 {
            store.remove(&unit::file_name(number, 12)).unwrap();
        }
        let message = merge(&plan, &store, &output).unwrap_err().to_string();
        assert!(message.contains("8 of 12 units are missing") && message.contains("and 3 more"), "{message}");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn outputs_that_cannot_be_written_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, store) = (plan(&[8]), MemoryStore::default());
        run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
        let message = merge(&plan, &store, folder.path()).unwrap_err().to_string();
        assert!(message.contains("it is a folder"), "{message}");
        let message = merge(&plan, &store, &folder.path().join("no/a.bake")).unwrap_err().to_string();
        assert!(message.contains("a.bake") && message.contains("does not exist"), "{message}");
    }
}
