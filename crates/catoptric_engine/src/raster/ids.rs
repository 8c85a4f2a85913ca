//! The ids of surfaces that samples show: triangles of lists, what a source has found, and nothing.

/// The id of a sample that shows nothing.
pub use super::kernel::EMPTY;

/// Samples with this bit in their id show a surface that the tile's source has found; the rest is its number.
pub const FOUND: u32 = 1 << 31;

/// The id of the surface with this number.
pub fn found_id(number: u32) -> u32 {
    number | FOUND
}

/// The number of the surface with this id, if a source has found it.
#[inline]
pub fn found_number(id: u32) -> Option<u32> {
    (id & FOUND != 0 && id != EMPTY).then_some(id & !FOUND)
}
