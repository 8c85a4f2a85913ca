//! Wavefront `.obj` files with their `.mtl` materials (Wavefront's Advanced Visualizer manual, appendices B1 and B2).
//!
//! Files are read as programs write them: a broken line is left out with a warning that names it, and the rest is
//! drawn.

mod geometry;
mod library;
mod mesh;
mod pictures;
mod surface;
mod text;

use super::files::{MAX_SCENE_BYTES, Resolver, file_name, file_stem, read_written};
use super::mesh_file::{PolygonDivider, far_center, place};
use catoptric_core::error::SceneError;
use catoptric_core::scene::Material;
use catoptric_core::scene::model::{MeshAsset, Model, Node};
use geometry::Geometry;
use library::MtlMaterial;
use pictures::Pictures;
use std::collections::HashMap;
use text::LineWarnings;

/// Reads an `.obj` file from memory; `name` is for messages, `resolver` finds materials and textures.
///
/// # Errors
/// [`SceneError`] when the file has no statement of an `.obj` file. Missing materials and pictures and broken lines are
/// warnings.
pub fn from_slice(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Model, SceneError> {
    let text = text::decode(bytes);
    let mut geometry = geometry::read(&text);
    if geometry.known_statements == 0 {
        return Err(SceneError::invalid(name, "file", "has no line of an .obj file, such as `v 0 0 0` or `f 1 2 3`"));
    }
    mesh::check_indices(&mut geometry);
    mesh::complete_normals(&mut geometry);
    mesh::make_linear(&mut geometry.colors);
    let mut model = Model { name: name.into(), ..Model::default() };
    let libraries = read_libraries(&geometry.libraries, resolver, &mut model.warnings);
    let mut pictures = Pictures::new(resolver);
    add_parts(&mut model, &geometry, &libraries, &mut pictures);
    model.textures = pictures.textures;
    model.warnings.append(&mut pictures.warnings);
    if geometry.curves > 0 {
        model.warnings.push(format!("{} curves and curved surfaces are not drawn", geometry.curves));
    }
    model.warnings.extend(geometry.warnings.into_warnings(file_name(name)));
    Ok(model)
}

/// The materials of all libraries; of equal names the first.
fn read_libraries(
    libraries: &[String],
    resolver: &dyn Resolver,
    warnings: &mut Vec<String>,
) -> HashMap<String, MtlMaterial> {
    let mut materials = HashMap::new();
    let mut read = Vec::new();
    for arguments in libraries {
        // Names may hold blanks, and a statement may have several.
        let whole = arguments.trim_matches('"');
        let found = read_written(resolver, whole, MAX_SCENE_BYTES).map(|bytes| vec![(whole.to_owned(), bytes)]);
        let found = found.or_else(|error| {
            let names = library_names(arguments);
            let several = names.iter().map(|name| Ok((name.clone(), read_written(resolver, name, MAX_SCENE_BYTES)?)));
            if names.len() > 1 { several.collect::<Result<_, SceneError>>() } else { Err(error) }
        });
        match found {
            Ok(files) => read.extend(files),
            Err(error) => warnings.push(format!("materials are missing: {error}")),
        }
    }
    for (file, bytes) in read {
        let mut of_lines = LineWarnings::default();
        let file = file.replace('\\', "/");
        for material in library::read(&file, &text::decode(&bytes), &mut of_lines) {
            if !material.not_drawn.is_empty() {
                let list = material.not_drawn.join(", ");
                warnings.push(format!("material `{}` is drawn without {list}", material.name));
            }
            materials.entry(material.name.clone()).or_insert(material);
        }
        warnings.extend(of_lines.into_warnings(&file));
    }
    make_visible(&mut materials, warnings);
    materials
}

/// The names in an `mtllib` statement: each ends with the extension.
fn library_names(arguments: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut name = String::new();
    for word in arguments.split_whitespace() {
        if !name.is_empty() {
            name.push(' ');
        }
        name.push_str(word);
        if word.to_ascii_lowercase().trim_end_matches('"').ends_with(".mtl") {
            names.push(std::mem::take(&mut name).trim_matches('"').to_owned());
        }
    }
    names
}

/// Some programs write the opacity of opaque materials as 0: where no material could be seen, all can.
fn make_visible(materials: &mut HashMap<String, MtlMaterial>, warnings: &mut Vec<String>) {
    if !materials.is_empty() && materials.values().all(|material| material.dissolve == Some(0.0)) {
        materials.values_mut().for_each(|material| material.dissolve = None);
        warnings.push("all materials have the opacity 0 (d, Tr) and are drawn as opaque".into());
    }
}

/// Adds nodes with meshes of all parts, and the materials that they use.
fn add_parts(
    model: &mut Model,
    geometry: &Geometry,
    libraries: &HashMap<String, MtlMaterial>,
    pictures: &mut Pictures<'_>,
) {
    let center = far_center(&geometry.positions);
    let default_name = file_stem(&model.name).to_owned();
    let mut divider = PolygonDivider::default();
    let mut materials: HashMap<&str, usize> = HashMap::new();
    let mut nodes: HashMap<&str, usize> = HashMap::new();
    for part in geometry.parts.iter().filter(|part| !part.faces.is_empty()) {
        let name = part.material.as_str();
        let material = *materials.entry(name).or_insert_with(|| {
            // A comment may follow the name.
            let source = libraries.get(name).or_else(|| libraries.get(name.split(" #").next()?.trim()));
            if source.is_none() && !libraries.is_empty() && !name.is_empty() {
                model.warnings.push(format!("material `{name}` is in no library and drawn as a white one"));
            }
            model.materials.push(match source {
                Some(source) => surface::material(source, pictures),
                None => Material { name: name.into(), ..Material::default() },
            });
            model.materials.len() - 1
        });
        let mut primitive = mesh::primitive(geometry, part, center, &mut divider);
        primitive.material = material;
        let of_material = &model.materials[material];
        if of_material.normal_map.is_some() || of_material.lobes().is_some_and(|lobes| lobes.anisotropy > 0.0) {
            crate::tangents::complete(&mut primitive, 0);
        }
        let node = *nodes.entry(part.name.as_str()).or_insert_with(|| {
            let name = if part.name.is_empty() { default_name.clone() } else { part.name.clone() };
            let mesh = Some(model.meshes.len());
            model.meshes.push(MeshAsset { name: name.clone(), primitives: Vec::new(), morph_weights: Vec::new() });
            model.nodes.push(Node { name, local: place(center), mesh, ..Node::default() });
            model.nodes.len() - 1
        });
        if let Some(mesh) = model.nodes[node].mesh {
            model.meshes[mesh].primitives.push(primitive);
        }
    }
}
