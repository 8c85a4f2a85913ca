//! Reads scenes from files: glTF 2.0 and GLB, Wavefront `.obj`, and the project's own `.toml` scenes.
//!
//! Every reader treats its input as hostile: sizes that a file names are checked against the file's length
//! before memory is allocated, and every index before it is used.

mod analytic;
mod blend;
mod environment;
mod files;
#[cfg(feature = "gltf")]
pub mod gltf;
mod key_error;
mod merge;
pub mod obj;
mod picture;
pub mod toml_scene;

use environment::environment_from;
pub use environment::load_environment;
pub use files::{Folder, NoFiles, Resolver};

use catoptric_core::error::SceneError;
use catoptric_core::scene::Model;
use std::path::Path;

/// Reads a scene, by its extension: `.glb`, `.gltf`, `.obj` or `.toml`.
///
/// # Errors
/// [`SceneError`] when the file or one that it names cannot be read, is broken, or needs something unknown.
pub fn load(path: &Path) -> Result<Model, SceneError> {
    near_origin(match extension(path).as_str() {
        "glb" | "gltf" => load_gltf(path),
        "obj" => obj::load(path),
        "toml" => toml_scene::load(path),
        other => Err(no_scene(&path.display().to_string(), other)),
    }?)
}

/// The model, whose scenes lie near their origin.
fn near_origin(mut model: Model) -> Result<Model, SceneError> {
    model.move_near_origin()?;
    Ok(model)
}

/// Reads a scene from memory, by the extension of its name; `resolver` finds the files that it names.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Model, SceneError> {
    near_origin(match extension(Path::new(name)).as_str() {
        "glb" | "gltf" => gltf_from(name, bytes, resolver),
        "obj" => obj::from_slice(name, bytes, resolver),
        "toml" => toml_scene::from_slice(name, bytes, resolver),
        other => Err(no_scene(name, other)),
    }?)
}

fn no_scene(name: &str, extension: &str) -> SceneError {
    let problem = format!("`.{extension}` is no kind of scene; allowed are .glb, .gltf, .obj and .toml");
    SceneError::invalid(name, "extension", problem)
}

/// The extension in lower case; empty without one.
fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn load_gltf(path: &Path) -> Result<Model, SceneError> {
    let bytes = files::read(path, files::MAX_SCENE_BYTES)?;
    gltf_from(&path.display().to_string(), &bytes, &Folder::of(path))
}

#[cfg(feature = "gltf")]
use gltf::from_slice as gltf_from;

#[cfg(not(feature = "gltf"))]
fn gltf_from(name: &str, _: &[u8], _: &dyn Resolver) -> Result<Model, SceneError> {
    Err(SceneError::Unsupported {
        file: name.into(),
        feature: "glTF".into(),
        remedy: "this program was built without the feature `gltf`".into(),
    })
}

/// The last part of a name or path, for messages and as the name of objects without one.
fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}
