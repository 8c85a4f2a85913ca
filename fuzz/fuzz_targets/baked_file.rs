//! Any bytes as a baked file and as a unit of one: an error, or units within the file.
#![no_main]

use catoptric_bake::{BakedFile, PlanHash, unit};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    look(bytes);
    look(&sealed(bytes));
    if let Ok(payload) = unit::decode(bytes, PlanHash([0; 32]), 0) {
        assert_eq!(unit::encode(PlanHash([0; 32]), 0, payload), bytes);
    }
});

fn look(bytes: &[u8]) {
    let Ok(baked) = BakedFile::from_bytes("fuzz", bytes) else { return };
    let total: u64 = (0..baked.unit_count()).map(|number| baked.unit(number).len() as u64).sum();
    assert!(total < bytes.len() as u64);
}

/// The same with the beginning, length and hash of a baked file, which chance does not find.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if bytes.len() < 72 {
        return bytes;
    }
    let length = bytes.len() as u64;
    bytes[..16].copy_from_slice(b"\x89CBAKE\r\n\x01\0\0\0\0\0\0\0");
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|byte| bytes[at + byte])) % (length + 1);
    let table = (40 + number(24)).next_multiple_of(64);
    let end = (table + number(32) * 48).next_multiple_of(64);
    let footer = bytes.len() - 32;
    if end <= footer as u64 {
        let hash = blake3::hash(&bytes[..end as usize]);
        bytes[footer..].copy_from_slice(hash.as_bytes());
    }
    bytes
}
