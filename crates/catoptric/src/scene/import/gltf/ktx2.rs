//! KHR_texture_basisu: Basis Universal pictures in KTX2 containers.

use super::super::picture::Picture;
use basisu::{DecodeFlags, TargetFormat, Transcoder};

const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// Whether the bytes are a KTX2 container.
pub(in super::super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Width and height, read from the header alone.
pub(in super::super) fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    let word = |offset: usize| {
        let bytes: Option<[u8; 4]> = bytes.get(offset..offset + 4).and_then(|word| word.try_into().ok());
        bytes.map(u32::from_le_bytes).ok_or("is cut off")
    };
    Ok((word(20)?, word(24)?))
}

/// The picture of the finest level.
pub(in super::super) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let problem = |error: basisu::Error| format!("cannot be transcoded: {error:?}");
    let transcoder = Transcoder::new(bytes).map_err(problem)?;
    let (width, height) = transcoder.base_dimensions();
    if (width, height) != dimensions(bytes)? {
        return Err("has two different sizes".into());
    }
    let rgba = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(problem)?;
    let texels: Vec<[u8; 4]> = rgba.as_chunks().0.to_vec();
    if texels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(format!("holds {} texels, not {width} x {height}", texels.len()));
    }
    Ok(Picture { width, height, texels })
}
