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
pub mod obj;
mod picture;
pub mod toml_scene;

use environment::environment_from;
pub use environment::{EnvironmentEdit, load_environment};
use files::extension;
pub use files::{Folder, NoFiles, Resolver};

use catoptric_core::error::SceneError;
use catoptric_core::scene::Model;
use std::path::Path;

/// Kinds of scenes, for messages.
const KINDS: &str = ".glb, .gltf, .obj, .ply, .stl and .toml";

/// Reads a scene, by its extension: `.glb`, `.gltf`, `.obj`, `.ply`, `.stl` or `.toml`.
///
/// # Errors
/// [`SceneError`] when the file or one that it names cannot be read, is broken, or needs something unknown.
pub fn load(path: &Path) -> Result<Model, SceneError> {
    load_with(path, LoadOptions::default())
}

/// How a scene is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoadOptions<'a> {
    /// The variant of materials (KHR_materials_variants), over one that a scene file chooses.
    pub variant: Option<&'a str>,
    /// Files that a glTF or OBJ file names may lie anywhere: else in its folder, in the one that holds it, and below.
    pub allow_outside: bool,
}

/// The same with options.
///
/// # Errors
/// As [`load`]; also [`SceneError::Unknown`] when no file of the scene has the variant.
pub fn load_with(path: &Path, options: LoadOptions<'_>) -> Result<Model, SceneError> {
    let model = finished(match extension(path).as_str() {
        "toml" => toml_scene::load_with(path, options),
        _ => load_as_it_stands(path, options),
    }?)?;
    match options.variant {
        Some(wanted) if model.variant.is_none() => Err(unknown_variant(&model, wanted)),
        _ => Ok(model),
    }
}

/// The error about a variant that a model does not have.
fn unknown_variant(model: &Model, wanted: &str) -> SceneError {
    let listed = match model.variants.is_empty() {
        true => "none in this scene".into(),
        false => model.variants.join(", "),
    };
    SceneError::unknown("variant", wanted, model.variants.iter().map(String::as_str), listed)
}

/// The same of a file that is no `.toml` scene, wherever it lies.
fn load_as_it_stands(path: &Path, options: LoadOptions<'_>) -> Result<Model, SceneError> {
    let name = path.display().to_string();
    check_kind(&name)?;
    let bytes = files::read(path, files::MAX_SCENE_BYTES)?;
    let folder = if options.allow_outside { Folder::and_outside(path) } else { Folder::of(path) };
    parse(&name, &bytes, &folder, options.variant)
}

/// Reads a scene from memory, by the extension of its name; `resolver` finds the files that it names.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Model, SceneError> {
    finished(parse(name, bytes, resolver, None)?)
}

fn parse(name: &str, bytes: &[u8], resolver: &dyn Resolver, variant: Option<&str>) -> Result<Model, SceneError> {
    check_kind(name)?;
    files::refuse_foreign(name, bytes)?;
    match extension(Path::new(name)).as_str() {
        "obj" => obj::from_slice(name, bytes, resolver),
        "ply" => mesh_file::ply::from_slice(name, bytes),
        "stl" => mesh_file::stl::from_slice(name, bytes),
        "toml" => toml_scene::from_slice(name, bytes, resolver),
        _ => gltf_from(name, bytes, resolver, variant),
    }
}

/// The model, whose scenes lie near their origin, with a warning if there is nothing in it.
fn finished(mut model: Model) -> Result<Model, SceneError> {
    model.move_near_origin()?;
    let has_triangles = model.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|part| !part.triangles.is_empty());
    if !(has_triangles || model.nodes.iter().any(|node| node.analytic.is_some())) {
        model.warnings.push("there is nothing to draw: no surface is in the file".into());
    }
    Ok(model)
}

/// Refuses names of other kinds of files, before anything is read.
fn check_kind(name: &str) -> Result<(), SceneError> {
    let extension = extension(Path::new(name));
    let remedy = match extension.as_str() {
        "glb" | "gltf" | "obj" | "ply" | "stl" | "toml" => return Ok(()),
        "fbx" | "blend" | "dae" | "3ds" | "max" | "usd" | "usda" | "usdc" | "usdz" | "abc" | "step" | "stp"
        | "iges" => "; export glTF (.glb) from the program that made it",
        "zip" | "7z" | "rar" | "gz" => "; unpack it first",
        _ => "",
    };
    let problem = match extension.as_str() {
        "" if Path::new(name).is_dir() => "is a folder: name a file in it".into(),
        "" => format!("is missing; allowed are {KINDS}"),
        extension => format!("`.{extension}` is no kind of scene; allowed are {KINDS}{remedy}"),
    };
    Err(SceneError::invalid(name, "extension", problem))
}

#[cfg(feature = "gltf")]
use gltf::from_slice_as as gltf_from;

#[cfg(not(feature = "gltf"))]
fn gltf_from(name: &str, _: &[u8], _: &dyn Resolver, _: Option<&str>) -> Result<Model, SceneError> {
    Err(SceneError::Unsupported {
        file: name.into(),
        feature: "glTF".into(),
        remedy: "this program was built without the feature `gltf`".into(),
    })
}
