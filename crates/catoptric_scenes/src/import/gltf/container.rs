//! The binary container: a header, a JSON chunk, and at most one chunk of binary data.

use catoptric_core::error::SceneError;

/// The parts of a glTF file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parts<'a> {
    pub(super) json: &'a [u8],
    /// The binary chunk of a GLB file.
    pub(super) binary: Option<&'a [u8]>,
    /// All chunks fill whole words, as they must.
    pub(super) is_aligned: bool,
}

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

/// Splits a file into its parts; a file that does not start like GLB is all JSON.
pub(super) fn split<'a>(name: &str, bytes: &'a [u8]) -> Result<Parts<'a>, SceneError> {
    let invalid = |problem: String| SceneError::invalid(name, "GLB container", problem);
    if !bytes.starts_with(MAGIC) {
        return Ok(Parts {
            json: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
            binary: None,
            is_aligned: true,
        });
    }
    let word = |offset: usize| {
        let bytes: Option<[u8; 4]> = bytes.get(offset..offset + 4).and_then(|word| word.try_into().ok());
        bytes.map(u32::from_le_bytes)
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(invalid("the file ends inside the header of 12 bytes".into()));
    };
    if version != 2 {
        return Err(invalid(format!("version {version}; only version 2 can be read")));
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(invalid(format!("the header promises {length} bytes, but there are {}", bytes.len())));
    }
    let (mut json, mut binary, mut is_aligned) = (None, None, true);
    let mut offset = 12;
    while offset < length {
        let (Some(chunk_length), Some(kind)) = (word(offset), word(offset + 4)) else {
            return Err(invalid(format!("the file ends inside the chunk header at byte {offset}")));
        };
        let begin = offset + 8;
        let end = begin + chunk_length as usize;
        let Some(chunk) = bytes.get(begin..end).filter(|_| end <= length) else {
            return Err(invalid(format!("the chunk at byte {offset} is cut off: {chunk_length} bytes promised")));
        };
        match kind {
            JSON if json.is_none() && offset == 12 => json = Some(chunk),
            BINARY if binary.is_none() && json.is_some() => binary = Some(chunk),
            JSON | BINARY => return Err(invalid(format!("the chunk at byte {offset} is one too many"))),
            // The standard makes readers pass over chunks of other kinds.
            _ if json.is_some() => {}
            _ => return Err(invalid("the first chunk must be JSON".into())),
        }
        // Chunks must fill whole words; a file that does not pad is read without padding.
        is_aligned &= chunk_length.is_multiple_of(4);
        offset = end;
    }
    let json = json.ok_or_else(|| invalid("there is no JSON chunk".into()))?;
    Ok(Parts { json, binary, is_aligned })
}
