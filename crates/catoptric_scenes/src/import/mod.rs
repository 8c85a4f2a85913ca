//! Reads scenes from files: glTF 2.0 and GLB, Wavefront `.obj`, meshes in `.ply` and `.stl`, and the project's own
//! `.toml` scenes.
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
mod lobes;
mod merge;
mod mesh_file;
mod model_file;
pub mod obj;
mod picture;
pub mod toml_scene;

pub use environment::{EnvironmentEdit, load_environment};
pub use files::{Folder, NoFiles, Resolver};
pub use model_file::LoadOptions;

use catoptric_core::error::SceneError;
use catoptric_core::scene::Model;
use files::extension;
use model_file::{finished, unknown_variant};
use std::path::Path;

/// Reads a scene, by its extension: `.glb`, `.gltf`, `.obj`, `.ply`, `.stl` or `.toml`.
///
/// # Errors
/// [`SceneError`] when the file or one that it names cannot be read, is broken, or needs something unknown.
pub fn load(path: &Path) -> Result<Model, SceneError> {
    load_with(path, LoadOptions::default())
}

/// The same with options.
///
/// # Errors
/// As [`load`]; also [`SceneError::Unknown`] when no file of the scene has the variant.
pub fn load_with(path: &Path, options: LoadOptions<'_>) -> Result<Model, SceneError> {
    let model = finished(match extension(path).as_str() {
        "toml" => toml_scene::load_with(path, options),
        _ => model_file::load(path, options),
    }?)?;
    match options.variant {
        Some(wanted) if model.variant.is_none() => Err(unknown_variant(&model, wanted)),
        _ => Ok(model),
    }
}

/// Reads a scene from memory, by the extension of its name; `resolver` finds the files that it names.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Model, SceneError> {
    finished(match extension(Path::new(name)).as_str() {
        "toml" => {
            files::refuse_foreign(name, bytes)?;
            toml_scene::from_slice(name, bytes, resolver)
        }
        _ => model_file::from_slice(name, bytes, resolver, None),
    }?)
}
