//! Files that objects of a scene name: pictures and meshes.

use super::super::merge;
use super::super::picture::{TexelBudget, decode_within};
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::{Model, Node};
use catoptric_core::scene::{Sampler, Texture, TextureBinding};
use glam::Affine2;
use std::ops::Range;
use std::sync::Arc;

/// Files that are read after the scene's own text.
#[derive(Clone, Debug, Default)]
pub(super) struct ObjectFiles {
    /// The numbers of materials, with their pictures.
    pub(super) pictures: Vec<(usize, NamedFile)>,
    /// The meshes.
    pub(super) meshes: Vec<MeshUse>,
}

/// The name of a file, relative to the scene, and the field that holds it, with its line.
#[derive(Clone, Debug)]
pub(super) struct NamedFile {
    pub(super) name: String,
    pub(super) field: String,
}

/// The mesh of a file at its places.
#[derive(Clone, Debug)]
pub(super) struct MeshUse {
    pub(super) file: NamedFile,
    /// The nodes at which it stands.
    pub(super) nodes: Range<usize>,
    /// The material that takes the place of all of the file's.
    pub(super) material: Option<usize>,
    pub(super) unlit: bool,
}

impl ObjectFiles {
    /// Reads them into the model.
    pub(super) fn add_to(
        self,
        model: &mut Model,
        bytes: &dyn Fn(&str) -> Result<Vec<u8>, SceneError>,
        mesh: &dyn Fn(&str) -> Result<Model, SceneError>,
    ) -> Result<(), SceneError> {
        let scene = model.name.clone();
        let wrong = |file: &NamedFile, problem: String| SceneError::invalid(&scene, &file.field, problem);
        let mut budget = TexelBudget::default();
        for (material, file) in self.pictures {
            let picture = bytes(&file.name).map_err(|error| wrong(&file, error.to_string()))?;
            let picture = decode_within(&picture, &mut budget);
            let picture = picture.map_err(|problem| wrong(&file, format!("`{}` {problem}", file.name)))?;
            let (width, height) = (picture.width, picture.height);
            let texture = Texture::from_srgb8(&file.name, width, height, &picture.texels, Sampler::default());
            model.textures.push(Arc::new(texture));
            let texture = model.textures.len() as u32 - 1;
            let binding = TextureBinding { texture, uv_channel: 0, texture_from_uv: Affine2::IDENTITY };
            model.materials[material].base_texture = Some(binding);
        }
        for placed in self.meshes {
            let loaded = mesh(&placed.file.name).map_err(|error| wrong(&placed.file, error.to_string()))?;
            placed.add(loaded, model).map_err(|problem| wrong(&placed.file, problem))?;
        }
        Ok(())
    }
}

impl MeshUse {
    /// Puts a file's model at each of the nodes.
    fn add(&self, loaded: Model, model: &mut Model) -> Result<(), String> {
        if self.nodes.len() > 1 && !(loaded.skins.is_empty() && loaded.animations.is_empty()) {
            return Err("is animated: it can be placed once alone, without `count`".into());
        }
        let (mesh, material, node) = (model.meshes.len(), model.materials.len(), model.nodes.len());
        merge::append(model, loaded);
        for mesh in &mut model.meshes[mesh..] {
            mesh.primitives.iter_mut().for_each(|part| part.material = self.material.unwrap_or(part.material));
        }
        for material in &mut model.materials[material..] {
            material.unlit |= self.unlit;
        }
        let nodes: Vec<Node> = model.nodes.split_off(node);
        for place in self.nodes.clone() {
            let moved = model.nodes.len() - node;
            model.nodes.extend(nodes.iter().cloned().map(|mut own| {
                if let (Some(surface), Some(material)) = (&mut own.analytic, self.material) {
                    surface.material = material;
                }
                own.parent = Some(own.parent.map_or(place, |parent| parent + moved));
                own
            }));
        }
        Ok(())
    }
}
