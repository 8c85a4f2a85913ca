//! glTF 2.0 and GLB.
//!
//! The JSON is read into structs of our own: the ready-made crates refuse sound files (empty scenes, textures
//! without a plain picture, channels without a node) and trust indices that broken files get wrong.

mod accessors;
mod animation;
mod check;
mod container;
mod extensions;
mod materials;
mod meshes;
mod meshopt;
mod nodes;
mod schema;
mod source;
mod textures;
mod variants;

use super::Resolver;
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::{AnalyticAsset, MeshAsset, Model};
use catoptric_core::scene::{Material, Role};
use glam::Vec3;
use source::Source;
use std::sync::Arc;
use textures::TextureSet;

/// Reads a glTF or GLB file from memory; `name` is for messages, `resolver` finds the files that it names.
///
/// # Errors
/// [`SceneError`] that names the field when the file is broken, too large, or needs an unknown extension.
pub fn from_slice(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Model, SceneError> {
    from_slice_as(name, bytes, resolver, None)
}

/// The same with the materials of the variant of this name, where the file has it.
///
/// # Errors
/// As [`from_slice`].
pub fn from_slice_as(
    name: &str,
    bytes: &[u8],
    resolver: &dyn Resolver,
    variant: Option<&str>,
) -> Result<Model, SceneError> {
    let parts = container::split(name, bytes)?;
    let mut document = schema::parse(name, parts.json)?;
    let variants = variants::names(&document);
    let chosen = variant.and_then(|wanted| variants.iter().position(|known| known == wanted));
    if let Some(index) = chosen {
        variants::choose(name, &mut document, index)?;
    }
    let source = Source::new(name, &document, bytes.len(), parts.binary, resolver);
    if !parts.is_aligned {
        source.warn("GLB container: a chunk does not fill whole words of 4 bytes");
    }
    extensions::check_required(&source)?;
    let mut model = Importer::new(&source)?.run()?;
    check::warn_of_faults(&source);
    model.warnings = source.into_warnings();
    model.variant = chosen.map(|index| variants[index].clone());
    model.variants = variants;
    Ok(model)
}

/// The colour of what has no material.
const PLASTER: f32 = 0.8;

struct Importer<'r, 's> {
    source: &'s Source<'r>,
    model: Model,
    shown: Vec<bool>,
    lights: Vec<schema::Light>,
    /// The meshes that are drawn, and whether a skin bends them.
    drawn_meshes: Vec<Option<Skinned>>,
    /// The material of primitives that name none, once there is one.
    default_material: Option<usize>,
}

#[derive(Clone, Copy, PartialEq)]
struct Skinned(bool);

impl<'r, 's> Importer<'r, 's> {
    fn new(source: &'s Source<'r>) -> Result<Self, SceneError> {
        let tree = nodes::tree(source)?;
        let extensions = &source.document.extensions;
        let lights: Option<schema::Lights> =
            schema::extension(source.name, &|| "root".into(), extensions, "KHR_lights_punctual")?;
        let model = Model { name: source.name.into(), nodes: tree.nodes, ..Model::default() };
        Ok(Self {
            source,
            model,
            shown: tree.shown,
            lights: lights.unwrap_or_default().lights,
            drawn_meshes: vec![None; source.document.meshes.len()],
            default_material: None,
        })
    }

    fn run(mut self) -> Result<Model, SceneError> {
        let document = self.source.document;
        for (index, skin) in document.skins.iter().enumerate() {
            self.model.skins.push(nodes::skin(self.source, index, skin)?);
        }
        let mut analytic = Vec::new();
        for index in 0..document.nodes.len() {
            analytic.extend(self.place(index)?);
        }
        self.read_meshes()?;
        for (index, asset) in analytic {
            self.model.nodes[index].analytic = Some(self.analytic_asset(index, &asset)?);
        }
        for (index, animation) in document.animations.iter().enumerate() {
            self.model.animations.push(animation::read(self.source, index, animation));
        }
        Ok(self.model)
    }

    /// Puts mesh, skin, camera, light and instances at a node that the scene shows. Returns its analytic surface.
    fn place(&mut self, index: usize) -> Result<Option<(usize, AnalyticPlan)>, SceneError> {
        let (source, document) = (self.source, self.source.document);
        let entry = &document.nodes[index];
        let mesh = match entry.mesh {
            Some(mesh) => {
                let field = || format!("nodes[{index}].mesh");
                Some((mesh, source.entry(&document.meshes, mesh, &field, "meshes")?))
            }
            None => None,
        };
        if !self.shown[index] {
            return Ok(None);
        }
        self.model.nodes[index].light = nodes::light(source, index, &self.lights)?;
        self.model.cameras.extend(nodes::camera(source, index));
        let of_mesh = match mesh {
            Some((mesh, mesh_entry)) => {
                let owner = format!("meshes[{mesh}]");
                nodes::surface_keys(source, &owner, &mesh_entry.extras)?.map(|keys| (owner, keys))
            }
            None => None,
        };
        let owner = format!("nodes[{index}]");
        let keys = nodes::surface_keys(source, &owner, &entry.extras)?.map(|keys| (owner, keys)).or(of_mesh);
        if let Some((owner, (surface, look))) = keys {
            if entry.extensions.contains_key("EXT_mesh_gpu_instancing") {
                source.warn(format!("nodes[{index}]: its analytic surface is placed once, without the instances"));
            }
            let primitive = mesh.and_then(|(_, mesh)| mesh.primitives.first());
            let material = primitive.and_then(|p| p.material);
            return Ok(Some((index, AnalyticPlan { owner, surface, look, material })));
        }
        let Some((mesh, _)) = mesh else { return Ok(None) };
        if let Some(instances) = nodes::instances(source, index)? {
            self.model.nodes[index].instances = instances;
        }
        self.model.nodes[index].mesh = Some(mesh);
        self.model.nodes[index].skin = entry.skin;
        let was_skinned = self.drawn_meshes[mesh] == Some(Skinned(true));
        self.drawn_meshes[mesh] = Some(Skinned(entry.skin.is_some() || was_skinned));
        Ok(None)
    }

    /// Reads the meshes that are drawn, with their materials and textures.
    fn read_meshes(&mut self) -> Result<(), SceneError> {
        let (source, document) = (self.source, self.source.document);
        let drawn = |mesh: usize| self.drawn_meshes[mesh].is_some();
        let mut used = vec![false; document.materials.len()];
        for (index, mesh) in document.meshes.iter().enumerate() {
            for (part, primitive) in mesh.primitives.iter().enumerate() {
                let Some(material) = primitive.material else { continue };
                let field = || format!("meshes[{index}].primitives[{part}].material");
                source.entry(&document.materials, material, &field, "materials")?;
                used[material] |= drawn(index);
            }
        }
        let mut textures = TextureSet::default();
        let mut materials = Vec::with_capacity(document.materials.len());
        for (index, entry) in document.materials.iter().enumerate() {
            materials.push(materials::plan(source, index, entry, used[index].then_some(&mut textures))?);
        }
        for (index, mesh) in document.meshes.iter().enumerate() {
            let mut asset =
                MeshAsset { name: mesh.name.clone(), morph_weights: mesh.weights.clone(), ..MeshAsset::default() };
            if let Some(Skinned(skinned)) = self.drawn_meshes[index] {
                for (part, primitive) in mesh.primitives.iter().enumerate() {
                    let needs = primitive.material.map(|material| materials[material].attributes()).unwrap_or_default();
                    let material = primitive.material.unwrap_or(document.materials.len());
                    if primitive.material.is_none() {
                        self.default_material = Some(material);
                    }
                    let owner = format!("meshes[{index}].primitives[{part}]");
                    let reader = meshes::PrimitiveReader::new(source, primitive, owner)?;
                    asset.primitives.extend(reader.read(needs, skinned, material)?);
                }
            }
            self.model.meshes.push(asset);
        }
        let decoded = textures.decode(source);
        self.model.materials = materials.into_iter().map(|material| material.finish(&decoded)).collect();
        if self.default_material.is_some() {
            // The format's default, a white and rough metal, sends all light on to other parts of itself: no shape is
            // seen without shades. Things without a material were grey where they were made.
            self.model.materials.push(Material::diffuse("", Vec3::splat(PLASTER)));
            let drawn = document.meshes.iter().zip(&self.drawn_meshes).filter(|(_, drawn)| drawn.is_some());
            let count = drawn.flat_map(|(mesh, _)| &mesh.primitives).filter(|part| part.material.is_none()).count();
            let parts = if count == 1 {
                "part of a mesh has no material and is"
            } else {
                "parts of meshes have no material and are"
            };
            source.warn(format!("{count} {parts} drawn as grey plaster (the format's default is a white metal)"));
        }
        self.model.textures = decoded.into_iter().map(|decoded| Arc::clone(&decoded.texture)).collect();
        Ok(())
    }

    fn analytic_asset(&mut self, index: usize, plan: &AnalyticPlan) -> Result<AnalyticAsset, SceneError> {
        let source = self.source;
        let owner = format!("{}.extras.catoptric", plan.owner);
        let wrong = |error| nodes::key_error(source, &owner, &error);
        let surface = plan.surface.surface().map_err(wrong)?;
        let own = plan.look.material(&source.document.nodes[index].name).map_err(wrong)?;
        // The triangles' material goes on being used unless the extras name the surface's own.
        let material = match plan.material {
            Some(material) if plan.look.tint.is_none() && plan.look.ior.is_none() => {
                match (own.blend, plan.look.blend.any()) {
                    (Some(_), Some(key)) if self.model.materials[material].role != Role::Reflector => {
                        let problem = "is for mirrors, but the material is none: add a `tint`, which makes it one";
                        return Err(source.invalid(format!("{owner}.{key}"), problem));
                    }
                    (Some(blend), _) => {
                        let blended = Material { blend: Some(blend), ..self.model.materials[material].clone() };
                        self.model.materials.push(blended);
                        self.model.materials.len() - 1
                    }
                    (None, _) => material,
                }
            }
            _ => {
                self.model.materials.push(own);
                self.model.materials.len() - 1
            }
        };
        if plan.look.inside && self.model.materials[material].role == Role::Lens {
            return Err(source.invalid(format!("{owner}.inside"), "is for mirrors, but the material is a lens"));
        }
        Ok(AnalyticAsset { surface, material, inside: plan.look.inside })
    }
}

/// An analytic surface whose material is not there yet.
struct AnalyticPlan {
    /// The node or mesh whose extras name it.
    owner: String,
    surface: super::analytic::SurfaceKeys,
    look: super::analytic::MaterialKeys,
    /// The material of the triangles that it replaces.
    material: Option<usize>,
}
