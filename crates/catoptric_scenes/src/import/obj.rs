//! Wavefront `.obj` files with their `.mtl` materials: all diffuse.

use super::files::{self, Folder, MAX_SCENE_BYTES, Resolver};
use super::picture::{self, TexelBudget};
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::{LocalTransform, MeshAsset, Model, Node, Primitive};
use catoptric_core::scene::{Material, Sampler, Texture, TextureBinding};
use glam::{Affine2, DQuat, DVec3, Vec2, Vec3};
use std::borrow::Cow;
use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

/// Vertices are far from an origin that is so many times their extent away.
const FAR: f64 = 32.0;

/// Reads an `.obj` file, its materials and their textures.
///
/// # Errors
/// [`SceneError`] when the file cannot be read or is broken, or a texture that it uses is. A missing `.mtl` is a
/// warning.
pub fn load(path: &Path) -> Result<Model, SceneError> {
    let bytes = files::read(path, MAX_SCENE_BYTES)?;
    from_slice(&path.display().to_string(), &bytes, &Folder::of(path))
}

/// Reads an `.obj` file from memory; `name` is for messages, `resolver` finds materials and textures.
///
/// # Errors
/// [`SceneError`] when the file is broken or a texture that it uses cannot be read.
pub fn from_slice(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Model, SceneError> {
    let warnings = RefCell::new(Vec::new());
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let load_materials = |file: &Path| {
        let file = file.to_string_lossy().replace('\\', "/");
        match resolver.read(&file, MAX_SCENE_BYTES) {
            Ok(bytes) => tobj::load_mtl_buf(&mut bytes.as_slice()),
            Err(error) => {
                warnings.borrow_mut().push(format!("materials are missing: {error}"));
                Ok(Default::default())
            }
        }
    };
    check_lines(name, bytes)?;
    let (bytes, center) = about_center(bytes);
    let invalid = |error: tobj::LoadError| SceneError::invalid(name, "geometry", error.to_string());
    let (parts, materials) = tobj::load_obj_buf(&mut &bytes[..], &options, load_materials).map_err(invalid)?;
    let materials = materials.or_else(|error| {
        warnings.borrow_mut().push(format!("materials cannot be read: {error}"));
        Ok(Vec::new())
    })?;
    let mut model = Model { name: name.into(), warnings: warnings.into_inner(), ..Model::default() };
    let mut textures = Textures { name, resolver, budget: TexelBudget::default(), names: Vec::new() };
    for material in &materials {
        let material = read_material(material, &mut textures, &mut model)?;
        model.materials.push(material);
    }
    model.materials.push(Material::default());
    for part in parts {
        add_part(&mut model, part, center);
    }
    Ok(model)
}

/// The library that reads the file reports faults without their lines; the commonest get their line here.
fn check_lines(name: &str, bytes: &[u8]) -> Result<(), SceneError> {
    for (number, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let field = || format!("line {}", number + 1);
        let Ok(line) = std::str::from_utf8(line) else {
            return Err(SceneError::invalid(name, field(), "is no UTF-8 text"));
        };
        let mut words = line.split_whitespace();
        let needed = match words.next() {
            Some("v" | "vn") => 3,
            Some("vt") => 1,
            _ => continue,
        };
        let numbers: Vec<&str> = words.collect();
        let wrong = numbers.iter().find(|word| word.parse::<f32>().is_err());
        if let Some(word) = wrong.filter(|word| !word.starts_with('#')) {
            return Err(SceneError::invalid(name, field(), format!("`{word}` is no number")));
        }
        if numbers.len() < needed {
            let problem = format!("{} numbers, at least {needed} are needed", numbers.len());
            return Err(SceneError::invalid(name, field(), problem));
        }
    }
    Ok(())
}

/// The same file with its vertices about their middle, and where that is, if it is far away: the library that reads the
/// file rounds numbers to single precision.
fn about_center(bytes: &[u8]) -> (Cow<'_, [u8]>, DVec3) {
    let vertex = |line: &str| {
        let mut words = line.split_whitespace();
        let is_vertex = words.next() == Some("v");
        let mut number = || words.next().filter(|_| is_vertex)?.parse::<f64>().ok();
        let position = DVec3::new(number()?, number()?, number()?);
        position.is_finite().then(|| (position, words.collect::<Vec<&str>>().join(" ")))
    };
    let Ok(text) = std::str::from_utf8(bytes) else { return (bytes.into(), DVec3::ZERO) };
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (position, _) in text.lines().filter_map(vertex) {
        (low, high) = (low.min(position), high.max(position));
    }
    let (center, size) = (((low + high) * 0.5).round(), (high - low).length());
    if !(size > 0.0 && size.is_finite() && center.abs().max_element() > FAR * size) {
        return (bytes.into(), DVec3::ZERO);
    }
    let mut moved = String::with_capacity(text.len());
    for line in text.lines() {
        match vertex(line) {
            Some((position, rest)) => {
                let [x, y, z] = (position - center).to_array();
                moved.push_str(&format!("v {x} {y} {z} {rest}"));
            }
            None => moved.push_str(line),
        }
        moved.push('\n');
    }
    (moved.into_bytes().into(), center)
}

fn add_part(model: &mut Model, part: tobj::Model, center: DVec3) {
    let mesh = part.mesh;
    let triples = |numbers: &[f32]| numbers.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    let positions = triples(&mesh.positions);
    let count = positions.len();
    let complete = |length: usize| length == count;
    let normals = Some(triples(&mesh.normals)).filter(|normals| complete(normals.len())).unwrap_or_default();
    // The origin of .obj texture coordinates is the lower left corner.
    let uvs: Vec<Vec2> = mesh.texcoords.chunks_exact(2).map(|uv| Vec2::new(uv[0], 1.0 - uv[1])).collect();
    let uvs = Some(uvs).filter(|uvs| complete(uvs.len())).unwrap_or_default();
    let colors: Vec<[f32; 4]> = mesh.vertex_color.chunks_exact(3).map(|c| [c[0], c[1], c[2], 1.0]).collect();
    let colors = Some(colors).filter(|colors| complete(colors.len())).unwrap_or_default();
    let triangles: Vec<[u32; 3]> = mesh
        .indices
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .filter(|triangle| triangle.iter().all(|index| (*index as usize) < count))
        .collect();
    if triangles.is_empty() {
        return;
    }
    let default_material = model.materials.len() - 1;
    let primitive = Primitive {
        positions,
        normals,
        uvs: [uvs, Vec::new()],
        colors,
        triangles,
        material: mesh.material_id.filter(|id| *id < default_material).unwrap_or(default_material),
        ..Primitive::default()
    };
    let local = match center {
        DVec3::ZERO => LocalTransform::default(),
        translation => LocalTransform::Rigid { translation, rotation: DQuat::IDENTITY },
    };
    model.nodes.push(Node { name: part.name.clone(), local, mesh: Some(model.meshes.len()), ..Node::default() });
    model.meshes.push(MeshAsset { name: part.name, primitives: vec![primitive], morph_weights: Vec::new() });
}

struct Textures<'a> {
    name: &'a str,
    resolver: &'a dyn Resolver,
    budget: TexelBudget,
    /// The files of the model's textures, in order.
    names: Vec<String>,
}

fn read_material(
    source: &tobj::Material,
    textures: &mut Textures<'_>,
    model: &mut Model,
) -> Result<Material, SceneError> {
    let color = |color: Option<[f32; 3]>, default: f32| {
        color.unwrap_or([default; 3]).map(|c| if c.is_finite() { c.clamp(0.0, 1e6) } else { default })
    };
    let mut material = Material::diffuse(&source.name, Vec3::from(color(source.diffuse, 1.0)));
    material.emissive = Vec3::from(color(source.emissive, 0.0));
    if let Some(file) = source.diffuse_texture.as_deref().and_then(picture_file) {
        let texture = textures.index(&file, model)?;
        material.base_texture = Some(TextureBinding { texture, uv_channel: 0, texture_from_uv: Affine2::IDENTITY });
    }
    Ok(material)
}

/// The file in a `map_Kd` line; options such as `-s 1 1 1` stand before it.
fn picture_file(text: &str) -> Option<String> {
    let text = text.trim();
    let name = if text.starts_with('-') { text.rsplit(char::is_whitespace).next()? } else { text };
    (!name.is_empty()).then(|| name.replace('\\', "/"))
}

impl Textures<'_> {
    fn index(&mut self, file: &str, model: &mut Model) -> Result<u32, SceneError> {
        if let Some(index) = self.names.iter().position(|name| name == file) {
            return Ok(index as u32);
        }
        let bytes = self.resolver.read(file, MAX_SCENE_BYTES)?;
        let invalid = |problem: String| SceneError::invalid(self.name, format!("map_Kd {file}"), problem);
        let size = picture::dimensions(&bytes).map_err(invalid)?;
        self.budget.admit(size, bytes.len()).map_err(invalid)?;
        let picture = picture::decode(&bytes).map_err(invalid)?;
        let texture = Texture::from_srgb8(file, picture.width, picture.height, &picture.texels, Sampler::default());
        model.textures.push(Arc::new(texture));
        self.names.push(file.into());
        Ok(self.names.len() as u32 - 1)
    }
}
