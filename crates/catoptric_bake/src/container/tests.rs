//! Every changed, missing or added bit of a baked file is refused, and nothing makes the parser panic.

use super::*;
use crate::merge::merge;
use crate::run::{RunOptions, run};
use crate::store::LocalStore;
use crate::testing::{MemoryStore, payload, plan, work};
use crate::unit::u64_at;
use proptest::prelude::*;
use std::sync::{Arc, LazyLock};

/// A small file: an empty unit, gaps of 61 bytes and none.
static GOOD: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let (plan, store) = (plan(&[3, 0, 64]), MemoryStore::default());
    run(&plan, &store, &work(&plan), &RunOptions::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    merge(&plan, &store, &folder.path().join("a")).unwrap();
    std::fs::read(folder.path().join("a")).unwrap()
});

/// The header's sizes made to fit the file, and the head's hash the head: what a hostile writer would do.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = bytes.len() as u64;
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    resealed(bytes)
}

/// The head's hash made to fit the head, where there is one.
fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let table = u64_at(&bytes, 24).checked_add(40).and_then(|end| end.checked_next_multiple_of(64));
    let rows = u64_at(&bytes, 32).checked_mul(48);
    let end = table.zip(rows).and_then(|(table, rows)| table.checked_add(rows)?.checked_next_multiple_of(64));
    let footer = bytes.len() - 32;
    if let Some(end) = end.filter(|&end| end <= footer as u64) {
        let hash = blake3::hash(&bytes[..end as usize]);
        bytes[footer..].copy_from_slice(hash.as_bytes());
    }
    bytes
}

fn refused(bytes: &[u8]) -> BakeError {
    BakedFile::from_bytes("a.bake", bytes).unwrap_err()
}

#[test]
fn comes_back_as_it_was() {
    let baked = Arc::new(BakedFile::from_bytes("a.bake", &GOOD).unwrap());
    let planned = plan(&[3, 0, 64]);
    assert_eq!((baked.identity(), baked.plan_hash()), (&planned.identity, planned.hash()));
    std::thread::scope(|scope| {
        for number in 0..3 {
            let (baked, planned) = (Arc::clone(&baked), &planned);
            scope.spawn(move || assert_eq!(baked.unit(number), payload(planned, number)));
        }
    });
    assert!((0..3).all(|number| (baked.unit(number).as_ptr() as u64).is_multiple_of(ALIGNMENT)));
    assert_eq!(resealed(GOOD.clone()), *GOOD);
    assert!(format!("{baked:?}").contains("units: 3"));
}

#[test]
fn every_truncation_is_refused() {
    for length in 0..GOOD.len() {
        let error = refused(&GOOD[..length]);
        let expected = if length < 8 { "a.bake: is no baked file but" } else { "a.bake: has" };
        assert!(error.to_string().starts_with(expected), "{length}: {error}");
    }
}

#[test]
fn every_flipped_bit_is_refused() {
    let mut bytes = GOOD.clone();
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(BakedFile::from_bytes("a.bake", &bytes).is_err(), "bit {bit}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
    assert!(BakedFile::from_bytes("a.bake", &bytes).is_ok());
}

#[test]
fn what_follows_the_end_is_refused() {
    for more in [1, 32, 64] {
        let longer = [&GOOD[..], &vec![0; more]].concat();
        assert!(matches!(refused(&longer), BakeError::Length { .. }));
        assert!(matches!(refused(&sealed(longer)), BakeError::Invalid { .. }));
    }
}

#[test]
fn damage_is_named() {
    let payloads = GOOD.len() - 32 - 128;
    let message = |at: usize| {
        let mut bytes = GOOD.clone();
        bytes[at] ^= 1;
        refused(&bytes).to_string()
    };
    let hash = "its hash does not fit; copy or merge it again";
    assert_eq!(message(60), format!("a.bake: the header is damaged: {hash}"));
    assert_eq!(message(payloads), format!("a.bake: unit 0 (row 0) is damaged: {hash}"));
    assert_eq!(message(payloads + 64), format!("a.bake: unit 2 (row 2) is damaged: {hash}"));
    assert!(message(payloads + 3).contains("unit 0 (row 0) is damaged: what follows it is not zero"));
}

#[test]
fn identities_that_lie_are_refused() {
    let with = |from: &str, to: &str| {
        let at = GOOD.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
        let mut bytes = GOOD.clone();
        bytes[at..at + to.len()].copy_from_slice(to.as_bytes());
        refused(&sealed(bytes)).to_string()
    };
    assert!(with("\"schema\":1", "\"schema\":7").contains("schema is 7, this program reads 1"));
    assert!(with("\"bytes\":64", "\"bytes\":65").contains("sizes do not fit the file"));
    assert!(with("\"bytes\":64", "\"bytes\":63").contains("sizes do not fit the file"));
    assert!(with("\"bytes\":64", "\"bytes\": 0").contains("sizes do not fit the file"));
    assert!(with("\"st\":16", "\"st\": 6").contains("canonical"));
    // The canonical form of this number is longer than the number as written.
    assert!(with("\"st\":16", "\"st\":1E").contains("identity"));
    assert!(with("\"st\":16}", "\"s\":1E9}").contains("canonical"));
    assert!(with("\"schema\"", "\"scheme\"").contains("missing field `schema`"));
    assert!(with("\"00ff", "\"00FF").contains("hexadecimal"));
}

#[test]
fn other_files_are_distinguished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bake");
    let message = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let message = BakedFile::open(&path).unwrap_err().to_string();
        assert!(message.contains("a.bake"), "{message}");
        message
    };
    assert!(message(b"").contains("no baked file but empty"));
    assert!(message(b"\x89PNG\r\n\x1a\nand so on").contains("a picture"));
    assert!(message(&crate::unit::encode(plan(&[3]).hash(), 0, b"abc")).contains("one unit of a bake; merge"));
    assert!(message(&plan(&[3]).to_json().unwrap()).contains("perhaps a plan; run and merge"));
    assert!(message(b"something").contains("bake first"));
    assert!(message(&GOOD[..30]).contains("has 30 bytes"));
    let mut other = GOOD.clone();
    other[8] = 2;
    assert!(message(&other).contains("format version is 2, this program reads 1"));
    let folder_message = BakedFile::open(folder.path()).unwrap_err().to_string();
    assert!(folder_message.contains("is a folder"), "{folder_message}");
    let missing = BakedFile::open(folder.path().join("b.bake")).unwrap_err();
    assert!(matches!(missing, BakeError::Absent { .. }), "{missing}");
    let below_file = BakedFile::open(path.join("c")).unwrap_err();
    assert!(matches!(below_file, BakeError::Read { .. }), "{below_file}");
    let store = LocalStore::open(folder.path()).unwrap();
    assert_eq!(crate::Store::list(&store).unwrap().len(), 1);
}

/// Also while it is being looked at: what was mapped is the old file.
#[test]
fn an_open_file_outlives_its_replacement() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bake");
    std::fs::write(&path, &*GOOD).unwrap();
    let baked = BakedFile::open(&path).unwrap();
    let (other, store) = (plan(&[500]), MemoryStore::default());
    run(&other, &store, &work(&other), &RunOptions::default()).unwrap();
    // Windows does not replace mapped files: an error there, and the old file stays.
    if merge(&other, &store, &path).is_ok() {
        assert_eq!(BakedFile::open(&path).unwrap().identity(), &other.identity);
    }
    assert_eq!(baked.unit(2), payload(&plan(&[3, 0, 64]), 2));
}

proptest! {
    #[test]
    fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..400), head in 0usize..60) {
        prop_assert!(BakedFile::from_bytes("a.bake", &bytes).is_err());
        // Behind the beginning of a good file.
        let bytes = [&GOOD[..head], &bytes].concat();
        prop_assert!(BakedFile::from_bytes("a.bake", &bytes).is_err());
        if bytes.len() >= 72 {
            prop_assert!(BakedFile::from_bytes("a.bake", &sealed(bytes)).is_err());
        }
    }

    /// Heads that lie and whose hash fits.
    #[test]
    fn lying_heads_are_refused(changes in prop::collection::vec((8usize..576, any::<u8>()), 1..5)) {
        let mut bytes = GOOD.clone();
        for (at, value) in changes {
            bytes[at] = value;
        }
        let bytes = resealed(bytes);
        if let Ok(baked) = BakedFile::from_bytes("a.bake", &bytes) {
            // A change of text to another valid one, such as another method's name. Then every bit is what it would be
            // written as.
            prop_assert!(baked.unit(2) == payload(&plan(&[3, 0, 64]), 2));
            prop_assert_eq!(baked.identity().units[2].bytes, 64);
        }
    }

    /// Sizes of any magnitude in the header.
    #[test]
    fn any_sizes_are_refused(file: u64, identity: u64, units: u64, shift in 0u32..64) {
        let mut bytes = GOOD.clone();
        for (at, number) in [(16, file), (24, identity), (32, units)] {
            let number = if at == 16 && file.is_multiple_of(2) { bytes.len() as u64 } else { number >> shift };
            bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
        }
        if bytes != *GOOD {
            prop_assert!(BakedFile::from_bytes("a.bake", &resealed(bytes)).is_err());
        }
    }
}
