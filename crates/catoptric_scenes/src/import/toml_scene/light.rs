//! One `[[light]]` of a scene file: the kinds, units and names of KHR_lights_punctual.

use super::keys::{Keys, Located, Text};
use super::places::{direction, point};
use catoptric_core::error::SceneError;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::LightKind;
use catoptric_core::scene::model::{LightAsset, LocalTransform, Node};
use glam::{Quat, Vec3};

/// A node with the light that a table describes.
pub(super) fn read(source: Text<'_>, mut table: Keys<'_, '_>) -> Result<Node, SceneError> {
    let kind = table.string("kind")?;
    let position = table.numbers("position")?;
    let towards = table.numbers("direction")?;
    let color = table.numbers("color")?;
    let intensity = table.number("intensity")?;
    let range = table.number("range")?;
    let inner = table.number("inner_angle_deg")?;
    let outer = table.number("outer_angle_deg")?;
    let kinds = "allowed are `directional`, `point` and `spot`";
    let kind = kind.ok_or_else(|| table.missing("kind", format!("missing; {kinds}")))?;
    // The keys of each kind: position, direction, range, angles.
    let (placed, aimed) = match kind.value.as_str() {
        "directional" => (false, true),
        "point" => (true, false),
        "spot" => (true, true),
        other => return Err(source.invalid(kind.begin, "light.kind", format!("`{other}`; {kinds}"))),
    };
    let spot = placed && aimed;
    let unfit = [
        ("position", position.as_ref().map(|at| at.begin), placed),
        ("direction", towards.as_ref().map(|at| at.begin), aimed),
        ("range", range.as_ref().map(|at| at.begin), placed),
        ("inner_angle_deg", inner.as_ref().map(|at| at.begin), spot),
        ("outer_angle_deg", outer.as_ref().map(|at| at.begin), spot),
    ];
    for (key, begin, fits) in unfit {
        if let (Some(begin), false) = (begin, fits) {
            return Err(source.invalid(begin, &format!("light.{key}"), format!("a {} light has none", kind.value)));
        }
    }
    let needs = |key: &str| table.missing(key, format!("missing; a {} light needs it", kind.value));
    let position = match position {
        Some(at) => point(source, "light.position", at)?,
        None if placed => return Err(needs("position")),
        None => Vec3::ZERO,
    };
    let towards = match towards {
        Some(at) => direction(source, "light.direction", at)?,
        None if aimed => return Err(needs("direction")),
        None => Vec3::NEG_Z,
    };
    let within = |at: Option<Located<f64>>, key: &str, otherwise: f64, low: f64, high: f64| match at {
        Some(Located { begin, value }) if !(low..=high).contains(&value) => {
            Err(source.invalid(begin, &format!("light.{key}"), format!("{value}; allowed is {low} to {high}")))
        }
        Some(at) => Ok(at.value as f32),
        None => Ok(otherwise as f32),
    };
    let intensity = within(intensity, "intensity", 1.0, 0.0, 1e9)?;
    let range = match range {
        Some(_) => within(range, "range", 0.0, 1e-6, 1e9)?,
        None => f32::INFINITY,
    };
    let outer_deg = within(outer, "outer_angle_deg", 45.0, 0.01, 90.0)?;
    let inner_deg = within(inner, "inner_angle_deg", 0.0, 0.0, outer_deg as f64)?;
    let color = match color {
        Some(Located { begin, value }) if !value.iter().all(|share| (0.0..=1.0).contains(share)) => {
            return Err(source.invalid(begin, "light.color", format!("{value:?}; allowed is 0 to 1")));
        }
        Some(at) => Vec3::from(at.value.map(|share| share as f32)),
        None => Vec3::ONE,
    };
    table.finish()?;
    let kind = match (placed, aimed) {
        (true, true) => LightKind::Spot {
            range,
            inner_cos: inner_deg.to_radians().cosine(),
            outer_cos: outer_deg.to_radians().cosine(),
        },
        (true, false) => LightKind::Point { range },
        _ => LightKind::Directional,
    };
    // Lights shine along their node's -z.
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, towards);
    Ok(Node {
        local: LocalTransform::Parts { translation: position, rotation, scale: Vec3::ONE },
        light: Some(LightAsset { kind, intensity: color * intensity }),
        ..Node::default()
    })
}
