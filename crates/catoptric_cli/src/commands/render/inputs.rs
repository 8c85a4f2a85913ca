//! The files that a picture is made of, found by the names in them.

use crate::args::{DrawArgs, RenderArgs, SceneArgs};
use crate::failure::Failure;
use catoptric::output;
use catoptric_scenes::ENVIRONMENT_NAMES;
use percent_encoding::percent_decode_str;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The most files of a scene.
const MAX_FILES: usize = 1000;
/// Names of files are looked for in so many bytes of each file.
const MAX_BYTES: u64 = 256 << 20;
/// The longest name of a file.
const MAX_NAME: usize = 1024;
/// The kinds of files that scenes name.
const KINDS: [&str; 17] = [
    "glb", "gltf", "bin", "obj", "mtl", "ply", "stl", "toml", "hdr", "exr", "png", "jpg", "jpeg", "webp", "tga", "bmp",
    "ktx2",
];

/// The time of a file's last change and its size; none where there is no such file.
pub(super) type Stamp = Option<(SystemTime, u64)>;

/// The files that options name: of the scene, its environment, its bakes, and of methods' settings.
pub(in crate::commands) fn named<'a>(
    scene: &SceneArgs,
    draw: &DrawArgs,
    settings: impl Iterator<Item = &'a str>,
) -> Vec<PathBuf> {
    let environment = scene.environment.environment.iter();
    let is_file = |path: &&PathBuf| !ENVIRONMENT_NAMES.iter().any(|name| path.as_os_str() == *name);
    let mut named = vec![scene.scene.clone()];
    named.extend(environment.filter(is_file).chain(&draw.baked).cloned());
    named.extend(settings.map(PathBuf::from));
    named
}

/// The same of a picture.
pub(super) fn of_render(args: &RenderArgs) -> Vec<PathBuf> {
    let variant = args.method.split([':', ',']).filter_map(|part| part.split_once('='));
    let values = args.set.iter().map(|(_, value)| value.as_str()).chain(variant.map(|(_, value)| value));
    named(&args.scene, &args.draw, values)
}

/// Refuses outputs that are these inputs, or files that they name.
pub(in crate::commands) fn refuse_inputs<'a>(
    outputs: impl Iterator<Item = &'a Path>,
    inputs: Vec<PathBuf>,
) -> Result<(), Failure> {
    let there: Vec<&Path> = outputs.filter(|path| path.is_file()).collect();
    if there.is_empty() {
        return Ok(());
    }
    let inputs = files_of(inputs);
    for output in there {
        if inputs.keys().any(|input| output::is_same_file(input, output)) {
            let problem = "is a file that is read, too; write to another name";
            return Err(Failure::usage(format!("{}: {problem}", output.display())));
        }
    }
    Ok(())
}

/// Files and those that they name, whether these are there or not. Each is looked at before it is read: changes in the
/// meantime are not missed.
pub(in crate::commands) fn files_of(mut open: Vec<PathBuf>) -> BTreeMap<PathBuf, Stamp> {
    let mut found = BTreeMap::new();
    while let Some(path) = open.pop() {
        if found.len() < MAX_FILES && !found.contains_key(&path) {
            found.insert(path.clone(), stamp_of(&path));
            let folder = path.parent().unwrap_or(Path::new(""));
            open.extend(names_in(&path).into_iter().map(|name| folder.join(name)));
        }
    }
    found
}

pub(super) fn stamp_of(path: &Path) -> Stamp {
    let about = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    Some((about.modified().ok()?, about.len()))
}

/// The words of a scene's file that look like names of files, whether these are there or not.
fn names_in(path: &Path) -> Vec<String> {
    let kind = kind_of(&path.to_string_lossy());
    let text = match kind.as_str() {
        "toml" | "gltf" | "obj" | "mtl" => text_of(path, 0, MAX_BYTES),
        "glb" => json_length(path).and_then(|length| text_of(path, 20, length.into())),
        _ => None,
    };
    let Some(text) = text else { return Vec::new() };
    let is_name = |word: &&str| word.len() <= MAX_NAME && KINDS.contains(&kind_of(word).as_str());
    match kind.as_str() {
        "obj" | "mtl" => {
            let rests = text.lines().filter_map(|line| line.trim().split_once(char::is_whitespace));
            // Names may have blanks, and options before them.
            let words =
                rests.flat_map(|(_, rest)| [rest.trim(), rest.rsplit(char::is_whitespace).next().unwrap_or("")]);
            words.filter(is_name).map(|name| name.replace('\\', "/")).collect()
        }
        _ => {
            let words = text.split(['"', '\'']).filter(is_name);
            words
                .flat_map(|word| [word.to_owned(), percent_decode_str(word).decode_utf8_lossy().into_owned()])
                .collect()
        }
    }
}

/// The extension of a name in lower case; empty without one.
fn kind_of(name: &str) -> String {
    Path::new(name).extension().map(|kind| kind.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// The text of a plain file from a byte on.
fn text_of(path: &Path, begin: u64, length: u64) -> Option<String> {
    stamp_of(path)?;
    let mut bytes = Vec::new();
    File::open(path).ok()?.take(begin.saturating_add(length).min(MAX_BYTES)).read_to_end(&mut bytes).ok()?;
    Some(String::from_utf8_lossy(bytes.get(usize::try_from(begin).ok()?..)?).into_owned())
}

/// The length of the JSON chunk of a GLB file.
fn json_length(path: &Path) -> Option<u32> {
    let mut header = [0; 20];
    File::open(path).ok()?.read_exact(&mut header).ok()?;
    Some(u32::from_le_bytes([header[12], header[13], header[14], header[15]]))
}
