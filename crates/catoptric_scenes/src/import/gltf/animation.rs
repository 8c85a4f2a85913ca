//! Animations of nodes and of morph weights.

use super::accessors::Elements;
use super::meshes::target_count;
use super::schema;
use super::source::Source;
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::{Animation, Channel, ChannelValues, Interpolation};
use glam::{Quat, Vec3};

/// An animation; channels that cannot be read are left out, with a warning.
pub(super) fn read(source: &Source<'_>, index: usize, entry: &schema::Animation) -> Animation {
    let mut animation = Animation { name: entry.name.clone(), channels: Vec::new() };
    for (number, channel) in entry.channels.iter().enumerate() {
        let owner = format!("animations[{index}].channels[{number}]");
        match read_channel(source, entry, channel, &owner) {
            Ok(channel) => animation.channels.extend(channel),
            // One odd channel is no reason for no picture.
            Err(error) => source.warn(format!("{owner} is left out: {}", error.without_file())),
        }
    }
    animation
}

/// A channel; returns `None`, with a warning, if it moves nothing that is drawn.
fn read_channel(
    source: &Source<'_>,
    animation: &schema::Animation,
    channel: &schema::Channel,
    owner: &str,
) -> Result<Option<Channel>, SceneError> {
    let path = channel.target.path.as_str();
    // The standard makes readers pass over channels without a node.
    let Some(node) = channel.target.node else {
        source.warn(format!("{owner}: moves no node (`{path}`) and is left out"));
        return Ok(None);
    };
    source.entry(&source.document.nodes, node, &|| format!("{owner}.target.node"), "nodes")?;
    if !["translation", "rotation", "scale", "weights"].contains(&path) {
        source.warn(format!("{owner}: `{path}` cannot be animated and is left out"));
        return Ok(None);
    }
    let field = || format!("{owner}.sampler");
    let number = channel.sampler.ok_or_else(|| source.invalid(field(), "missing"))?;
    let sampler = source.entry(&animation.samplers, number, &field, "samplers")?;
    let part = |name: &str, accessor: Option<usize>, kind: &str| {
        let field = || format!("{owner}.sampler.{name}");
        let accessor = accessor.ok_or_else(|| source.invalid(field(), "missing"))?;
        let elements = source.elements(accessor, &[kind], &field)?;
        source.spend(elements.count as u64 * 16, &field)?;
        Ok(elements)
    };
    let times = part("input", sampler.input, "SCALAR")?;
    let times: Vec<f32> = (0..times.count).map(|key| times.float(key, 0)).collect();
    if times.iter().any(|time| !time.is_finite()) || times.windows(2).any(|pair| pair[0] > pair[1]) {
        source.warn(format!("{owner}: its times do not rise; it is left out"));
        return Ok(None);
    }
    let interpolation = match sampler.interpolation.as_ref().map(|name| name.as_str().unwrap_or("")) {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(_) => {
            let problem = "allowed are LINEAR, STEP and CUBICSPLINE";
            return Err(source.invalid(format!("{owner}.sampler.interpolation"), problem));
        }
    };
    let kind = match path {
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => "VEC3",
    };
    let output = part("output", sampler.output, kind)?;
    let values_needed = times.len() * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let row = if path == "weights" { weights_of(source, node) } else { 1 };
    if output.count < values_needed * row || (path == "weights" && row == 0) {
        let problem = format!("{} values; {} keys need {}", output.count, times.len(), values_needed * row);
        return Err(source.invalid(format!("{owner}.sampler.output"), problem));
    }
    let vectors = |output: &Elements<'_>| (0..values_needed).map(|key| Vec3::from(output.floats(key))).collect();
    let values = match path {
        "translation" => ChannelValues::Translation(vectors(&output)),
        "scale" => ChannelValues::Scale(vectors(&output)),
        "rotation" => {
            ChannelValues::Rotation((0..values_needed).map(|key| Quat::from_array(output.floats(key))).collect())
        }
        _ => {
            let numbers = (0..values_needed * row).map(|number| output.float(number, 0)).collect();
            ChannelValues::Weights { targets: row, numbers }
        }
    };
    Ok(Some(Channel { node, times, interpolation, values }))
}

/// The number of morph targets of the mesh at a node.
fn weights_of(source: &Source<'_>, node: usize) -> usize {
    let mesh = source.document.nodes[node].mesh.and_then(|mesh| source.document.meshes.get(mesh));
    mesh.map_or(0, target_count)
}
