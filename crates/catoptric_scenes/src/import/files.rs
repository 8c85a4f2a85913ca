//! Reading files that a user or a scene names, with a limit on their size.

use catoptric_core::error::SceneError;
use catoptric_core::input::read_file;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use unicode_normalization::UnicodeNormalization;

/// The largest scene, buffer or picture file that is read.
pub(super) const MAX_SCENE_BYTES: u64 = 2 << 30;

/// Finds the files that a scene names, such as buffers and pictures.
pub trait Resolver: Sync {
    /// The bytes of a file by its name relative to the scene; a file of more than `limit` bytes is an error.
    ///
    /// # Errors
    /// [`SceneError`] when there is no such file or it is too large.
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError>;
}

/// Finds files relative to a folder: in it, in the one that holds it, and below.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    allow_outside: bool,
}

impl Folder {
    /// The folder in which a file lies.
    pub fn of(file: &Path) -> Self {
        Self { path: file.parent().map(Path::to_path_buf).unwrap_or_default(), allow_outside: false }
    }

    /// The same, from which names may lead anywhere.
    pub fn and_outside(file: &Path) -> Self {
        Self { allow_outside: true, ..Self::of(file) }
    }
}

/// Returns true if a name leads further than to the folder that holds the one where it begins.
fn leads_outside(name: &str) -> bool {
    let mut depth = 0i32;
    name.split('/').filter(|part| !matches!(*part, "" | ".")).any(|part| {
        depth += if part == ".." { -1 } else { 1 };
        depth < -1
    })
}

impl Resolver for Folder {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        let path = self.path.join(name);
        if Path::new(name).is_absolute() {
            let problem = format!("names the absolute path `{name}`; write it relative to the scene");
            return Err(SceneError::invalid(path.display().to_string(), "path", problem));
        }
        if !self.allow_outside && leads_outside(name) {
            let problem = "lies outside the folder that holds the scene's: move it, or allow it by --allow-outside";
            return Err(SceneError::invalid(path.display().to_string(), "path", problem));
        }
        match path.try_exists() {
            Ok(false) => read(&self.alike(name).unwrap_or(path), limit),
            _ => read(&path, limit),
        }
    }
}

impl Folder {
    /// The file whose name differs in the case of letters or in the Unicode form of accents alone, as other systems
    /// take them for one; of several the first by the bytes of its name.
    fn alike(&self, name: &str) -> Option<PathBuf> {
        let mut path = self.path.clone();
        for part in name.split('/').filter(|part| !matches!(*part, "" | ".")) {
            if part == ".." || path.join(part).exists() {
                path.push(part);
                continue;
            }
            let folder = if path.as_os_str().is_empty() { Path::new(".") } else { &path };
            let names = folder.read_dir().ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
            let found = names.filter(|name| folded(name) == folded(part)).min()?;
            path.push(found);
        }
        Some(path)
    }
}

/// A name with composed accents and small letters.
fn folded(name: &str) -> String {
    name.nfc().flat_map(char::to_lowercase).collect()
}

/// The bytes of a file whose name another system may have written: as it stands, with slashes for backslashes, without
/// what follows a question mark or number sign, and at last by its last part, beside the scene.
pub(super) fn read_written(resolver: &dyn Resolver, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
    let mut tried: Vec<String> = Vec::new();
    // The first, but rather why a file may not be opened than that there is none.
    let mut kept_error: Option<SceneError> = None;
    let slashed = name.replace('\\', "/");
    let bare = slashed.split(['?', '#']).next().unwrap_or_default().to_owned();
    let last = |name: &str| name.rsplit('/').next().unwrap_or_default().to_owned();
    for candidate in [name.to_owned(), slashed.clone(), bare.clone(), last(&slashed), last(&bare)] {
        if candidate.is_empty() || tried.contains(&candidate) {
            continue;
        }
        match resolver.read(&candidate, limit) {
            Ok(bytes) => return Ok(bytes),
            Err(error) => {
                let is_better =
                    matches!((&kept_error, &error), (Some(SceneError::Read { .. }), SceneError::Invalid { .. }));
                kept_error = if is_better { Some(error) } else { kept_error.or(Some(error)) };
            }
        }
        tried.push(candidate);
    }
    Err(kept_error.unwrap_or_else(|| SceneError::invalid(name, "path", "is empty")))
}

/// For scenes that must stand alone: every other file is missing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Resolver for NoFiles {
    fn read(&self, name: &str, _limit: u64) -> Result<Vec<u8>, SceneError> {
        Err(SceneError::invalid(name, "path", "other files cannot be read here; embed them in the scene"))
    }
}

/// All bytes of a plain file of at most `limit` bytes.
pub(super) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, SceneError> {
    read_file(path, limit).map_err(|error| match error.kind() {
        ErrorKind::IsADirectory | ErrorKind::InvalidInput | ErrorKind::FileTooLarge => {
            SceneError::invalid(path.display().to_string(), "file", error.to_string())
        }
        _ => SceneError::Read { path: path.to_path_buf(), source: error },
    })
}

/// The text of a plain file of at most `limit` bytes.
pub(super) fn read_text(path: &Path, limit: u64) -> Result<String, SceneError> {
    let bytes = read(path, limit)?;
    text(&path.display().to_string(), &bytes).map(str::to_owned)
}

/// The text that a file's bytes are; `name` is for messages.
pub(super) fn text<'a>(name: &str, bytes: &'a [u8]) -> Result<&'a str, SceneError> {
    std::str::from_utf8(bytes)
        .map_err(|error| SceneError::invalid(name, "file", format!("byte {} is no UTF-8 text", error.valid_up_to())))
}

/// Beginnings of files of other kinds than those that are read, with their names and, after a colon, the remedy.
const FOREIGN: [(&[u8], &str); 18] = [
    (b"version https://git-lfs", "a pointer of Git LFS in place of the file: `git lfs pull` brings it"),
    (b"PK\x03\x04", "a ZIP archive (or USDZ): unpack it, or export glTF"),
    (b"\x1f\x8b", "a gzip archive: unpack it"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive: unpack it"),
    (b"Rar!", "a RAR archive: unpack it"),
    (b"Kaydara FBX", "an FBX file: export glTF from the program that made it"),
    (b"; FBX", "an FBX file: export glTF from the program that made it"),
    (b"BLENDER", "a file of Blender: export glTF there"),
    (b"#usda", "a USD file: export glTF from the program that made it"),
    (b"PXR-USDC", "a USD file: export glTF from the program that made it"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard archive, perhaps of Blender: unpack it"),
    (b"\xff\xfe", "text in UTF-16: save it as UTF-8"),
    (b"\xfe\xff", "text in UTF-16: save it as UTF-8"),
    (b"GIF8", "a GIF picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"8BPS", "a Photoshop picture"),
    (b"DDS ", "a DDS picture"),
];

/// The kind of a file by its beginning, with a remedy where there is one.
pub(super) fn kind_of(bytes: &[u8]) -> &'static str {
    if bytes.is_empty() {
        return "an empty file";
    }
    if let Some((_, kind)) = FOREIGN.iter().find(|(beginning, _)| bytes.starts_with(beginning)) {
        return kind;
    }
    let text = bytes.trim_ascii_start();
    let has_tag = |tag: &[u8]| text.get(..tag.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(tag));
    match bytes.get(4..12) {
        _ if has_tag(b"<!doctype html") || has_tag(b"<html") => "a web page: download the file itself",
        _ if has_tag(b"<svg") => "an SVG picture",
        Some(b"ftypavif" | b"ftypheic") => "an AVIF or HEIC picture",
        _ => "a file of another kind",
    }
}

/// Refuses scene files that are evidently of another kind, and names it.
pub(super) fn refuse_foreign(name: &str, bytes: &[u8]) -> Result<(), SceneError> {
    match kind_of(bytes) {
        "a file of another kind" => Ok(()),
        kind => Err(SceneError::invalid(name, "file", format!("is {kind}"))),
    }
}

/// The extension in lower case; empty without one.
pub(super) fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// The last part of a name or path, for messages and as the name of objects without one.
pub(super) fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// The same without its extension.
pub(super) fn file_stem(name: &str) -> &str {
    let file = file_name(name);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}
