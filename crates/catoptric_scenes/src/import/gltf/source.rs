//! State shared by all parts of the importer: the document, its buffers, the memory budget and the warnings.

use super::super::{Resolver, files};
use super::meshopt;
use super::schema;
use super::schema::{Buffer, Document, Extensions};
use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use catoptric_core::error::SceneError;
use serde::de::DeserializeOwned;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell, RefCell};

/// Decoded bytes that are allowed whatever the size of the file.
const FREE_BYTES: u64 = 256 << 20;
/// Decoded bytes that are allowed for every byte of the file and its buffers: shared and compressed data grows.
const DECODED_PER_BYTE: u64 = 16;
/// The most warnings that are kept; a broken file could bring millions.
const MAX_WARNINGS: usize = 100;

/// A glTF file that is being read.
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) document: &'a Document,
    binary: Option<&'a [u8]>,
    resolver: &'a dyn Resolver,
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
    /// Views that had to be decompressed.
    decoded_views: Vec<OnceCell<Vec<u8>>>,
    file_bytes: Cell<u64>,
    decoded_bytes: Cell<u64>,
    warnings: RefCell<Vec<String>>,
}

impl<'a> Source<'a> {
    pub(super) fn new(
        name: &'a str,
        document: &'a Document,
        file_bytes: usize,
        binary: Option<&'a [u8]>,
        resolver: &'a dyn Resolver,
    ) -> Self {
        Self {
            name,
            document,
            binary,
            resolver,
            buffers: vec![OnceCell::new(); document.buffers.len()],
            decoded_views: vec![OnceCell::new(); document.buffer_views.len()],
            file_bytes: Cell::new(file_bytes as u64),
            decoded_bytes: Cell::new(0),
            warnings: RefCell::default(),
        }
    }

    /// The binary chunk of a GLB file.
    pub(super) fn binary(&self) -> Option<&'a [u8]> {
        self.binary
    }

    /// A wrong field of the file.
    pub(super) fn invalid(&self, field: impl Into<String>, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(self.name, field, problem)
    }

    /// Warns the user of something that was left out or mended, once for equal warnings.
    pub(super) fn warn(&self, warning: impl Into<String>) {
        let (warning, mut warnings) = (warning.into(), self.warnings.borrow_mut());
        if warnings.len() < MAX_WARNINGS && !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }

    pub(super) fn into_warnings(self) -> Vec<String> {
        self.warnings.into_inner()
    }

    /// The entry that an index of the file names.
    pub(super) fn entry<'l, T>(
        &self,
        list: &'l [T],
        index: usize,
        field: &dyn Fn() -> String,
        list_name: &str,
    ) -> Result<&'l T, SceneError> {
        list.get(index).ok_or_else(|| {
            let problem = format!("there is no {list_name}[{index}]; the file has {}", list.len());
            self.invalid(field(), problem)
        })
    }

    /// An extension's object, if it is there.
    pub(super) fn extension<T: DeserializeOwned>(
        &self,
        owner: &dyn Fn() -> String,
        extensions: &Extensions,
        key: &str,
    ) -> Result<Option<T>, SceneError> {
        schema::extension(self.name, owner, extensions, key)
    }

    /// A texture of an extension, if it is there.
    pub(super) fn texture_of_extension(
        &self,
        owner: &dyn Fn() -> String,
        extensions: &Extensions,
        key: &str,
        field: &str,
    ) -> Result<Option<schema::TextureInfo>, SceneError> {
        let Some(info) = extensions.get(key).and_then(|extension| extension.get(field)) else { return Ok(None) };
        schema::typed(info.clone())
            .map(Some)
            .map_err(|(rest, problem)| self.invalid(format!("{}.extensions.{key}.{field}.{rest}", owner()), problem))
    }

    /// Accounts for memory that is about to be filled with decoded data.
    pub(super) fn spend(&self, bytes: u64, field: &dyn Fn() -> String) -> Result<(), SceneError> {
        let total = self.decoded_bytes.get().saturating_add(bytes);
        let allowed = FREE_BYTES + DECODED_PER_BYTE * self.file_bytes.get();
        if total > allowed {
            let problem = format!("{total} bytes of decoded data; allowed are {allowed} for files of this size");
            return Err(self.invalid(field(), problem));
        }
        self.decoded_bytes.set(total);
        Ok(())
    }

    /// The bytes of a buffer, at least as many as its `byteLength`.
    pub(super) fn buffer(&self, index: usize, field: &dyn Fn() -> String) -> Result<&[u8], SceneError> {
        let buffer = self.entry(&self.document.buffers, index, field, "buffers")?;
        let cell = &self.buffers[index];
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let bytes = self.read_buffer(index, buffer)?;
        if (bytes.len() as u64) < buffer.byte_length {
            let problem = format!("{} bytes, but only {} are there", buffer.byte_length, bytes.len());
            return Err(self.invalid(format!("buffers[{index}].byteLength"), problem));
        }
        Ok(cell.get_or_init(|| bytes))
    }

    fn read_buffer(&self, index: usize, buffer: &Buffer) -> Result<Cow<'a, [u8]>, SceneError> {
        let field = || format!("buffers[{index}].uri");
        match &buffer.uri {
            Some(uri) => Ok(Cow::Owned(self.read_uri(uri, &field)?)),
            None => match self.binary {
                Some(binary) if index == 0 => Ok(Cow::Borrowed(binary)),
                _ => Err(self.invalid(field(), "missing; only the first buffer of a GLB file may do without")),
            },
        }
    }

    /// The bytes behind a URI: embedded ones or a file beside this one.
    pub(super) fn read_uri(&self, uri: &str, field: &dyn Fn() -> String) -> Result<Vec<u8>, SceneError> {
        // A colon is allowed in file names and stands after drive letters; a scheme of two letters or more is an
        // address.
        let is_scheme =
            |scheme: &str| scheme.len() > 1 && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
        let mut path = uri;
        if let Some((scheme, rest)) = uri.split_once(':').filter(|(scheme, _)| is_scheme(scheme)) {
            match scheme.to_ascii_lowercase().as_str() {
                "data" => return data_of(rest).map_err(|problem| self.invalid(field(), problem)),
                "file" => path = rest.trim_start_matches('/'),
                scheme => {
                    let start: String = uri.chars().take(80).collect();
                    let problem = format!("`{start}` is an address ({scheme}); only files beside the scene are read");
                    return Err(self.invalid(field(), problem));
                }
            }
        }
        let read = |name: &str| files::read_written(self.resolver, name, files::MAX_SCENE_BYTES);
        let decoded = percent_encoding::percent_decode_str(path).decode_utf8();
        // Some writers do not encode: a file whose name holds a percent sign is tried as it stands, too.
        let bytes = match &decoded {
            Ok(name) => read(name).or_else(|error| if *name == path { Err(error) } else { read(path).or(Err(error)) }),
            Err(_) => read(path),
        };
        let bytes = bytes.map_err(|error| match error {
            SceneError::Read { path, source } => self.invalid(field(), format!("{}: {source}", path.display())),
            error => self.invalid(field(), error.to_string()),
        })?;
        self.file_bytes.set(self.file_bytes.get() + bytes.len() as u64);
        Ok(bytes)
    }

    /// The bytes of a buffer view, decompressed where they are compressed.
    pub(super) fn view(&self, index: usize, field: &dyn Fn() -> String) -> Result<&[u8], SceneError> {
        let view = self.entry(&self.document.buffer_views, index, field, "bufferViews")?;
        let owner = || format!("bufferViews[{index}]");
        for key in meshopt::EXTENSIONS {
            if let Some(compressed) = self.extension::<schema::Meshopt>(&owner, &view.extensions, key)? {
                let cell = &self.decoded_views[index];
                if let Some(bytes) = cell.get() {
                    return Ok(bytes);
                }
                let field = || format!("{}.extensions.{key}", owner());
                let buffer = compressed.buffer.ok_or_else(|| self.invalid(format!("{}.buffer", field()), "missing"))?;
                let bytes = self.slice(buffer, compressed.byte_offset, compressed.byte_length, &field)?;
                let size = compressed.count.saturating_mul(compressed.byte_stride);
                self.spend(size, &field)?;
                let bytes = meshopt::decode(&compressed, bytes).map_err(|problem| self.invalid(field(), problem))?;
                return Ok(cell.get_or_init(|| bytes));
            }
        }
        let buffer = view.buffer.ok_or_else(|| self.invalid(format!("{}.buffer", owner()), "missing"))?;
        self.slice(buffer, view.byte_offset, view.byte_length, &owner)
    }

    fn slice(&self, buffer: usize, offset: u64, length: u64, field: &dyn Fn() -> String) -> Result<&[u8], SceneError> {
        let bytes = self.buffer(buffer, &|| format!("{}.buffer", field()))?;
        let size = bytes.len();
        let range = usize::try_from(offset).ok().zip(offset.checked_add(length).and_then(|end| end.try_into().ok()));
        range.and_then(|(begin, end): (usize, usize)| bytes.get(begin..end)).ok_or_else(|| {
            let problem = format!("{length} bytes from byte {offset} are more than the {size} bytes of its buffer");
            self.invalid(field(), problem)
        })
    }
}

/// The bytes in a data URI after its scheme (RFC 2397): base64 of either alphabet, perhaps in lines, or
/// percent-encoded.
fn data_of(rest: &str) -> Result<Vec<u8>, String> {
    const LENIENT: GeneralPurpose = GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
    );
    let (kind, data) = rest.split_once(',').ok_or("a data URI must have a comma before its data")?;
    let decoded: Vec<u8> = percent_encoding::percent_decode_str(data).collect();
    if !kind.to_ascii_lowercase().ends_with(";base64") {
        return Ok(decoded);
    }
    let standard = |byte: u8| match byte {
        b'-' => b'+',
        b'_' => b'/',
        byte => byte,
    };
    let text: Vec<u8> = decoded.into_iter().filter(|byte| !byte.is_ascii_whitespace()).map(standard).collect();
    LENIENT.decode(text).map_err(|error| format!("no base64: {error}"))
}
