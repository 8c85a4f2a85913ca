//! Blocks of OpenEXR files whose own numbers say how much memory they take.

use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock};
use exr::compression::Compression;
use exr::meta::header::Header;

/// Sizes of the uncompressed parts among the counters at the start of a block of DWA (those of unknown channels, of
/// run lengths, and of bytes): the decoder takes as much memory as they say.
const BYTE_COUNTERS: [usize; 3] = [1, 6, 7];
/// The numbers of coefficients among them, of two bytes each.
const COEFFICIENT_COUNTERS: [usize; 2] = [8, 9];
const COUNTERS: usize = 11;
/// Coefficients stand for squares of so many pixels a side.
const SQUARE: usize = 8;

/// True for parts whose blocks begin with counters.
pub(crate) fn is_dwa(header: &Header) -> bool {
    matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_))
}

/// Refuses a block whose counters ask for more memory than its pixels can take.
///
/// # Errors
/// The fault, in words.
pub fn check(chunk: &Chunk, header: &Header) -> Result<(), String> {
    if !is_dwa(header) {
        return Ok(());
    }
    let (CompressedBlock::ScanLine(CompressedScanLineBlock { compressed_pixels_le: bytes, .. })
    | CompressedBlock::Tile(CompressedTileBlock { compressed_pixels_le: bytes, .. })) = &chunk.compressed_block
    else {
        return Ok(());
    };
    let indices = header.get_block_data_indices(&chunk.compressed_block);
    let bounds = indices.and_then(|indices| header.get_absolute_block_pixel_coordinates(indices));
    let size = bounds.map_err(|error| error.to_string())?.size;
    let uncompressed = size.area().saturating_mul(header.channels.bytes_per_pixel);
    // Blocks that compression would not make smaller are stored as they are; shorter ones the decoder refuses.
    if bytes.len() == uncompressed || bytes.len() < 8 * COUNTERS {
        return Ok(());
    }
    let padded = |side: usize| side.next_multiple_of(SQUARE) as u64;
    let in_squares = padded(size.width()) * padded(size.height()) * header.channels.list.len() as u64 * 2;
    // Run lengths of what never repeats take twice as much.
    let most = 2 * (uncompressed as u64).max(in_squares);
    let counter = |index: usize| bytes[8 * index..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
    let sizes = BYTE_COUNTERS.map(counter);
    let coefficients = COEFFICIENT_COUNTERS.map(|index| counter(index).saturating_mul(2));
    match sizes.into_iter().chain(coefficients).find(|size| *size > most) {
        Some(size) => Err(format!("is broken: a block of {uncompressed} bytes claims to hold {size}; save it again")),
        None => Ok(()),
    }
}
