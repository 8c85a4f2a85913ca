//! Importers: small files that are put together here, in memory or in a folder of their own.

mod analytic;
mod blend;
mod environment;
#[cfg(feature = "gltf")]
mod gltf;
#[cfg(feature = "gltf")]
mod merge;
mod mesh_file;
mod obj;
mod toml_scene;

use catoptric_core::math::random::Stream;
use catoptric_core::scene::Model;
use catoptric_scenes::import::toml_scene::parse;

/// The model of a `.toml` scene, or the message about its fault.
fn toml_model(text: &str) -> Result<Model, String> {
    parse("scene.toml", text).map(|scene| scene.model).map_err(|error| error.to_string())
}

/// The model of a reflector of a kind at the origin, with these lines.
fn reflector(kind: &str, lines: &str) -> Result<Model, String> {
    toml_model(&format!("[[reflector]]\nname = \"{kind}\"\nsurface = \"{kind}\"\ncenter = [0, 0, 0]\n{lines}\n"))
}

/// The key of a reflector that the message about its fault names.
#[track_caller]
fn wrong_key(found: Result<Model, String>) -> String {
    let message = found.unwrap_err();
    let (_, field) = message.split_once(": reflector.").unwrap_or_else(|| panic!("{message}"));
    field.split(": ").next().unwrap_or_default().to_owned()
}

/// A file of which a few bytes are changed, lost or doubled, others for each number; texts get letters of texts.
fn mutated(sample: &[u8], number: u64) -> Vec<u8> {
    const LETTERS: &[u8] = b"0123456789-/\\\n e.#";
    let mut random = Stream::new(number);
    let mut below = |limit: usize| (random.next_unit() * limit as f32) as usize;
    let mut bytes = sample.to_vec();
    for _ in 0..1 + below(4) {
        let place = below(bytes.len());
        match below(4) {
            0 => bytes[place] = below(256) as u8,
            1 => bytes[place] = LETTERS[below(LETTERS.len())],
            2 => drop(bytes.drain(place..(place + 1 + below(6)).min(bytes.len()))),
            _ => bytes.extend_from_within(place..),
        }
        if bytes.is_empty() {
            bytes.push(b' ');
        }
    }
    bytes
}
