//! Unit files: the parts of a bake that are published one by one. One that is there with a fitting hash is done;
//! nothing else is recorded.
//!
//! Layout, numbers little-endian: magic (8), format version (4), zero (4), plan hash (32), unit number (8), bytes of
//! the payload (8), payload, BLAKE3 of all before (32). The hash stands at the end in every version, so that damage is
//! distinguished from files of other versions, plans and units.

use crate::plan_hash::PlanHash;
use serde::Serialize;
use std::fmt;

/// The first bytes of a unit file. No text begins so, and transfers as text would change it.
pub(crate) const MAGIC: [u8; 8] = *b"\x89CUNIT\r\n";
/// The version of the layout.
pub const FORMAT_VERSION: u32 = 1;
const HEADER_BYTES: usize = 64;
const HASH_BYTES: usize = 32;
/// The bytes of a unit file besides the payload.
pub(crate) const FRAME_BYTES: u64 = (HEADER_BYTES + HASH_BYTES) as u64;
/// The most bytes of a unit file: object stores take what is larger in parts only, and then cannot refuse to overwrite.
const MAX_FILE_BYTES: u64 = 64 << 20;
/// The most bytes of a payload.
pub const MAX_PAYLOAD_BYTES: u64 = MAX_FILE_BYTES - FRAME_BYTES;

/// Why a file is not the unit that it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitFault {
    /// The end of the file is missing.
    Truncated {
        /// The right number of bytes.
        expected: u64,
        /// The number found.
        found: u64,
    },
    /// Something follows its end.
    Longer {
        /// The right number of bytes.
        expected: u64,
        /// The number found.
        found: u64,
    },
    /// The file does not begin as units do.
    Foreign,
    /// The hash does not fit the content.
    Damaged,
    /// The file is whole, and of another version of the format.
    OtherVersion {
        /// The version of the file.
        found: u32,
    },
    /// The file is whole, and of another bake.
    OtherPlan {
        /// The name of that bake.
        found: PlanHash,
    },
    /// The file is whole, and another unit of this bake.
    OtherUnit {
        /// The number of that unit.
        found: u64,
    },
    /// The file is whole, and its payload has another size than planned.
    OtherSize {
        /// The size in the plan, or the largest that it allows.
        planned: u64,
        /// The payload's size.
        found: u64,
    },
}

impl UnitFault {
    /// True if the file is of no use to anybody and may be replaced. Whole files are left alone: somebody put them
    /// there.
    pub fn is_damage(self) -> bool {
        matches!(self, Self::Truncated { .. } | Self::Longer { .. } | Self::Foreign | Self::Damaged)
    }
}

impl fmt::Display for UnitFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated { expected, found } => write!(formatter, "is truncated: {found} of {expected} bytes"),
            Self::Longer { expected, found } => write!(formatter, "has {found} bytes where {expected} belong"),
            Self::Foreign => write!(formatter, "is no unit of a bake"),
            Self::Damaged => write!(formatter, "is damaged: its hash does not fit"),
            Self::OtherVersion { found } => {
                write!(formatter, "has format version {found}, this program reads {FORMAT_VERSION}")
            }
            Self::OtherPlan { found } => write!(formatter, "belongs to another bake, {found}"),
            Self::OtherUnit { found } => write!(formatter, "is unit {found}"),
            Self::OtherSize { planned, found } => {
                write!(formatter, "holds {found} bytes where the plan says {planned}")
            }
        }
    }
}

impl Serialize for UnitFault {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The bytes of the file of a unit with a payload of `payload_bytes`.
pub fn file_bytes(payload_bytes: u64) -> u64 {
    payload_bytes.saturating_add(FRAME_BYTES)
}

/// The name of a unit's file in its store; names sort as numbers do.
pub fn file_name(number: u64, count: u64) -> String {
    let digits = count.saturating_sub(1).to_string().len().max(6);
    format!("unit-{number:0digits$}.bin")
}

/// The bytes of a unit's file.
pub fn encode(plan: PlanHash, number: u64, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(payload.len() + FRAME_BYTES as usize);
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&FORMAT_VERSION.to_le_bytes());
    bytes.extend_from_slice(&[0; 4]);
    bytes.extend_from_slice(&plan.0);
    bytes.extend_from_slice(&number.to_le_bytes());
    bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    bytes.extend_from_slice(payload);
    let hash = blake3::hash(&bytes);
    bytes.extend_from_slice(hash.as_bytes());
    bytes
}

/// The payload of a unit's file.
///
/// # Errors
/// A [`UnitFault`] unless the bytes are those that [`encode`] gives for the plan and the number.
pub fn decode(bytes: &[u8], plan: PlanHash, number: u64) -> Result<&[u8], UnitFault> {
    let found = bytes.len() as u64;
    if !bytes.starts_with(&MAGIC) {
        // The remainder of a unit is the beginning of the magic, or nothing at all.
        let torn = MAGIC.starts_with(bytes);
        return Err(if torn { UnitFault::Truncated { expected: FRAME_BYTES, found } } else { UnitFault::Foreign });
    }
    if found < FRAME_BYTES {
        return Err(UnitFault::Truncated { expected: FRAME_BYTES, found });
    }
    let (before, hash) = bytes.split_at(bytes.len() - HASH_BYTES);
    let (header, payload) = before.split_at(HEADER_BYTES);
    let length = u64_at(header, 56);
    if blake3::hash(before) != *hash {
        let expected = file_bytes(length);
        return Err(match found.cmp(&expected) {
            std::cmp::Ordering::Less => UnitFault::Truncated { expected, found },
            std::cmp::Ordering::Greater => UnitFault::Longer { expected, found },
            std::cmp::Ordering::Equal => UnitFault::Damaged,
        });
    }
    let version = u32_at(header, 8);
    if version != FORMAT_VERSION {
        return Err(UnitFault::OtherVersion { found: version });
    }
    if header[16..48] != plan.0 {
        return Err(UnitFault::OtherPlan { found: PlanHash(array_at(header, 16)) });
    }
    if u64_at(header, 48) != number {
        return Err(UnitFault::OtherUnit { found: u64_at(header, 48) });
    }
    if length != payload.len() as u64 || u32_at(header, 12) != 0 {
        return Err(UnitFault::Damaged);
    }
    Ok(payload)
}

/// The bytes at an offset; the caller has checked that they are there.
pub(crate) fn array_at<const N: usize>(bytes: &[u8], offset: usize) -> [u8; N] {
    let mut array = [0; N];
    array.copy_from_slice(&bytes[offset..offset + N]);
    array
}

/// The number at an offset, as [`array_at`].
pub(crate) fn u32_at(bytes: &[u8], offset: usize) -> u32 {
    u32::from_le_bytes(array_at(bytes, offset))
}

/// The number at an offset, as [`array_at`].
pub(crate) fn u64_at(bytes: &[u8], offset: usize) -> u64 {
    u64::from_le_bytes(array_at(bytes, offset))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PLAN: PlanHash = PlanHash([7; 32]);

    /// The unit with another header, and the hash that fits it.
    fn sealed(change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
        let mut bytes = encode(PLAN, 3, b"payload");
        bytes.truncate(bytes.len() - HASH_BYTES);
        change(&mut bytes);
        let hash = blake3::hash(&bytes);
        bytes.extend_from_slice(hash.as_bytes());
        bytes
    }

    #[test]
    fn comes_back_as_it_was() {
        for payload in [&b""[..], b"x", &[5; 1000]] {
            let bytes = encode(PLAN, 3, payload);
            assert_eq!(bytes.len() as u64, file_bytes(payload.len() as u64));
            assert_eq!(decode(&bytes, PLAN, 3), Ok(payload));
        }
    }

    #[test]
    fn every_truncation_and_every_flipped_bit_is_damage() {
        let good = encode(PLAN, 3, b"payload");
        for length in 0..good.len() {
            let fault = decode(&good[..length], PLAN, 3).unwrap_err();
            assert!(matches!(fault, UnitFault::Truncated { .. }), "{length}: {fault}");
        }
        for bit in 0..good.len() * 8 {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            let fault = decode(&bytes, PLAN, 3).unwrap_err();
            assert!(fault.is_damage(), "bit {bit}: {fault}");
        }
        let longer = [&good[..], &[0]].concat();
        assert!(matches!(decode(&longer, PLAN, 3), Err(UnitFault::Longer { .. })));
        assert_eq!(decode(&vec![0; good.len()], PLAN, 3), Err(UnitFault::Foreign));
        assert_eq!(decode(b"\x89PNG\r\n\x1a\n", PLAN, 3), Err(UnitFault::Foreign));
    }

    #[test]
    fn whole_files_of_other_plans_are_not_damage() {
        let other = PlanHash([8; 32]);
        let faults = [
            (sealed(|bytes| bytes[8] = 2), UnitFault::OtherVersion { found: 2 }),
            (encode(other, 3, b""), UnitFault::OtherPlan { found: other }),
            (encode(PLAN, 4, b""), UnitFault::OtherUnit { found: 4 }),
        ];
        for (bytes, fault) in faults {
            assert_eq!(decode(&bytes, PLAN, 3), Err(fault));
            assert!(!fault.is_damage());
        }
        // No program of ours writes these.
        assert_eq!(decode(&sealed(|bytes| bytes.push(0)), PLAN, 3), Err(UnitFault::Damaged));
        assert_eq!(decode(&sealed(|bytes| bytes[12] = 1), PLAN, 3), Err(UnitFault::Damaged));
        assert_eq!(decode(&sealed(|bytes| bytes[56..64].fill(255)), PLAN, 3), Err(UnitFault::Damaged));
    }

    #[test]
    fn names_sort_as_numbers() {
        assert_eq!(file_name(123, 500), "unit-000123.bin");
        assert_eq!(file_name(123, 1_000_000), "unit-000123.bin");
        assert_eq!(file_name(123, 1_000_001), "unit-0000123.bin");
    }

    proptest! {
        #[test]
        fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..300), with_magic: bool) {
            let bytes = if with_magic { [&MAGIC[..], &bytes].concat() } else { bytes };
            prop_assert!(decode(&bytes, PLAN, 3).is_err());
        }

        /// Headers that lie and whose hash fits.
        #[test]
        fn lying_headers_are_refused(changes in prop::collection::vec((0usize..64, 1u8..), 1..4)) {
            let good = encode(PLAN, 3, b"payload");
            let bytes = sealed(|bytes| changes.iter().for_each(|&(at, by)| bytes[at] ^= by));
            prop_assert_eq!(decode(&bytes, PLAN, 3).is_ok(), bytes == good);
        }
    }
}
