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

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(u32, &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, data) in chunks {
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(kind.to_le_bytes());
            body.extend(*data);
        }
        let mut file = MAGIC.to_vec();
        file.extend(2u32.to_le_bytes());
        file.extend((12 + body.len() as u32).to_le_bytes());
        file.extend(body);
        file
    }

    #[test]
    fn chunks_are_found() {
        let file = glb(&[(JSON, b"{}  "), (BINARY, &[1, 2, 3, 4]), (7, b"else")]);
        assert_eq!(split("a", &file).unwrap(), Parts { json: b"{}  ", binary: Some(&[1, 2, 3, 4]), is_aligned: true });
        assert_eq!(split("a", b"\xef\xbb\xbf{}").unwrap(), Parts { json: b"{}", binary: None, is_aligned: true });
        let odd = glb(&[(JSON, b"{}")]);
        assert!(split("a", &odd).is_ok_and(|parts| !parts.is_aligned));
    }

    #[test]
    fn every_cut_is_an_error() {
        let file = glb(&[(JSON, b"{}  "), (BINARY, &[1, 2, 3, 4])]);
        for length in 4..file.len() {
            let message = split("cut.glb", &file[..length]).unwrap_err().to_string();
            assert!(message.starts_with("cut.glb: GLB container: "), "{message}");
        }
    }

    #[test]
    fn wrong_chunks_are_errors() {
        for chunks in [
            &[(JSON, &b"{}  "[..]), (JSON, b"{}  ")][..],
            &[(BINARY, b"1234"), (JSON, b"{}  ")],
            &[(JSON, b"{}  "), (BINARY, b"1234"), (BINARY, b"1234")],
            &[],
        ] {
            assert!(split("a", &glb(chunks)).is_err(), "{chunks:?}");
        }
        let mut version_1 = glb(&[(JSON, b"{}  ")]);
        version_1[4] = 1;
        assert!(split("a", &version_1).unwrap_err().to_string().contains("version 1"));
    }
}
