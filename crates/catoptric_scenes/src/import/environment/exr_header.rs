//! Says in plain words why an OpenEXR file is not read.

use exr::error::Error;

/// Names that a message lists, at most.
const MAX_NAMES: usize = 12;

/// The message about a file that the library refuses, from what its header says.
pub(super) fn explain(bytes: &[u8], error: &Error) -> String {
    if let Some(reason) = reason(bytes) {
        return reason;
    }
    match error {
        Error::Invalid(detail) if detail.contains("missing bytes") => {
            "ends too early: it is cut off; save or download it again".into()
        }
        Error::Invalid(detail) | Error::NotSupported(detail) => {
            format!("is broken or of an unknown kind of OpenEXR ({detail}); save it again with ZIP or PIZ compression")
        }
        other => format!("cannot be read: {other}"),
    }
}

/// Channels as a message tells them, with a remark.
pub(super) fn channels_told<'a>(names: impl Iterator<Item = &'a str>, remark: &str) -> String {
    let names: Vec<&str> = names.collect();
    let more = names.len().saturating_sub(MAX_NAMES);
    let mut told = names.into_iter().take(MAX_NAMES).collect::<Vec<_>>().join(", ");
    if more > 0 {
        told += &format!(" and {more} more");
    }
    format!("has the channels {told}; {remark}")
}

/// The property of the first part for which it is not read: deep pixels, a foreign compression, brightness apart
/// from colours.
fn reason(bytes: &[u8]) -> Option<String> {
    let version = u32::from_le_bytes(*bytes.get(4..)?.first_chunk()?);
    if version & (1 << 11) != 0 {
        return Some("is a deep picture, with several values a pixel: save it as a flat one".into());
    }
    let mut rest = bytes.get(8..)?;
    let (mut compression, mut names, mut is_reduced) = (None, Vec::new(), false);
    while *rest.first()? != 0 {
        let name = word(&mut rest)?;
        word(&mut rest)?;
        let (size, after) = rest.split_first_chunk()?;
        let size = usize::try_from(i32::from_le_bytes(*size)).ok()?;
        let (value, after) = after.split_at_checked(size)?;
        rest = after;
        match name {
            "compression" => compression = value.first(),
            "channels" => (names, is_reduced) = channels(value)?,
            _ => {}
        }
    }
    match compression {
        Some(10 | 11) => Some("is compressed as HTJ2K, which is not read: save it with ZIP or PIZ compression".into()),
        Some(&method) if method > 9 => {
            Some(format!("is compressed by method {method}, which is not read: save it with ZIP or PIZ compression"))
        }
        _ if is_reduced => {
            let remark = "some at a lower resolution, which is not read: save it as R, G and B";
            Some(channels_told(names.into_iter(), remark))
        }
        _ => None,
    }
}

/// The names of channels; true if some have fewer samples than the picture has pixels.
fn channels(mut value: &[u8]) -> Option<(Vec<&str>, bool)> {
    let (mut names, mut is_reduced) = (Vec::new(), false);
    while *value.first()? != 0 {
        names.push(word(&mut value)?);
        // Kind of samples, linearity and padding, then the sampling rates.
        let (record, after) = value.split_first_chunk::<16>()?;
        is_reduced |= record[8..] != [1, 0, 0, 0, 1, 0, 0, 0];
        value = after;
    }
    Some((names, is_reduced))
}

/// The text before the next zero.
fn word<'a>(bytes: &mut &'a [u8]) -> Option<&'a str> {
    let end = bytes.iter().position(|byte| *byte == 0)?;
    let (word, rest) = bytes.split_at(end);
    *bytes = &rest[1..];
    std::str::from_utf8(word).ok()
}
