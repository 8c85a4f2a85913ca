//! One `[[reflector]]`: exact surfaces, their place and their material.

use super::super::analytic::{self, Form, MaterialKeys, SurfaceKeys, Value};
use super::super::key_error::KeyError;
use super::blend;
use super::copies::Copies;
use super::keys::{Keys, Text};
use super::optics::{self, Form as SheetForm, Sheet};
use super::places::{exact_direction, exact_point, plane_rotation, rotation_about_fixed_axes};
use super::solid::fine_disk;
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::{AnalyticAsset, LocalTransform, MeshAsset, Model, Node, Primitive};
use catoptric_core::surface::AnalyticSurface;
use glam::{DQuat, DVec3};
use std::collections::HashSet;

/// The most copies of a reflector: each has a tessellation of its own.
const MAX_COPIES: f64 = 10_000.0;

/// Adds a reflector to the model; `index` is its number in the file.
pub(super) fn read(text: Text<'_>, mut table: Keys<'_, '_>, index: usize, model: &mut Model) -> Result<(), SceneError> {
    let kind = table.string("surface")?;
    let Some(kind) = kind else {
        let also = if table.has("shape") { "; `shape` is for [[object]]" } else { "" };
        return Err(table.missing("surface", format!("missing; it names the kind, such as \"sphere\"{also}")));
    };
    // Before the other keys: those of a kind that there is not would only be called unknown.
    let kind = find_kind(&kind.value).map_err(|error| table.wrong(error.key, kind.begin, error.problem))?;
    let name = table.string("name")?.map_or_else(|| format!("reflector {index}"), |name| name.value);
    let center = table.numbers("center")?;
    let rotation_deg = table.numbers("rotation_deg")?;
    let copies = Copies::read(text, &mut table, MAX_COPIES)?;
    let (look, mut begins) = read_material(&mut table)?;
    let (sheets, is_plane) = match kind {
        Kind::Surface(kind) => {
            let keys = SurfaceKeys { kind, values: read_values(&mut table, kind, &mut begins)? };
            let surface = keys.surface().map_err(|error| blend::explain(text, &table, &begins, error))?;
            let is_plane = matches!(surface, AnalyticSurface::Plane { .. });
            (vec![Sheet::in_place(SheetForm::Exact(Box::new(surface)))], is_plane)
        }
        Kind::Optics(kind) => (optics::read(text, &mut table, kind, look.ior.is_some())?, false),
    };
    let material = look.material(&name).map_err(|error| blend::explain(text, &table, &begins, error))?;
    let center = match center {
        Some(center) => exact_point(text, &table.field("center"), center)?,
        None if matches!(kind, Kind::Surface(kind) if kind.name == "implicit") => DVec3::ZERO,
        None => return Err(table.missing("center", "missing; needed is `center = [x, y, z]`")),
    };
    let towards = match kind {
        Kind::Optics(optics::Kind::Disk) => Some("normal"),
        Kind::Optics(_) => Some("axis"),
        Kind::Surface(_) => is_plane.then_some("normal"),
    };
    let upright = match towards {
        Some(key) => match table.numbers(key)? {
            Some(given) => plane_rotation(exact_direction(text, &table.field(key), given)?),
            None if is_plane => return Err(table.missing(key, "missing; a plane needs `normal = [x, y, z]`")),
            None => DQuat::IDENTITY,
        },
        None => DQuat::IDENTITY,
    };
    let rotation = rotation_deg.map_or(DQuat::IDENTITY, rotation_about_fixed_axes) * upright;
    let begin = table.begin();
    table.finish()?;
    let names: Vec<String> = (0..copies.offsets.len()).map(|index| copies.name(&name, index)).collect();
    let own: HashSet<&str> = names.iter().map(String::as_str).collect();
    if let Some(other) = model.nodes.iter().find(|node| own.contains(node.name.as_str())) {
        let problem = format!("there is a reflector `{}` already", other.name);
        return Err(text.invalid(begin, "reflector.name", problem));
    }
    model.materials.push(material);
    let parts = Parts { material: model.materials.len() - 1, inside: look.inside, sheets };
    let shapes = parts.shapes(&name, model);
    for (offset, name) in copies.offsets.iter().zip(&names) {
        parts.place(name, (center + *offset, rotation.normalize()), &shapes, model);
    }
    Ok(())
}

/// The kind of a surface.
#[derive(Clone, Copy)]
enum Kind {
    Surface(&'static analytic::Kind),
    Optics(optics::Kind),
}

fn find_kind(name: &str) -> Result<Kind, KeyError> {
    match (optics::kind_named(name), analytic::kind_named(name)) {
        (Some(kind), _) => Ok(Kind::Optics(kind)),
        (None, Ok(kind)) => Ok(Kind::Surface(kind)),
        (None, Err(_)) => Err(analytic::unknown_kind(name, analytic::kind_names().chain(optics::kind_names()))),
    }
}

/// The keys of the material, and where they stand.
fn read_material(table: &mut Keys<'_, '_>) -> Result<(MaterialKeys, blend::Begins), SceneError> {
    let tint = table.numbers("tint")?;
    let ior = table.number("ior")?;
    let roughness = table.number("roughness")?;
    let inside = table.boolean("inside")?;
    let (blend, mut begins) = blend::take(table)?;
    begins.extend([
        ("tint", tint.map(|at| at.begin)),
        ("ior", ior.map(|at| at.begin)),
        ("roughness", roughness.map(|at| at.begin)),
        ("inside", inside.map(|at| at.begin)),
    ]);
    let keys = MaterialKeys {
        tint: tint.map(|tint| tint.value),
        ior: ior.map(|ior| ior.value),
        roughness: roughness.map(|roughness| roughness.value),
        inside: inside.is_some_and(|inside| inside.value),
        blend,
    };
    Ok((keys, begins))
}

/// The values of a kind's parameters, in their order.
fn read_values(
    table: &mut Keys<'_, '_>,
    kind: &analytic::Kind,
    begins: &mut blend::Begins,
) -> Result<Vec<Option<Value>>, SceneError> {
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
    Ok(values)
}

/// The sheets of a reflector and what they are made of.
struct Parts {
    material: usize,
    inside: bool,
    sheets: Vec<Sheet>,
}

/// A sheet's shape as nodes have it.
enum Shape {
    Surface(Box<AnalyticAsset>),
    Mesh(usize),
}

impl Parts {
    /// The shapes of the sheets; meshes are added to the model.
    fn shapes(&self, name: &str, model: &mut Model) -> Vec<Shape> {
        let mut shape = |sheet: &Sheet| match &sheet.form {
            SheetForm::Exact(surface) => {
                let (surface, material, inside) = (AnalyticSurface::clone(surface), self.material, self.inside);
                Shape::Surface(Box::new(AnalyticAsset { surface, material, inside }))
            }
            SheetForm::Disk { radius, is_up } => {
                let mesh = fine_disk(*radius as f32, *is_up);
                let primitive = Primitive {
                    positions: mesh.positions,
                    normals: mesh.normals,
                    uvs: [mesh.uvs, Vec::new()],
                    triangles: mesh.triangles,
                    material: self.material,
                    ..Primitive::default()
                };
                let asset = MeshAsset { name: name.into(), primitives: vec![primitive], ..MeshAsset::default() };
                model.meshes.push(asset);
                Shape::Mesh(model.meshes.len() - 1)
            }
        };
        self.sheets.iter().map(&mut shape).collect()
    }

    /// Adds the nodes of one reflector: one, or one above those of several sheets.
    fn place(&self, name: &str, (center, turn): (DVec3, DQuat), shapes: &[Shape], model: &mut Model) {
        let whole = LocalTransform::Rigid { translation: center, rotation: turn };
        let is_one = self.sheets.len() == 1;
        let parent = (!is_one).then_some(model.nodes.len());
        if !is_one {
            model.nodes.push(Node { name: name.into(), local: whole, ..Node::default() });
        }
        for (sheet, shape) in self.sheets.iter().zip(shapes) {
            let local = if is_one {
                let is_straight = sheet.turn == DQuat::IDENTITY;
                let rotation = if is_straight { turn } else { (turn * sheet.turn).normalize() };
                LocalTransform::Rigid { translation: center + turn * sheet.at, rotation }
            } else {
                LocalTransform::Rigid { translation: sheet.at, rotation: sheet.turn }
            };
            let name = if is_one { name.into() } else { format!("{name} {}", sheet.name) };
            let mut node = Node { name, local, parent, ..Node::default() };
            match shape {
                Shape::Surface(surface) => node.analytic = Some(AnalyticAsset::clone(surface)),
                Shape::Mesh(mesh) => node.mesh = Some(*mesh),
            }
            model.nodes.push(node);
        }
    }
}
