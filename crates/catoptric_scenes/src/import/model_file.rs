//! Files of one model each: glTF, OBJ, PLY and STL, all kinds but the project's own scenes, which name such files.

use super::files::{self, Folder, Resolver, extension};
#[cfg(feature = "gltf")]
use super::gltf::from_slice_as as gltf_from;
use super::{mesh_file, obj};
use catoptric_core::error::SceneError;
use catoptric_core::scene::Model;
use std::path::Path;

/// How a scene is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct LoadOptions<'a> {
    /// The variant of materials (KHR_materials_variants), over one that a scene file chooses.
    pub variant: Option<&'a str>,
    /// Files that a glTF or OBJ file names may lie anywhere: else in its folder, in the one that holds it, and below.
    pub allow_outside: bool,
}

/// The kinds of scenes that can be read, for messages.
const KINDS: &str = ".glb, .gltf, .obj, .ply, .stl and .toml";

/// Reads a model, by its extension, as it stands in its file: wherever it lies, and with nothing in it, too.
pub(super) fn load(path: &Path, options: LoadOptions<'_>) -> Result<Model, SceneError> {
    let name = path.display().to_string();
    check_kind(&name)?;
    let bytes = files::read(path, files::MAX_SCENE_BYTES)?;
    let folder = if options.allow_outside { Folder::and_outside(path) } else { Folder::of(path) };
    from_slice(&name, &bytes, &folder, options.variant)
}

/// The same from memory, by the extension of its name; `resolver` finds the files that it names.
pub(super) fn from_slice(
    name: &str,
    bytes: &[u8],
    resolver: &dyn Resolver,
    variant: Option<&str>,
) -> Result<Model, SceneError> {
    check_kind(name)?;
    files::refuse_foreign(name, bytes)?;
    match extension(Path::new(name)).as_str() {
        "obj" => obj::from_slice(name, bytes, resolver),
        "ply" => mesh_file::ply::from_slice(name, bytes),
        "stl" => mesh_file::stl::from_slice(name, bytes),
        _ => gltf_from(name, bytes, resolver, variant),
    }
}

/// The model, whose scenes lie near their origin, with a warning if there is nothing in it.
pub(super) fn finished(mut model: Model) -> Result<Model, SceneError> {
    model.move_near_origin()?;
    let has_triangles = model.meshes.iter().flat_map(|mesh| &mesh.primitives).any(|part| !part.triangles.is_empty());
    if !(has_triangles || model.nodes.iter().any(|node| node.analytic.is_some())) {
        model.warnings.push("there is nothing to draw: no surface is in the file".into());
    }
    Ok(model)
}

/// The error about a variant that a model does not have.
pub(super) fn unknown_variant(model: &Model, wanted: &str) -> SceneError {
    let listed = match model.variants.is_empty() {
        true => "none in this scene".into(),
        false => model.variants.join(", "),
    };
    SceneError::unknown("variant", wanted, model.variants.iter().map(String::as_str), listed)
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

#[cfg(not(feature = "gltf"))]
fn gltf_from(name: &str, _: &[u8], _: &dyn Resolver, _: Option<&str>) -> Result<Model, SceneError> {
    Err(SceneError::Unsupported {
        file: name.into(),
        feature: "glTF".into(),
        remedy: "this program was built without the feature `gltf`".into(),
    })
}
