//! The layout of a baked file.
//!
//! Numbers are little-endian. Header: magic (8), format version (4), zero (4), bytes of the file (8), bytes of the
//! identity (8), number of units (8). Then the identity as canonical JSON; at a multiple of 64 the table, for each unit
//! its offset (8), the bytes of its payload (8) and BLAKE3 of that (32); the payloads, each at a multiple of 64; at a
//! multiple of 64 BLAKE3 of all before the first payload. Gaps are zero. So the bytes of a baked file follow from
//! identity and payloads alone. Payloads have the bytes that the identity says, or at most that many.

use crate::error::BakeError;
use crate::plan::{AnyIdentity, Identity, MAX_IDENTITY_BYTES, SCHEMA};
use crate::unit::{self, array_at, u32_at, u64_at};
use std::ops::Range;

/// The first bytes of a baked file. No text begins so, and transfers as text would change it.
pub(super) const MAGIC: [u8; 8] = *b"\x89CBAKE\r\n";
/// The version of the layout.
pub const FORMAT_VERSION: u32 = 1;
/// Payloads lie at multiples of this, so that any numbers in them can be read in place, also by wide instructions.
pub const ALIGNMENT: u64 = 64;
const HEADER_BYTES: usize = 40;
pub(crate) const HASH_BYTES: usize = 32;
const ROW_BYTES: u64 = 48;

/// The layout of a file with an identity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    identity: Vec<u8>,
    /// The position of the table.
    table: usize,
    /// The position of the first payload, and the end of the table's gap.
    pub(crate) payloads: u64,
    /// The positions of the payloads.
    pub(crate) units: Vec<Range<u64>>,
    /// The bytes of the whole file.
    pub(crate) file_bytes: u64,
}

/// The next multiple of the alignment.
fn aligned(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(ALIGNMENT)
}

/// The range of the table, its gap included.
fn table_of(identity_bytes: u64, unit_count: u64) -> Option<Range<u64>> {
    let start = aligned((HEADER_BYTES as u64).checked_add(identity_bytes)?)?;
    Some(start..aligned(start.checked_add(unit_count.checked_mul(ROW_BYTES)?)?)?)
}

impl Layout {
    /// The layout of a file whose units have payloads of these sizes; returns `None` if its size overflows.
    pub(crate) fn of(identity: &Identity, sizes: &[u64]) -> Option<Self> {
        let bytes = identity.canonical_bytes();
        let table = table_of(bytes.len() as u64, identity.unit_count())?;
        let mut end = table.end;
        let mut units = Vec::with_capacity(identity.units.len());
        for bytes in sizes {
            let start = aligned(end)?;
            end = start.checked_add(*bytes)?;
            units.push(start..end);
        }
        let file_bytes = aligned(end)?.checked_add(HASH_BYTES as u64)?;
        Some(Self { identity: bytes, table: table.start as usize, payloads: table.end, units, file_bytes })
    }

    /// Everything before the first payload, given the hashes of all.
    pub(crate) fn head(&self, hashes: &[[u8; HASH_BYTES]]) -> Vec<u8> {
        let mut head = Vec::with_capacity(self.payloads as usize);
        head.extend_from_slice(&MAGIC);
        head.extend_from_slice(&FORMAT_VERSION.to_le_bytes());
        head.extend_from_slice(&[0; 4]);
        for number in [self.file_bytes, self.identity.len() as u64, self.units.len() as u64] {
            head.extend_from_slice(&number.to_le_bytes());
        }
        head.extend_from_slice(&self.identity);
        head.resize(self.table, 0);
        for (unit, hash) in self.units.iter().zip(hashes) {
            head.extend_from_slice(&unit.start.to_le_bytes());
            head.extend_from_slice(&(unit.end - unit.start).to_le_bytes());
            head.extend_from_slice(hash);
        }
        head.resize(self.payloads as usize, 0);
        head
    }
}

/// The parts of a baked file that is only being read, before its payloads are.
pub(super) struct Head {
    pub(super) identity: Identity,
    /// Payloads with their hashes; all lie within the file.
    pub(super) units: Vec<(Range<usize>, [u8; HASH_BYTES])>,
    /// The end of the last gap and beginning of the file's hash.
    pub(super) footer: usize,
}

/// Reads everything but the payloads. Nothing in the file is believed before it is checked against the file's length.
pub(super) fn read_head(file: &str, bytes: &[u8]) -> Result<Head, BakeError> {
    check_kind(file, bytes)?;
    let found = bytes.len() as u64;
    let short = |expected, problem| Err(BakeError::Length { file: file.into(), expected, found, problem });
    let fixed = HEADER_BYTES + HASH_BYTES;
    if bytes.len() < fixed {
        return short(fixed as u64, "not even the header is whole");
    }
    let version = u32_at(bytes, 8);
    if version != FORMAT_VERSION {
        let (file, field, known) = (file.into(), "format version", FORMAT_VERSION);
        return Err(BakeError::Version { file, field, found: version, known });
    }
    let (expected, identity_bytes, unit_count) = (u64_at(bytes, 16), u64_at(bytes, 24), u64_at(bytes, 32));
    if found != expected {
        return short(expected, if found < expected { "its end is missing" } else { "something follows its end" });
    }
    let damaged = |problem| BakeError::Damaged { file: file.into(), part: "the header".into(), problem };
    let footer = bytes.len() - HASH_BYTES;
    let table = table_of(identity_bytes, unit_count).filter(|table| table.end <= footer as u64);
    let table = table.ok_or_else(|| damaged("its sizes do not fit the file"))?;
    let head = &bytes[..table.end as usize];
    if blake3::hash(head) != bytes[footer..] {
        return Err(damaged("its hash does not fit"));
    }

    let invalid = |field: &str, problem: String| BakeError::invalid(file, field, problem);
    if identity_bytes > MAX_IDENTITY_BYTES {
        return Err(invalid("identity", format!("{identity_bytes} bytes, {MAX_IDENTITY_BYTES} are allowed")));
    }
    let text = &head[HEADER_BYTES..HEADER_BYTES + identity_bytes as usize];
    let identity = read_identity(file, text)?;
    if identity.unit_count() != unit_count {
        return Err(invalid(
            "identity.units",
            format!("names {} units, the header {unit_count}", identity.unit_count()),
        ));
    }
    let row = |number: usize| &head[table.start as usize + number * ROW_BYTES as usize..][..ROW_BYTES as usize];
    let sizes: Vec<u64> = (0..identity.units.len()).map(|number| u64_at(row(number), 8)).collect();
    let are_allowed = identity.units.iter().zip(&sizes).all(|(unit, bytes)| unit.admits(*bytes));
    let layout = Layout::of(&identity, &sizes).filter(|layout| are_allowed && layout.file_bytes == found);
    let layout = layout.ok_or_else(|| invalid("identity.units", "its sizes do not fit the file".into()))?;
    if layout.identity != text {
        return Err(invalid("identity", "its JSON is not in the canonical form".into()));
    }
    let hashes: Vec<[u8; HASH_BYTES]> = (0..layout.units.len()).map(|number| array_at(row(number), 16)).collect();
    // There is one way to write a head, so this covers gaps, offsets and lengths.
    if layout.head(&hashes) != head {
        return Err(invalid("header", "it is not written as this format says".into()));
    }
    let place = |unit: &Range<u64>| unit.start as usize..unit.end as usize;
    let units = layout.units.iter().map(place).zip(hashes).collect();
    Ok(Head { identity, units, footer })
}

fn read_identity(file: &str, text: &[u8]) -> Result<Identity, BakeError> {
    let invalid = |error: serde_json::Error| BakeError::invalid(file, "identity", error.to_string());
    // Other schemas have other fields, so the schema is read before these.
    let schema = serde_json::from_slice::<AnyIdentity>(text).map_err(invalid)?.schema;
    if schema != SCHEMA {
        return Err(BakeError::Version { file: file.into(), field: "schema", found: schema, known: SCHEMA });
    }
    let identity: Identity = serde_json::from_slice(text).map_err(invalid)?;
    identity.validate(file)?;
    Ok(identity)
}

/// Refuses files that do not begin as baked files do, and names the format that they seem to have.
fn check_kind(file: &str, bytes: &[u8]) -> Result<(), BakeError> {
    const BAKE: &str = "bake first, or name the file that a merge has written";
    let (kind, remedy) = match bytes {
        [] => ("empty", "copy or merge it again"),
        _ if bytes.starts_with(&MAGIC) => return Ok(()),
        _ if MAGIC.starts_with(bytes) => ("the first bytes of one", "copy or merge it again"),
        _ if bytes.starts_with(&unit::MAGIC) => ("one unit of a bake", "merge that bake, and name the merged file"),
        [b'{', ..] => ("text, perhaps a plan", "run and merge the plan, and name the merged file"),
        [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, 0xff, ..] | [0x76, 0x2f, 0x31, 0x01, ..] => ("a picture", BAKE),
        _ => ("something else", BAKE),
    };
    Err(BakeError::Foreign { file: file.into(), kind, remedy })
}
