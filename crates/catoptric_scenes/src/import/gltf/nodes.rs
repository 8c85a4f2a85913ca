//! The tree of nodes with their surfaces, cameras, lights, instances and skins.

use super::super::analytic::{self, Form, MaterialKeys, SurfaceKeys, Value as Given};
use super::super::blend::{AttenuationKeys, BlendKeys};
use super::super::key_error::KeyError;
use super::schema;
use super::source::Source;
use catoptric_core::error::SceneError;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::model::{CameraAsset, LightAsset, LocalTransform, Node, Skin};
use catoptric_core::scene::{LightKind, Projection};
use glam::{Affine3A, Mat4, Quat, Vec3};
use serde_json::{Map, Value};

/// The nodes, and which of them the scene shows.
pub(super) struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) shown: Vec<bool>,
}

/// Reads the tree; meshes and their replacements are filled in later.
pub(super) fn tree(source: &Source<'_>) -> Result<Tree, SceneError> {
    let entries = &source.document.nodes;
    let mut nodes = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        if let Some(camera) = entry.camera {
            source.entry(&source.document.cameras, camera, &|| format!("nodes[{index}].camera"), "cameras")?;
        }
        if let Some(skin) = entry.skin {
            source.entry(&source.document.skins, skin, &|| format!("nodes[{index}].skin"), "skins")?;
        }
        nodes.push(Node {
            name: entry.name.clone(),
            local: local_transform(entry),
            morph_weights: entry.weights.clone(),
            ..Node::default()
        });
    }
    for (index, entry) in entries.iter().enumerate() {
        for &child in &entry.children {
            let field = || format!("nodes[{index}].children");
            source.entry(&nodes, child, &field, "nodes")?;
            if let Some(parent) = nodes[child].parent {
                let problem = format!("nodes[{child}] is a child of nodes[{parent}] too; it may have one parent");
                return Err(source.invalid(field(), problem));
            }
            nodes[child].parent = Some(index);
        }
    }
    reject_cycles(source, &nodes)?;
    let shown = shown(source, &nodes)?;
    Ok(Tree { nodes, shown })
}

fn local_transform(entry: &schema::Node) -> LocalTransform {
    if let Some(matrix) = &entry.matrix {
        return LocalTransform::Matrix(Mat4::from_cols_array(matrix));
    }
    LocalTransform::Parts {
        translation: entry.translation.map_or(Vec3::ZERO, Vec3::from),
        rotation: entry.rotation.map_or(Quat::IDENTITY, Quat::from_array),
        scale: entry.scale.map_or(Vec3::ONE, Vec3::from),
    }
}

/// Every node has at most one parent here, so a walk up either ends at a root or goes round.
fn reject_cycles(source: &Source<'_>, nodes: &[Node]) -> Result<(), SceneError> {
    let mut sound = vec![false; nodes.len()];
    let mut chain = Vec::new();
    for start in 0..nodes.len() {
        chain.clear();
        let mut at = Some(start);
        while let Some(node) = at.filter(|node| !sound[*node]) {
            if chain.len() > nodes.len() {
                return Err(source.invalid(format!("nodes[{start}].children"), "the node is its own ancestor"));
            }
            chain.push(node);
            at = nodes[node].parent;
        }
        chain.iter().for_each(|node| sound[*node] = true);
    }
    Ok(())
}

/// The nodes of the default scene (the named one, else the first, else all) but for those that are hidden, with all
/// that is below them (KHR_node_visibility).
fn shown(source: &Source<'_>, nodes: &[Node]) -> Result<Vec<bool>, SceneError> {
    let document = source.document;
    let scene = match document.scene {
        Some(scene) => Some(source.entry(&document.scenes, scene, &|| "scene".into(), "scenes")?),
        None => document.scenes.first(),
    };
    let mut shown = vec![false; nodes.len()];
    let mut open = Vec::new();
    match scene {
        Some(scene) => {
            for &root in &scene.nodes {
                source.entry(nodes, root, &|| format!("scenes[{}].nodes", document.scene.unwrap_or(0)), "nodes")?;
                open.push(root);
            }
        }
        None => open.extend((0..nodes.len()).filter(|node| nodes[*node].parent.is_none())),
    }
    while let Some(node) = open.pop() {
        let visibility: Option<schema::Visibility> =
            source.extension(&|| format!("nodes[{node}]"), &document.nodes[node].extensions, "KHR_node_visibility")?;
        if visibility.and_then(|visibility| visibility.visible) == Some(false) {
            continue;
        }
        if !std::mem::replace(&mut shown[node], true) {
            open.extend(&document.nodes[node].children);
        }
    }
    Ok(shown)
}

/// The light at a node (KHR_lights_punctual).
pub(super) fn light(
    source: &Source<'_>,
    index: usize,
    lights: &[schema::Light],
) -> Result<Option<LightAsset>, SceneError> {
    let owner = || format!("nodes[{index}]");
    let key = "KHR_lights_punctual";
    let extensions = &source.document.nodes[index].extensions;
    let Some(reference): Option<schema::LightReference> = source.extension(&owner, extensions, key)? else {
        return Ok(None);
    };
    let field = || format!("{}.extensions.{key}.light", owner());
    let number = reference.light.ok_or_else(|| source.invalid(field(), "missing"))?;
    let light = source.entry(lights, number, &field, "lights")?;
    let range = light.range.filter(|range| *range > 0.0).unwrap_or(f32::INFINITY);
    let kind = match light.kind.as_str() {
        "directional" => LightKind::Directional,
        "point" => LightKind::Point { range },
        "spot" => {
            let outer = light.spot.outer_cone_angle.unwrap_or(std::f32::consts::FRAC_PI_4);
            let inner = light.spot.inner_cone_angle;
            if !(0.0 <= inner && inner <= outer && outer <= std::f32::consts::FRAC_PI_2 + 1e-4) {
                let problem = format!("{inner} and {outer} radians; needed is 0 <= inner <= outer <= pi/2");
                return Err(source.invalid(format!("lights[{number}].spot"), problem));
            }
            LightKind::Spot { range, inner_cos: inner.cosine(), outer_cos: outer.cosine() }
        }
        other => {
            let problem = format!("`{other}`; allowed are directional, point and spot");
            return Err(source.invalid(format!("lights[{number}].type"), problem));
        }
    };
    let color = Vec3::from(light.color.unwrap_or([1.0; 3]));
    let intensity = color * light.intensity.unwrap_or(1.0);
    Ok(Some(LightAsset { kind, intensity: if intensity.is_finite() { intensity } else { Vec3::ZERO } }))
}

/// The camera at a node, named like the node, else like itself.
pub(super) fn camera(source: &Source<'_>, index: usize) -> Option<CameraAsset> {
    let node = &source.document.nodes[index];
    let number = node.camera?;
    let camera = source.document.cameras.get(number)?;
    let projection = match (camera.kind.as_str(), &camera.perspective, &camera.orthographic) {
        ("perspective", Some(perspective), _) if perspective.yfov > 0.0 && perspective.yfov < std::f32::consts::PI => {
            Projection::Perspective { fov_y: perspective.yfov }
        }
        ("orthographic", _, Some(orthographic)) if orthographic.ymag.is_finite() && orthographic.ymag != 0.0 => {
            Projection::Orthographic { half_height: orthographic.ymag.abs() }
        }
        _ => {
            let needed = "needed is perspective with yfov between 0 and pi, or orthographic with ymag";
            source.warn(format!("cameras[{number}] is left out: {needed}"));
            return None;
        }
    };
    let (name, other_name) = if node.name.is_empty() { (&camera.name, &node.name) } else { (&node.name, &camera.name) };
    Some(CameraAsset {
        name: name.clone(),
        other_name: other_name.clone(),
        node: Some(index),
        placement: Affine3A::IDENTITY,
        projection,
    })
}

/// The placements of a node's mesh (EXT_mesh_gpu_instancing); returns `None` without the extension.
pub(super) fn instances(source: &Source<'_>, index: usize) -> Result<Option<Vec<Affine3A>>, SceneError> {
    let owner = || format!("nodes[{index}]");
    let key = "EXT_mesh_gpu_instancing";
    let extensions = &source.document.nodes[index].extensions;
    let Some(instancing): Option<schema::Instancing> = source.extension(&owner, extensions, key)? else {
        return Ok(None);
    };
    let mut count = None;
    let mut elements = |name: &str, kind: &str| {
        let Some(&accessor) = instancing.attributes.get(name) else { return Ok(None) };
        let field = || format!("{}.extensions.{key}.attributes.{name}", owner());
        let elements = source.elements(accessor, &[kind], &field)?;
        if *count.get_or_insert(elements.count) != elements.count {
            return Err(source.invalid(field(), "all attributes must have the same count"));
        }
        Ok(Some(elements))
    };
    let translations = elements("TRANSLATION", "VEC3")?;
    let rotations = elements("ROTATION", "VEC4")?;
    let scales = elements("SCALE", "VEC3")?;
    let Some(count) = count else {
        return Err(source.invalid(format!("{}.extensions.{key}", owner()), "has no TRANSLATION, ROTATION or SCALE"));
    };
    source.spend(count as u64 * 64, &owner)?;
    let place = |instance| {
        let translation = translations.as_ref().map_or(Vec3::ZERO, |values| Vec3::from(values.floats(instance)));
        let scale = scales.as_ref().map_or(Vec3::ONE, |values| Vec3::from(values.floats(instance)));
        let rotation = rotations.as_ref().map(|values| Quat::from_array(values.floats(instance)));
        let rotation = rotation.filter(|q| q.length_squared() > 1e-20 && q.length_squared().is_finite());
        let rotation = rotation.map_or(Quat::IDENTITY, Quat::normalize);
        Affine3A::from_scale_rotation_translation(scale, rotation, translation)
    };
    Ok(Some((0..count).map(place).collect()))
}

pub(super) fn skin(source: &Source<'_>, index: usize, entry: &schema::Skin) -> Result<Skin, SceneError> {
    let owner = || format!("skins[{index}]");
    for &joint in &entry.joints {
        source.entry(&source.document.nodes, joint, &|| format!("{}.joints", owner()), "nodes")?;
    }
    let mut inverse_bind = Vec::new();
    if let Some(accessor) = entry.inverse_bind_matrices {
        let field = || format!("{}.inverseBindMatrices", owner());
        let matrices = source.elements(accessor, &["MAT4"], &field)?;
        if matrices.count < entry.joints.len() {
            let problem = format!("{} matrices for {} joints", matrices.count, entry.joints.len());
            return Err(source.invalid(field(), problem));
        }
        inverse_bind = (0..entry.joints.len()).map(|joint| Mat4::from_cols_array(&matrices.floats(joint))).collect();
    }
    Ok(Skin { joints: entry.joints.clone(), inverse_bind })
}

/// `extras.catoptric` of a node or mesh: an analytic surface that replaces the triangles.
pub(super) fn surface_keys(
    source: &Source<'_>,
    owner: &str,
    extras: &Value,
) -> Result<Option<(SurfaceKeys, MaterialKeys)>, SceneError> {
    let Some(value) = extras.get("catoptric") else { return Ok(None) };
    let field = format!("{owner}.extras.catoptric");
    let Value::Object(mut keys) = value.clone() else {
        return Err(source.invalid(field, "must be an object such as { \"surface\": \"sphere\", \"radius\": 1 }"));
    };
    let kind = keys.remove("surface").and_then(|kind| kind.as_str().map(String::from));
    let kind = kind.ok_or_else(|| source.invalid(format!("{field}.surface"), "missing; it names the kind"))?;
    let kind = analytic::kind_named(&kind).map_err(|error| key_error(source, &field, &error))?;
    let mut take = |key: &str| keys.remove(key);
    let wrong = |key: &str, what: &str| source.invalid(format!("{field}.{key}"), format!("must be {what}"));
    let mut values = Vec::new();
    for parameter in kind.parameters {
        let given = take(parameter.key).map(|value| match parameter.form {
            Form::Text => value.as_str().map(|text| Given::Text(text.into())).ok_or("a text".into()),
            Form::Numbers(1) => {
                number(&value).map(|number| Given::Numbers(vec![number])).ok_or("a finite number".into())
            }
            Form::Numbers(count) => {
                let list = value.as_array().and_then(|list| list.iter().map(number).collect::<Option<Vec<f64>>>());
                list.filter(|list| list.len() == count)
                    .map(Given::Numbers)
                    .ok_or(format!("{count} finite numbers in brackets"))
            }
        });
        let given: Option<Result<Given, String>> = given;
        values.push(given.transpose().map_err(|what| wrong(parameter.key, &what))?);
    }
    let tint =
        take("tint").map(|value| numbers::<3>(&value).ok_or_else(|| wrong("tint", "3 finite numbers in brackets")));
    let ior = take("ior").map(|value| number(&value).ok_or_else(|| wrong("ior", "a finite number")));
    let roughness = take("roughness").map(|value| number(&value).ok_or_else(|| wrong("roughness", "a finite number")));
    let inside = take("inside").map(|value| value.as_bool().ok_or_else(|| wrong("inside", "true or false")));
    let blend = blend_keys(source, &field, &mut keys)?;
    if let Some(key) = keys.keys().next() {
        let known = ["surface", "tint", "ior", "roughness", "inside", "fresnel", "attenuation", "diffuse"];
        let known = known.into_iter().chain(["highlight_roughness"]);
        let known: Vec<&str> = known.chain(kind.parameters.iter().map(|parameter| parameter.key)).collect();
        let problem = format!("unknown field `{key}`; known are: {}", known.join(", "));
        return Err(source.invalid(format!("{field}.{key}"), problem));
    }
    let (tint, ior, inside) = (tint.transpose()?, ior.transpose()?, inside.transpose()?.unwrap_or(false));
    let roughness = roughness.transpose()?;
    Ok(Some((SurfaceKeys { kind, values }, MaterialKeys { tint, ior, roughness, inside, blend })))
}

/// Takes the keys of a mirror's blend.
fn blend_keys(source: &Source<'_>, field: &str, keys: &mut Map<String, Value>) -> Result<BlendKeys, SceneError> {
    let wrong = |key: &str, what: &str| source.invalid(format!("{field}.{key}"), format!("must be {what}"));
    let pair = |key: &str, value: Value| numbers(&value).ok_or_else(|| wrong(key, "2 finite numbers in brackets"));
    let fresnel = keys.remove("fresnel").map(|value| pair("fresnel", value)).transpose()?;
    let three = |value: Value| numbers(&value).ok_or_else(|| wrong("diffuse", "3 finite numbers in brackets"));
    let diffuse = keys.remove("diffuse").map(three).transpose()?;
    let roughness =
        |value: Value| number(&value).ok_or_else(|| wrong("highlight_roughness", "a number from 0.03 to 1"));
    let highlight_roughness = keys.remove("highlight_roughness").map(roughness).transpose()?;
    let Some(attenuation) = keys.remove("attenuation") else {
        return Ok(BlendKeys { fresnel, attenuation: None, diffuse, highlight_roughness });
    };
    let Value::Object(mut inner) = attenuation else {
        return Err(wrong("attenuation", "an object such as { \"distance\": 1, \"specularity\": [0, 1] }"));
    };
    let one = |value: Value| number(&value).ok_or_else(|| wrong("attenuation.distance", "a finite number"));
    let distance = inner.remove("distance").map(one).transpose()?;
    let specularity = inner.remove("specularity").map(|value| pair("attenuation.specularity", value)).transpose()?;
    if let Some(key) = inner.keys().next() {
        let problem = format!("unknown field `{key}`; known are: distance, specularity");
        return Err(source.invalid(format!("{field}.attenuation.{key}"), problem));
    }
    let attenuation = Some(AttenuationKeys { distance, specularity });
    Ok(BlendKeys { fresnel, attenuation, diffuse, highlight_roughness })
}

/// Finite numbers of a given count.
fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let list: Option<Vec<f64>> = value.as_array()?.iter().map(number).collect();
    list?.try_into().ok()
}

/// A finite number.
fn number(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.is_finite())
}

pub(super) fn key_error(source: &Source<'_>, owner: &str, error: &KeyError) -> SceneError {
    source.invalid(format!("{owner}.{}", error.key), error.problem.clone())
}
