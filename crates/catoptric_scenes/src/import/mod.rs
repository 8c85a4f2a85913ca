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
mod merge;
pub mod obj;
mod picture;
pub mod toml_scene;

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
    match extension(path).as_str() {
        "glb" | "gltf" => load_gltf(path),
        "obj" => obj::load(path),
        "toml" => toml_scene::load(path),
        other => {
            let problem = format!("`.{other}` is no kind of scene; allowed are .glb, .gltf, .obj and .toml");
            Err(SceneError::invalid(path.display().to_string(), "extension", problem))
        }
    }
}

/// The extension in lower case; empty without one.
fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

#[cfg(feature = "gltf")]
fn load_gltf(path: &Path) -> Result<Model, SceneError> {
    let bytes = files::read(path, files::MAX_SCENE_BYTES)?;
    gltf::from_slice(&path.display().to_string(), &bytes, &Folder::of(path))
}

#[cfg(not(feature = "gltf"))]
fn load_gltf(path: &Path) -> Result<Model, SceneError> {
    Err(SceneError::Unsupported {
        file: path.display().to_string(),
        feature: "glTF".into(),
        remedy: "this program was built without the feature `gltf`".into(),
    })
}

/// The last part of a name or path, for messages and as the name of objects without one.
fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}
