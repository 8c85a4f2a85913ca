//! KHR_texture_basisu: Basis Universal pictures in KTX2 containers.
//!
//! The transcoder trusts the container's header, so everything in it is checked here first: KTX 2.0, section 3,
//! and what KHR_texture_basisu allows of it.

use super::rgba::Picture;
use basisu::{DecodeFlags, TargetFormat, Transcoder};

const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Bytes before the index of levels.
const HEADER_SIZE: usize = 80;
const LEVEL_SIZE: usize = 24;
/// Places of fields in the header.
const KEY_VALUE_OFFSET: usize = 56;
const KEY_VALUE_LENGTH: usize = 60;
/// Colour models of the format descriptor: ETC1S and UASTC.
const MODELS: [u8; 2] = [163, 166];
const NO_SUPERCOMPRESSION: u32 = 0;
const BASIS_LZ: u32 = 1;
const ZSTANDARD: u32 = 2;

/// Returns true if the bytes are a KTX2 container.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Width and height, read from the header alone.
pub(super) fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    Ok((word(bytes, 20)?, word(bytes, 24)?))
}

/// The picture of the finest level.
pub(super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let (width, height) = dimensions(bytes)?;
    check(bytes, width, height)?;
    // Keys and values have no effect on the texels, and the transcoder reads them beyond their end.
    let mut checked = bytes.to_vec();
    for field in [KEY_VALUE_OFFSET, KEY_VALUE_LENGTH] {
        checked[field..field + 4].fill(0);
    }
    let problem = |error: basisu::Error| format!("cannot be transcoded: {error:?}");
    let transcoder = Transcoder::new(&checked).map_err(problem)?;
    let rgba = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(problem)?;
    let texels: Vec<[u8; 4]> = rgba.as_chunks().0.to_vec();
    if texels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(format!("holds {} texels, not {width} x {height}", texels.len()));
    }
    Ok(Picture { width, height, texels })
}

fn word(bytes: &[u8], offset: usize) -> Result<u32, String> {
    let word: Option<[u8; 4]> = bytes.get(offset..offset + 4).and_then(|word| word.try_into().ok());
    word.map(u32::from_le_bytes).ok_or_else(|| "the KTX2 header is cut off".into())
}

fn double_word(bytes: &[u8], offset: usize) -> Result<u64, String> {
    Ok(u64::from(word(bytes, offset)?) | u64::from(word(bytes, offset + 4)?) << 32)
}

fn check(bytes: &[u8], width: u32, height: u32) -> Result<(), String> {
    let field = |offset: usize| word(bytes, offset);
    let (format, depth, layers, faces, levels) = (field(12)?, field(28)?, field(32)?, field(36)?, field(40)?);
    if format != 0 || depth != 0 || layers != 0 || faces != 1 {
        return Err("is no Basis Universal picture of two dimensions".into());
    }
    if !(1..=16).contains(&levels) {
        return Err(format!("has {levels} levels; allowed are 1 to 16"));
    }
    let scheme = field(44)?;
    if scheme > ZSTANDARD {
        return Err(format!("has supercompression {scheme}; known are none, BasisLZ and Zstandard (0 to 2)"));
    }
    let range = |name: &str, offset: u64, length: u64| match offset.checked_add(length) {
        Some(end) if end <= bytes.len() as u64 => Ok(()),
        _ => Err(format!("its {name} lies outside the {} bytes of the picture", bytes.len())),
    };
    let (descriptor, descriptor_length) = (field(48)?, field(52)?);
    range("format descriptor", descriptor.into(), descriptor_length.into())?;
    if descriptor_length < 44 {
        return Err("its format descriptor is cut off".into());
    }
    let model = field(descriptor as usize + 12)? as u8;
    if !MODELS.contains(&model) {
        return Err(format!("has colour model {model}; known are ETC1S (163) and UASTC (166)"));
    }
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    range("global data", double_word(bytes, 64)?, double_word(bytes, 72)?)?;
    if (model == MODELS[0]) != (scheme == BASIS_LZ) {
        return Err("ETC1S and BasisLZ go together only".into());
    }
    for level in 0..levels as usize {
        let entry = HEADER_SIZE + level * LEVEL_SIZE;
        let (offset, length) = (double_word(bytes, entry)?, double_word(bytes, entry + 8)?);
        range("level", offset, length)?;
        let unpacked = double_word(bytes, entry + 16)?;
        if scheme == ZSTANDARD && unpacked > blocks * 16 {
            return Err(format!("promises {unpacked} bytes for {blocks} blocks of 16 bytes"));
        }
        if scheme == NO_SUPERCOMPRESSION && level == 0 && length != blocks * 16 {
            return Err(format!("has {length} bytes for {blocks} blocks of 16 bytes"));
        }
    }
    Ok(())
}
