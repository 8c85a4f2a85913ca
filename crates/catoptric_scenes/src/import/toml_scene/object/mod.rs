//! One `[[object]]`: a simple shape or the mesh of a file, its place and its look.

mod finish;

use super::copies::Copies;
use super::files::{MeshUse, NamedFile, ObjectFiles};
use super::keys::{Keys, Located, Text};
use super::places::{exact_direction, exact_point, plane_rotation, rotation_about_fixed_axes};
use super::solid::Solid;
use crate::builtin::parts::textures;
use catoptric_core::error::{SceneError, did_you_mean};
use catoptric_core::framebuffer::srgb_from_linear;
use catoptric_core::scene::model::{LocalTransform, MeshAsset, Model, Node, Primitive};
use catoptric_core::scene::{Material, TextureBinding};
use finish::Finish;
use glam::{Affine2, DQuat, DVec3, Vec2, Vec3};

use std::collections::HashSet;
use std::sync::Arc;

/// The shapes, each with its own keys of lengths and how many numbers they are.
const SHAPES: [(&str, &[(&str, usize)]); 8] = [
    ("box", &[("size", 3)]),
    ("quad", &[("size", 2)]),
    ("sphere", &[("radius", 1)]),
    ("cylinder", &[("radius", 1), ("height", 1)]),
    ("cone", &[("radius", 1), ("height", 1)]),
    ("disk", &[("radius", 1)]),
    (POINTS, &[("radius", 1)]),
    (MESH, &[]),
];
const POINTS: &str = "grid of points";
const MESH: &str = "mesh";

/// The kinds of files that hold meshes.
const MESHES: [&str; 5] = ["glb", "gltf", "obj", "ply", "stl"];

/// Lengths and scales are from the first to the second.
const LENGTHS: [f64; 2] = [1e-9, 1e9];

/// The most copies of an object, and of the points of a grid, which have fewer triangles.
const MAX_COPIES: f64 = 10_000.0;
const MAX_POINTS: f64 = 10_000.0;

/// The brightest colour of what is unlit.
const MAX_RADIANCE: f64 = 1e6;

/// Adds an object to a model, and the files that it names; `index` is its number in the scene.
pub(super) fn read(
    text: Text<'_>,
    mut table: Keys<'_, '_>,
    index: usize,
    (model, files): (&mut Model, &mut ObjectFiles),
) -> Result<(), SceneError> {
    let (shape, lengths) = read_shape(&mut table)?;
    let name = table.string("name")?.map_or_else(|| format!("object {index}"), |name| name.value);
    let turn = read_turn(text, &mut table, shape)?;
    let center = match table.numbers("center")? {
        Some(center) => exact_point(text, &table.field("center"), center)?,
        None => DVec3::ZERO,
    };
    let scale = read_scale(&mut table)?;
    let copies = Copies::read(text, &mut table, if shape == POINTS { MAX_POINTS } else { MAX_COPIES })?;
    let look = Look::read(text, &mut table, shape == POINTS)?;
    let file = if shape == MESH { Some(read_file(text, &mut table)?) } else { None };
    let given = lengths.iter().map(|(key, count)| read_lengths(&mut table, shape, key, *count));
    let lengths = given.collect::<Result<Vec<_>, _>>()?.concat();
    let begin = table.begin();
    table.finish()?;
    let names: Vec<String> = (0..copies.offsets.len()).map(|index| copies.name(&name, index)).collect();
    let own: HashSet<&str> = names.iter().map(String::as_str).collect();
    if let Some(other) = model.nodes.iter().find(|node| own.contains(node.name.as_str())) {
        return Err(text.invalid(begin, "object.name", format!("there is a `{}` already", other.name)));
    }
    let first = model.nodes.len();
    for (offset, name) in copies.offsets.iter().zip(names) {
        let local = match (center + *offset, scale) {
            // In double precision.
            (translation, Vec3::ONE) => LocalTransform::Rigid { translation, rotation: turn },
            (at, scale) => LocalTransform::Parts { translation: at.as_vec3(), rotation: turn.as_quat(), scale },
        };
        model.nodes.push(Node { name, local, ..Node::default() });
    }
    let (unlit, square) = (look.unlit, look.checker.map(|(square, _)| square as f32));
    if let Some(file) = file {
        let material = look.is_given.then(|| look.add_material(&name, square, (model, files)));
        files.meshes.push(MeshUse { file, nodes: first..model.nodes.len(), material, unlit });
        return Ok(());
    }
    let mesh = solid(shape, &lengths).mesh(square);
    let primitive = Primitive {
        positions: mesh.positions,
        normals: mesh.normals,
        uvs: [mesh.uvs, Vec::new()],
        triangles: mesh.triangles,
        material: look.add_material(&name, None, (model, files)),
        ..Primitive::default()
    };
    model.meshes.push(MeshAsset { name, primitives: vec![primitive], ..MeshAsset::default() });
    let mesh = model.meshes.len() - 1;
    model.nodes[first..].iter_mut().for_each(|node| node.mesh = Some(mesh));
    Ok(())
}

/// A shape with its keys of lengths.
type Shape = (&'static str, &'static [(&'static str, usize)]);

fn read_shape(table: &mut Keys<'_, '_>) -> Result<Shape, SceneError> {
    let names = || SHAPES.iter().map(|(name, _)| *name);
    let allowed = format!("allowed are {}", names().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "));
    let given = table.string("shape")?.ok_or_else(|| {
        let also = if table.has("surface") { "; `surface` is for [[reflector]]" } else { "" };
        table.missing("shape", format!("missing; {allowed}{also}"))
    })?;
    SHAPES.into_iter().find(|(name, _)| *name == given.value).ok_or_else(|| {
        let hint = did_you_mean(&given.value, names());
        table.wrong("shape", given.begin, format!("there is no shape `{}`{hint}; {allowed}", given.value))
    })
}

/// The shape of these lengths, in the order of its keys.
fn solid(shape: &str, lengths: &[f32]) -> Solid {
    match (shape, lengths) {
        ("box", &[width, height, depth]) => Solid::Box([width, height, depth]),
        ("quad", &[width, height]) => Solid::Quad([width, height]),
        ("cylinder", &[radius, height]) => Solid::Cylinder(radius, height),
        ("cone", &[radius, height]) => Solid::Cone(radius, height),
        ("disk", &[radius]) => Solid::Disk(radius),
        (POINTS, &[radius]) => Solid::Point(radius),
        (_, lengths) => Solid::Sphere(lengths.first().copied().unwrap_or(1.0)),
    }
}

/// Quads and disks face along their normal, +z without one; cylinders and cones stand along their axis, y.
fn read_turn(text: Text<'_>, table: &mut Keys<'_, '_>, shape: &str) -> Result<DQuat, SceneError> {
    let (key, otherwise) = match shape {
        "quad" | "disk" => (Some("normal"), DVec3::Z),
        "cylinder" | "cone" => (Some("axis"), DVec3::Y),
        _ => (None, DVec3::Y),
    };
    let given = match key {
        Some(key) => table.numbers(key)?.map(|at| exact_direction(text, &table.field(key), at)).transpose()?,
        None => None,
    };
    let turn = table.numbers("rotation_deg")?.map_or(DQuat::IDENTITY, rotation_about_fixed_axes);
    Ok((turn * plane_rotation(given.unwrap_or(otherwise))).normalize())
}

fn read_scale(table: &mut Keys<'_, '_>) -> Result<Vec3, SceneError> {
    let Some(Located { begin, value }) = table.one_or_more("scale", 3)? else { return Ok(Vec3::ONE) };
    let scale = match value[..] {
        [one] => DVec3::splat(one),
        [x, y, z] => DVec3::new(x, y, z),
        _ => return Err(table.wrong("scale", begin, "must be one number, or three in brackets")),
    };
    let [least, most] = LENGTHS;
    if !scale.to_array().iter().all(|scale| (least..=most).contains(scale)) {
        return Err(table.wrong("scale", begin, format!("{value:?}; allowed is {least:e} to {most:e}")));
    }
    Ok(scale.as_vec3())
}

fn read_lengths(
    table: &mut Keys<'_, '_>,
    shape: &str,
    key: &'static str,
    count: usize,
) -> Result<Vec<f32>, SceneError> {
    let given = match count {
        1 => table.number(key)?.map(|at| Located { begin: at.begin, value: vec![at.value] }),
        _ => table.number_list(key, count)?,
    };
    let form = if count == 1 { "a number".into() } else { format!("{count} numbers in brackets") };
    let missing = || table.missing(key, format!("missing; the shape `{shape}` needs `{key}`, {form}"));
    let Located { begin, value } = given.ok_or_else(missing)?;
    let [least, most] = LENGTHS;
    if !value.iter().all(|length| (least..=most).contains(length)) {
        return Err(table.wrong(key, begin, format!("{value:?}; a length must be from {least:e} to {most:e}")));
    }
    Ok(value.iter().map(|length| *length as f32).collect())
}

fn read_file(text: Text<'_>, table: &mut Keys<'_, '_>) -> Result<NamedFile, SceneError> {
    let allowed = format!("a file of the kind .{}", MESHES.join(", ."));
    let given = table.string("file")?;
    let missing = || table.missing("file", format!("missing; the shape `mesh` needs `file`, {allowed}"));
    let Located { begin, value } = given.ok_or_else(missing)?;
    let kind = value.rsplit('.').next().unwrap_or_default().to_lowercase();
    if !MESHES.contains(&kind.as_str()) {
        return Err(table.wrong("file", begin, format!("`{value}`; must be {allowed}")));
    }
    Ok(NamedFile { name: value, field: format!("line {}: object.file", text.line(begin)) })
}

/// The look of an object.
struct Look {
    color: Vec3,
    picture: Option<NamedFile>,
    /// The side of a square, and the second colour.
    checker: Option<(f64, Vec3)>,
    unlit: bool,
    /// `None` for matt surfaces.
    finish: Option<Finish>,
    emission: Vec3,
    /// More than `unlit` is given.
    is_given: bool,
}

impl Look {
    fn read(text: Text<'_>, table: &mut Keys<'_, '_>, is_mark: bool) -> Result<Self, SceneError> {
        let unlit = table.boolean("unlit")?.map_or(is_mark, |at| at.value);
        let most = if unlit { MAX_RADIANCE } else { 1.0 };
        let (first, picture, side) = (table.color("color", most)?, table.string("picture")?, table.number("checker")?);
        let second = table.color("checker_color", most)?;
        let finish = Finish::read(table, unlit)?;
        let emission = table.color("emission", MAX_RADIANCE)?;
        let checker = match (side, &picture, second) {
            (Some(side), Some(_), _) => {
                return Err(table.wrong("checker", side.begin, "is not for what has a picture: leave out one of them"));
            }
            (Some(Located { begin, value }), ..) if !(LENGTHS[0]..=LENGTHS[1]).contains(&value) => {
                return Err(table.wrong("checker", begin, format!("{value}; must be the length of a square's side")));
            }
            (Some(side), None, second) => Some((side.value, second.unwrap_or(Vec3::splat(0.05)))),
            (None, _, Some(_)) => {
                return Err(table.missing("checker", "missing; `checker_color` needs `checker`, a square's side"));
            }
            (None, ..) => None,
        };
        let is_given =
            [first, emission].iter().any(Option::is_some) || picture.is_some() || checker.is_some() || finish.is_some();
        let named = |at: Located<String>| NamedFile {
            name: at.value,
            field: format!("line {}: object.picture", text.line(at.begin)),
        };
        let plain = if picture.is_some() { 1.0 } else { 0.8 };
        let color = first.unwrap_or(Vec3::splat(plain));
        let (picture, emission) = (picture.map(named), emission.unwrap_or(Vec3::ZERO));
        Ok(Self { color, picture, checker, unlit, finish, emission, is_given })
    }

    /// Adds its material, whose squares have a side in texture coordinates if that is given.
    fn add_material(self, name: &str, square: Option<f32>, (model, files): (&mut Model, &mut ObjectFiles)) -> usize {
        let mut material = Material { unlit: self.unlit, ..Material::diffuse(name, self.color) };
        if let Some((_, second)) = self.checker {
            // A texture holds colours up to 1; the factor has the rest.
            let most = self.color.max_element().max(second.max_element()).max(1.0);
            let srgb = |color: Vec3| Vec3::from((color / most).to_array().map(srgb_from_linear));
            model.textures.push(Arc::new(textures::checker(name, 2, srgb(self.color), srgb(second))));
            material.base_color = Vec3::splat(most).extend(1.0);
            let scale = square.map_or(Vec2::ONE, |square| Vec2::splat(0.5 / square));
            let texture = model.textures.len() as u32 - 1;
            let texture_from_uv = Affine2::from_scale(scale);
            material.base_texture = Some(TextureBinding { texture, uv_channel: 0, texture_from_uv });
        }
        material.emissive = self.emission;
        if let Some(finish) = &self.finish {
            finish.apply(&mut material);
        }
        model.materials.push(material);
        let number = model.materials.len() - 1;
        files.pictures.extend(self.picture.map(|picture| (number, picture)));
        number
    }
}
