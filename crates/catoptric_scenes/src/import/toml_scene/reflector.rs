//! One `[[reflector]]`: an analytic surface, its place and its material.

use super::super::analytic::{self, Form, SurfaceKeys, Value};
use super::super::key_error::KeyError;
use super::keys::{Keys, Located, Text};
use super::{blend, exact_direction, exact_point};
use catoptric_core::error::SceneError;
use catoptric_core::math::portable::turn_about;
use catoptric_core::scene::Material;
use catoptric_core::scene::model::LocalTransform;
use catoptric_core::surface::AnalyticSurface;
use glam::{DMat3, DQuat, DVec3};

pub(super) struct Reflector {
    pub(super) name: String,
    pub(super) surface: AnalyticSurface,
    pub(super) place: LocalTransform,
    pub(super) material: Material,
    pub(super) inside: bool,
}

pub(super) fn read(text: Text<'_>, mut table: Keys<'_, '_>, index: usize) -> Result<Reflector, SceneError> {
    let kind = table.string("surface")?;
    let Some(kind) = kind else {
        return Err(table.invalid("surface", "missing; it names the kind, such as \"sphere\""));
    };
    // Before the other keys: those of a kind that there is not would only be called unknown.
    let field = |key: &str| format!("reflector.{key}");
    let at = |begin: usize, error: KeyError| text.invalid(begin, &field(error.key), error.problem);
    let kind = analytic::kind_named(&kind.value).map_err(|error| at(kind.begin, error))?;
    let name = table.string("name")?.map_or_else(|| format!("reflector {index}"), |name| name.value);
    let center = table.numbers("center")?;
    let rotation_deg = table.numbers("rotation_deg")?;
    let tint = table.numbers("tint")?;
    let ior = table.number("ior")?;
    let roughness = table.number("roughness")?;
    let inside = table.boolean("inside")?;
    let (blend, mut begins) = blend::take(&mut table)?;
    begins.extend([
        ("tint", tint.map(|at| at.begin)),
        ("ior", ior.map(|at| at.begin)),
        ("roughness", roughness.map(|at| at.begin)),
        ("inside", inside.map(|at| at.begin)),
    ]);
    let mut values = Vec::new();
    for parameter in kind.parameters {
        let given = match parameter.form {
            Form::Numbers(1) => table.number(parameter.key)?.map(|at| (at.begin, Value::Numbers(vec![at.value]))),
            Form::Numbers(count) => {
                table.number_list(parameter.key, count)?.map(|at| (at.begin, Value::Numbers(at.value)))
            }
            Form::Text => table.string(parameter.key)?.map(|at| (at.begin, Value::Text(at.value))),
        };
        begins.push((parameter.key, given.as_ref().map(|(begin, _)| *begin)));
        values.push(given.map(|(_, value)| value));
    }
    let normal = if kind.name == "plane" { table.numbers("normal")? } else { None };
    let keys = SurfaceKeys {
        kind,
        values,
        tint: tint.map(|tint| tint.value),
        ior: ior.map(|ior| ior.value),
        roughness: roughness.map(|roughness| roughness.value),
        inside: inside.is_some_and(|inside| inside.value),
        blend,
    };
    let explain = |error: KeyError| blend::explain(text, &table, &begins, error);
    let surface = keys.surface().map_err(explain)?;
    let material = keys.material(&name).map_err(explain)?;
    let center = match center {
        Some(center) => exact_point(text, &field("center"), center)?,
        None if kind.name == "implicit" => DVec3::ZERO,
        None => return Err(table.invalid("center", "missing; needed is `center = [x, y, z]`")),
    };
    let upright = match (&surface, normal) {
        (AnalyticSurface::Plane { .. }, Some(normal)) => {
            plane_rotation(exact_direction(text, &field("normal"), normal)?)
        }
        (AnalyticSurface::Plane { .. }, None) => {
            return Err(table.invalid("normal", "missing; a plane needs `normal = [x, y, z]`"));
        }
        _ => DQuat::IDENTITY,
    };
    let rotation = rotation_deg.map_or(DQuat::IDENTITY, rotation_about_fixed_axes) * upright;
    table.finish()?;
    let place = LocalTransform::Rigid { translation: center, rotation: rotation.normalize() };
    Ok(Reflector { name, surface, place, material, inside: keys.inside })
}

/// Turns about the fixed axes x, then y, then z: Rz Ry Rx.
fn rotation_about_fixed_axes(at: Located<[f64; 3]>) -> DQuat {
    // Whole turns are taken off in double precision, so that large angles keep their fraction.
    let [x, y, z] = at.value.map(|angle| (angle % 360.0).to_radians());
    turn_about(DVec3::Z, z) * turn_about(DVec3::Y, y) * turn_about(DVec3::X, x)
}

/// From the frame of a plane (x along its width, y its normal) to the world.
fn plane_rotation(normal: DVec3) -> DQuat {
    // `y x normal` loses its direction where the normal is parallel to y.
    let across = DVec3::Y.cross(normal);
    let width = if across.length() < 1e-6 { DVec3::X } else { across.normalize() };
    let width = (width - normal * width.dot(normal)).normalize();
    let height = width.cross(normal);
    DQuat::from_mat3(&DMat3::from_cols(width, normal, height))
}
