//! Joins models: several files in one scene.

use catoptric_core::scene::model::{ChannelValues, Model};

/// Adds everything of `other` to `model`, with all indices moved up.
///
/// Where both say something, `model` wins: its roles, blends and looks are the later ones, its settings, region and
/// environment stay, its cameras come first.
pub(super) fn append(model: &mut Model, other: Model) {
    let offset = Offsets {
        node: model.nodes.len(),
        mesh: model.meshes.len(),
        skin: model.skins.len(),
        material: model.materials.len(),
        texture: model.textures.len() as u32,
    };
    let Model { nodes, meshes, skins, animations, materials, textures, cameras, .. } = other;
    model.nodes.extend(nodes.into_iter().map(|mut node| {
        node.parent = node.parent.map(|parent| parent + offset.node);
        node.mesh = node.mesh.map(|mesh| mesh + offset.mesh);
        node.skin = node.skin.map(|skin| skin + offset.skin);
        if let Some(analytic) = &mut node.analytic {
            analytic.material += offset.material;
        }
        node
    }));
    model.meshes.extend(meshes.into_iter().map(|mut mesh| {
        mesh.primitives.iter_mut().for_each(|primitive| primitive.material += offset.material);
        mesh
    }));
    model.skins.extend(skins.into_iter().map(|mut skin| {
        skin.joints.iter_mut().for_each(|joint| *joint += offset.node);
        skin
    }));
    model.animations.extend(animations.into_iter().map(|mut animation| {
        for channel in &mut animation.channels {
            channel.node += offset.node;
            // Listed so that a kind of value that names a node cannot be forgotten here.
            match &channel.values {
                ChannelValues::Translation(_)
                | ChannelValues::Rotation(_)
                | ChannelValues::Scale(_)
                | ChannelValues::Weights { .. } => {}
            }
        }
        animation
    }));
    model.materials.extend(materials.into_iter().map(|mut material| {
        material.bindings_mut().for_each(|binding| binding.texture += offset.texture);
        material
    }));
    model.textures.extend(textures);
    model.cameras.extend(cameras.into_iter().map(|mut camera| {
        camera.node = camera.node.map(|node| node + offset.node);
        camera
    }));
    if model.environment.is_none() {
        model.environment = other.environment;
    }
    if model.region.is_none() {
        model.region = other.region;
    }
    for (method, settings) in other.method_settings {
        let own = model.method_settings.entry(method).or_default();
        *own = settings.into_iter().chain(std::mem::take(own)).collect();
    }
    model.roles.splice(0..0, other.roles);
    model.blends.splice(0..0, other.blends);
    model.looks.splice(0..0, other.looks);
    model.moves.splice(0..0, other.moves);
    for name in other.variants {
        if !model.variants.contains(&name) {
            model.variants.push(name);
        }
    }
    model.variant = model.variant.take().or(other.variant);
    model.warnings.extend(other.warnings);
}

struct Offsets {
    node: usize,
    mesh: usize,
    skin: usize,
    material: usize,
    texture: u32,
}
