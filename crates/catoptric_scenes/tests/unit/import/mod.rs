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
