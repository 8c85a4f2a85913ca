//! The project's own scenes: `.toml` files that name glTF files, analytic reflectors, roles, blends and settings.

mod blend;
mod copies;
mod edits;
mod environment;
mod files;
mod keys;
mod light;
mod object;
mod optics;
mod places;
mod reflector;
mod solid;

use super::environment::{EnvironmentEdit, environment_from, load_environment};
use super::files::{self as disk, MAX_SCENE_BYTES, Resolver, extension};
use super::model_file::{self, LoadOptions, finished, unknown_variant};
use crate::builtin;
use crate::studio::named_environment;
use catoptric_core::error::SceneError;
use catoptric_core::math::Aabb;
use catoptric_core::scene::model::{CameraAsset, Model};
use catoptric_core::scene::roles::RoleRule;
use catoptric_core::scene::{Camera, Environment, Role};
use files::ObjectFiles;
use glam::Vec3;
use keys::{Keys, Lines, Located, Text};
use places::{direction, point};
use std::path::Path;
use std::sync::Arc;
use toml::de::DeTable;

/// A scene file as it was read; the files that it names are not.
#[derive(Clone, Debug, Default)]
pub struct SceneFile {
    /// The scene that this one changes: a file relative to this one, or `builtin:NAME`.
    pub base: Option<String>,
    /// Names of glTF files, relative to this one.
    pub gltf: Vec<String>,
    /// Name of the environment's picture, relative to this file, or of a built-in one.
    pub environment: Option<String>,
    /// The variant of materials that the glTF files are read with, and the base.
    pub variant: Option<String>,
    /// How the environment, or that of `base`, is turned and scaled.
    pub environment_edit: EnvironmentEdit,
    /// Everything that stands in the file itself: reflectors, lights, camera, roles, blends, region and settings.
    pub model: Model,
    /// Pictures and meshes of objects.
    files: ObjectFiles,
}

/// Files that are the base of each other, at most.
const MAX_BASES: u32 = 8;

/// Reads a scene file and all files that it names.
///
/// # Errors
/// [`SceneError`] when a file cannot be read or something in one is wrong; the message names the line.
pub fn load(path: &Path) -> Result<Model, SceneError> {
    load_with(path, LoadOptions::default())
}

/// The same with options, whose variant takes the place of the one that the file chooses.
pub(super) fn load_with(path: &Path, options: LoadOptions<'_>) -> Result<Model, SceneError> {
    load_nested(path, 0, options)
}

fn load_nested(path: &Path, depth: u32, options: LoadOptions<'_>) -> Result<Model, SceneError> {
    let file = parse(&path.display().to_string(), &disk::read_text(path, MAX_SCENE_BYTES)?)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let gltf =
        |name: &str, variant: Option<&str>| model_file::load(&folder.join(name), LoadOptions { variant, ..options });
    let base = |name: &str, variant: Option<&str>| match extension(Path::new(name)).as_str() {
        "toml" => load_nested(&folder.join(name), depth + 1, LoadOptions { variant, ..options }),
        _ => finished(gltf(name, variant)?),
    };
    let environment = |name: &str, warnings: &mut Vec<String>| load_environment(&folder.join(name), warnings);
    let bytes = |name: &str| disk::read(&folder.join(name), MAX_SCENE_BYTES);
    complete(file, (depth, options.variant), (&base, &gltf), &environment, &bytes)
}

/// Reads a scene file from memory; `name` is for messages, `resolver` finds the files that it names.
///
/// # Errors
/// As [`load`].
pub fn from_slice(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Model, SceneError> {
    nested_from(name, bytes, resolver, (0, None))
}

fn nested_from(
    name: &str,
    bytes: &[u8],
    resolver: &dyn Resolver,
    (depth, wanted): (u32, Option<&str>),
) -> Result<Model, SceneError> {
    let file = parse(name, disk::text(name, bytes)?)?;
    let base = |name: &str, variant: Option<&str>| {
        let folder = name.rsplit_once('/').map_or("", |(folder, _)| folder);
        let (bytes, within) = (resolver.read(name, MAX_SCENE_BYTES)?, Within { folder, resolver });
        match extension(Path::new(name)).as_str() {
            "toml" => nested_from(name, &bytes, &within, (depth + 1, variant)),
            _ => finished(model_file::from_slice(name, &bytes, &within, variant)?),
        }
    };
    let environment = |name: &str, warnings: &mut Vec<String>| {
        environment_from(name, &resolver.read(name, MAX_SCENE_BYTES)?, warnings)
    };
    let bytes = |name: &str| resolver.read(name, MAX_SCENE_BYTES);
    complete(file, (depth, wanted), (&base, &base), &environment, &bytes)
}

/// A folder among the files that another resolver finds.
struct Within<'a> {
    folder: &'a str,
    resolver: &'a dyn Resolver,
}

impl Resolver for Within<'_> {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        match self.folder {
            "" => self.resolver.read(name, limit),
            folder => self.resolver.read(&format!("{folder}/{name}"), limit),
        }
    }
}

/// Reads a model by its name relative to the scene file, with the materials of a variant.
type LoadModel<'a> = &'a dyn Fn(&str, Option<&str>) -> Result<Model, SceneError>;

/// Reads an environment by its name relative to the scene file, with warnings.
type LoadEnvironment<'a> = &'a dyn Fn(&str, &mut Vec<String>) -> Result<Environment, SceneError>;

/// The model of a scene file, with the files that it names and the variant that is wanted over the file's own.
fn complete(
    file: SceneFile,
    (depth, wanted): (u32, Option<&str>),
    (base, gltf): (LoadModel<'_>, LoadModel<'_>),
    environment: LoadEnvironment<'_>,
    bytes: &dyn Fn(&str) -> Result<Vec<u8>, SceneError>,
) -> Result<Model, SceneError> {
    let SceneFile {
        base: base_name,
        gltf: names,
        environment: light,
        variant: own,
        environment_edit,
        mut model,
        files: of_objects,
    } = file;
    let variant = wanted.or(own.as_deref());
    of_objects.add_to(&mut model, bytes, &|name| gltf(name, variant))?;
    for (index, name) in names.iter().enumerate() {
        let loaded =
            gltf(name, variant).map_err(|error| model.invalid(&format!("gltf[{index}]"), error.to_string()))?;
        super::merge::append(&mut model, loaded);
    }
    if let Some(name) = light {
        let loaded = match named_environment(&name) {
            Some(named) => Ok(named),
            None => environment(&name, &mut model.warnings),
        };
        let loaded = loaded.map_err(|error| model.invalid("environment", error.to_string()))?;
        model.environment = Some(Arc::new(loaded));
    }
    if let Some(name) = base_name {
        if depth >= MAX_BASES {
            return Err(model.invalid("base", format!("more than {MAX_BASES} files are the base of each other")));
        }
        let loaded = match name.strip_prefix("builtin:") {
            Some(spec) => builtin::parse(spec),
            None => base(&name, variant),
        };
        let loaded = loaded.map_err(|error| model.invalid("base", error.to_string()))?;
        super::merge::append(&mut model, loaded);
    }
    if !environment_edit.apply(&mut model) {
        return Err(model.invalid(environment_edit.key(), "there is no environment; name one as `environment`"));
    }
    match own {
        Some(own) if wanted.is_none() && model.variant.is_none() => {
            Err(model.invalid("variant", unknown_variant(&model, &own).to_string()))
        }
        _ => Ok(model),
    }
}

/// Reads the text of a scene file without the files that it names; `name` is for messages.
///
/// # Errors
/// [`SceneError`] when something is wrong; the message names the line and the allowed values.
pub fn parse(name: &str, text: &str) -> Result<SceneFile, SceneError> {
    let source = Text { file: name, text };
    let document = DeTable::parse(text).map_err(|error| {
        let begin = error.span().map_or(0, |span| span.start);
        source.invalid(begin, "TOML", error.message())
    })?;
    let mut keys = Keys::new(source, "", 0, document.get_ref());
    let mut scene = SceneFile { model: Model { name: name.into(), ..Model::default() }, ..SceneFile::default() };
    let lines = &mut scene.model.lines;
    if let Some(Located { begin, value }) = keys.string("base")? {
        lines.insert("base".into(), source.line(begin));
        scene.base = Some(value);
    }
    scene.gltf = read_gltf(source, &mut keys, lines)?;
    if let Some(Located { begin, value }) = keys.string("variant")? {
        lines.insert("variant".into(), source.line(begin));
        scene.variant = Some(value);
    }
    scene.environment = environment::read(source, &mut keys, lines)?;
    scene.environment_edit = environment::read_edit(source, &mut keys, lines)?;
    scene.model.cameras.extend(read_camera(source, &mut keys)?);
    for (index, table) in keys.tables("reflector")?.into_iter().enumerate() {
        reflector::read(source, table, index, &mut scene.model)?;
    }
    for (index, table) in keys.tables("object")?.into_iter().enumerate() {
        object::read(source, table, index, (&mut scene.model, &mut scene.files))?;
    }
    read_lights(source, &mut keys, &mut scene.model)?;
    scene.model.roles = read_roles(source, &mut keys, &mut scene.model.lines)?;
    scene.model.blends = blend::read_rules(source, &mut keys, &mut scene.model.lines)?;
    scene.model.moves = edits::read_moves(source, &mut keys, &mut scene.model.lines)?;
    scene.model.looks = edits::read_looks(source, &mut keys, &mut scene.model.lines)?;
    scene.model.region = read_region(source, &mut keys)?;
    read_settings(source, &mut keys, &mut scene.model)?;
    keys.finish()?;
    Ok(scene)
}

fn read_gltf(source: Text<'_>, keys: &mut Keys<'_, '_>, lines: &mut Lines) -> Result<Vec<String>, SceneError> {
    let Some((begin, value)) = keys.take("gltf") else { return Ok(Vec::new()) };
    let wrong = |begin| source.invalid(begin, "gltf", "must be a list of .glb or .gltf files, such as [\"room.glb\"]");
    let list = value.get_ref().as_array().ok_or_else(|| wrong(begin))?;
    let mut files = Vec::new();
    for entry in list.iter() {
        let file = entry.get_ref().as_str().ok_or_else(|| wrong(entry.span().start))?;
        if !["glb", "gltf"].contains(&extension(Path::new(file)).as_str()) {
            return Err(wrong(entry.span().start));
        }
        lines.insert(format!("gltf[{}]", files.len()), source.line(entry.span().start));
        files.push(file.into());
    }
    Ok(files)
}

fn read_camera(source: Text<'_>, keys: &mut Keys<'_, '_>) -> Result<Option<CameraAsset>, SceneError> {
    let Some(mut table) = keys.table("camera")? else { return Ok(None) };
    let eye = table.numbers("eye")?;
    let target = table.numbers("target")?;
    let up = table.numbers("up")?;
    let fov_deg = table.number("fov_deg")?;
    let missing = |key: &str| table.missing(key, "missing; a camera needs `eye` and `target`");
    let eye = eye.ok_or_else(|| missing("eye"))?;
    let target = target.ok_or_else(|| missing("target"))?;
    let fov_deg = match fov_deg {
        Some(Located { begin, value }) if !(0.01..=179.0).contains(&value) => {
            return Err(source.invalid(begin, "camera.fov_deg", format!("{value}; allowed is 0.01 to 179 degrees")));
        }
        Some(fov) => fov.value as f32,
        None => 40.0,
    };
    let (eye_point, target_point) = (point(source, "camera.eye", eye)?, point(source, "camera.target", target)?);
    if eye_point == target_point {
        return Err(source.invalid(target.begin, "camera.target", "is where the eye is"));
    }
    let up = match up {
        Some(up) => direction(source, "camera.up", up)?,
        None => Vec3::Y,
    };
    table.finish()?;
    let camera = Camera::look_at("camera", eye_point, target_point, up, fov_deg);
    Ok(Some(CameraAsset {
        other_name: String::new(),
        name: camera.name,
        node: None,
        placement: camera.world_from_camera,
        projection: camera.projection,
    }))
}

fn read_lights(source: Text<'_>, keys: &mut Keys<'_, '_>, model: &mut Model) -> Result<(), SceneError> {
    for table in keys.tables("light")? {
        model.nodes.push(light::read(source, table)?);
    }
    Ok(())
}

fn read_roles(source: Text<'_>, keys: &mut Keys<'_, '_>, lines: &mut Lines) -> Result<Vec<RoleRule>, SceneError> {
    let Some(table) = keys.table("role")? else { return Ok(Vec::new()) };
    let mut rules = Vec::new();
    for (pattern, begin, value) in table.rest() {
        let field = format!("role.{pattern}");
        lines.insert(field.clone(), source.line(begin));
        let role = match value.get_ref().as_str() {
            Some("reflector") => Role::Reflector,
            Some("lens") => Role::Lens,
            Some("diffuse") => Role::Diffuse,
            _ => return Err(source.invalid(begin, &field, "must be \"reflector\", \"lens\" or \"diffuse\"")),
        };
        let rule = RoleRule::new(&pattern, role, None);
        rules.push(rule.map_err(|error| source.invalid(begin, &field, error.to_string()))?);
    }
    Ok(rules)
}

fn read_region(source: Text<'_>, keys: &mut Keys<'_, '_>) -> Result<Option<Aabb>, SceneError> {
    let Some(mut table) = keys.table("region")? else { return Ok(None) };
    let (min, max) = (table.numbers("min")?, table.numbers("max")?);
    let missing = |key: &str| table.missing(key, "missing; a region needs `min` and `max`");
    let min = min.ok_or_else(|| missing("min"))?;
    let max = max.ok_or_else(|| missing("max"))?;
    let region = Aabb { min: point(source, "region.min", min)?, max: point(source, "region.max", max)? };
    if !region.min.cmplt(region.max).all() {
        return Err(source.invalid(max.begin, "region.max", "must be greater than `min` in all three numbers"));
    }
    table.finish()?;
    Ok(Some(region))
}

/// The settings of methods; their content is checked by the methods.
fn read_settings(source: Text<'_>, keys: &mut Keys<'_, '_>, model: &mut Model) -> Result<(), SceneError> {
    let Some(table) = keys.table("method")? else { return Ok(()) };
    for (method, begin, value) in table.rest() {
        let field = format!("method.{method}");
        let Some(entries) = value.get_ref().as_table() else {
            return Err(source.invalid(begin, &field, format!("must be a table: [{field}]")));
        };
        let line = |begin| source.line(begin);
        model.lines.extend(entries.keys().map(|key| (format!("{field}.{}", key.get_ref()), line(key.span().start))));
        model.lines.insert(field.clone(), line(begin));
        // Read again as a plain table: the methods have no use for places in the text.
        let plain: toml::Table = source.text.parse().map_err(|error: toml::de::Error| {
            source.invalid(error.span().map_or(begin, |span| span.start), &field, error.message())
        })?;
        let settings = plain.get("method").and_then(|methods| methods.get(&method)).and_then(toml::Value::as_table);
        model.method_settings.insert(method, settings.cloned().unwrap_or_default());
    }
    Ok(())
}
