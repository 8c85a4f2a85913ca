//! The scene with its changes as a scene file.

use crate::studio::order::{Opening, Source, Wish};
use catoptric::scene::{Projection, Role};
use catoptric_scenes::named_environment;
use glam::{DVec3, Vec3};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The text of a scene file at `path` that shows what the wish's left side shows: the scene as its base, with the view,
/// all changes and the method's settings.
///
/// # Errors
/// Scenes that are no files.
pub(in crate::app) fn text(
    (wish, origin): (&Wish, DVec3),
    (source, opened): (&Source, &Opening),
    path: &Path,
) -> Result<String, String> {
    let mut file = Table::new();
    file.insert("base".into(), Value::String(base(source, path)?));
    environment(&mut file, opened, path);
    if let Projection::Perspective { fov_y } = wish.camera.projection {
        let place = &wish.camera.world_from_camera;
        let eye = Vec3::from(place.translation);
        let camera = Table::from_iter([
            ("eye".into(), point(origin, eye)),
            ("target".into(), point(origin, eye - Vec3::from(place.matrix3.z_axis))),
            ("up".into(), vector(place.matrix3.y_axis.into())),
            ("fov_deg".into(), number(fov_y.to_degrees())),
        ]);
        file.insert("camera".into(), Value::Table(camera));
    }
    let mut put = |name: &str, table: Table| {
        if !table.is_empty() {
            file.insert(name.into(), Value::Table(table));
        }
    };
    let roles = wish.changes.roles.iter().map(|change| {
        let role = if change.role == Role::Coated { Role::Diffuse } else { change.role };
        (change.name.clone(), Value::String(role.name().into()))
    });
    put("role", roles.collect());
    let mut looks: Table = Table::new();
    for (name, look) in &wish.changes.looks {
        let mut table = Table::new();
        table.extend(look.color.map(|color| ("color".into(), vector(color))));
        table.extend(look.roughness.map(|value| ("roughness".into(), number(value))));
        table.extend(look.ior.map(|value| ("ior".into(), number(value))));
        table.extend(look.priority.map(|value| ("priority".into(), Value::Integer(value.into()))));
        looks.insert(name.clone(), Value::Table(table));
    }
    // The index of refraction of glass that was made by hand.
    for change in wish.changes.roles.iter().filter(|change| change.role == Role::Lens) {
        let entry = looks.entry(change.name.clone()).or_insert_with(|| Value::Table(Table::new()));
        if let (Value::Table(look), Some(ior)) = (entry, change.ior) {
            look.entry("ior").or_insert_with(|| number(ior));
        }
    }
    looks.retain(|_, look| look.as_table().is_some_and(|look| !look.is_empty()));
    put("material", looks);
    put("move", wish.changes.moves.iter().map(|(name, by)| (name.clone(), vector(*by))).collect());
    let drawn = wish.sides.iter().filter(|side| !side.settings.is_empty());
    put("method", drawn.map(|side| (side.method.clone(), Value::Table(side.settings.clone()))).collect());
    toml::to_string(&file).map_err(|error| error.to_string())
}

/// The light and the variant with which a scene was opened.
fn environment(file: &mut Table, opened: &Opening, path: &Path) {
    let Opening { environment, environment_edit: edit, variant, .. } = opened;
    if let Some(environment) = environment {
        let is_name = named_environment(&environment.to_string_lossy()).is_some();
        let word = if is_name { environment.to_string_lossy().into_owned() } else { beside(environment, path) };
        file.insert("environment".into(), Value::String(word));
    }
    let mut put = |key: &str, number: Option<f64>| {
        number.map(|number| file.insert(key.into(), Value::Float(number)));
    };
    put("environment_rotation_deg", edit.rotation_deg);
    put("environment_strength", edit.strength);
    file.extend(variant.iter().map(|name| ("variant".into(), Value::String(name.clone()))));
}

/// A number with the fewest digits that are it.
fn number(value: f32) -> Value {
    Value::Float(value.to_string().parse().unwrap_or(f64::from(value)))
}

/// A point of a scene in the coordinates of its file.
fn point(origin: DVec3, value: Vec3) -> Value {
    match origin {
        DVec3::ZERO => vector(value),
        origin => Value::Array((origin + value.as_dvec3()).to_array().into_iter().map(Value::Float).collect()),
    }
}

fn vector(value: Vec3) -> Value {
    Value::Array(value.to_array().into_iter().map(number).collect())
}

/// The word by which a file at `path` names the scene: relative where the scene lies beside or beneath it.
fn base(source: &Source, path: &Path) -> Result<String, String> {
    let file = match source {
        Source::Builtin(_) => return Ok(source.word()),
        Source::Bytes { name, .. } => return Err(format!("`{name}` came from elsewhere: save it as a file first")),
        Source::File(file) => file,
    };
    Ok(beside(file, path))
}

/// The name of a file in another one: relative where it lies beside or beneath that.
fn beside(file: &Path, path: &Path) -> String {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (file, folder) = (whole(file), whole(path).parent().map(PathBuf::from).unwrap_or_default());
    let relative = file.strip_prefix(&folder).unwrap_or(&file);
    relative.to_string_lossy().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::order::{Changes, Drawn, RoleChange};
    use catoptric::methods::Quality;
    use catoptric::scene::edits::Look;
    use catoptric::scene::{Camera, PoseOptions};
    use catoptric_scenes::{builtin, import};

    #[test]
    fn a_saved_scene_is_what_was_shown() {
        let model = builtin::parse("sphere_room").unwrap();
        let before = model.pose(&PoseOptions::default()).unwrap();
        let camera = Camera::look_at("", Vec3::new(0.3, 1.7, 3.1), Vec3::new(0.1, 0.9, 0.2), Vec3::Y, 37.0);
        let quality = Quality { samples: 4, order: 2 };
        let settings: Table = toml::from_str("parallax = 'box'").unwrap();
        let mut changes = Changes::default();
        let glass = RoleChange { name: "sphere".into(), role: Role::Lens, ior: Some(1.7) };
        changes.roles.push(glass);
        changes.looks.insert("sphere".into(), Look { color: Some(Vec3::new(0.5, 0.75, 1.0)), ..Look::default() });
        changes.moves.insert("sphere".into(), Vec3::new(0.25, 0.0, -0.125));
        let sides = vec![Drawn { method: "environment_map".into(), settings, quality }];
        let (size, overlays) = ([64, 64], Vec::new());
        let wish = Wish {
            scene: 1,
            time: 0.0,
            clip: None,
            changes,
            camera,
            size,
            sides,
            has_automatic_order: false,
            display: Default::default(),
            compares: false,
            overlays,
        };
        let shown = model.pose(&wish.changes.pose_at(0.0).unwrap()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("saved.toml");
        let opened = Opening { environment: Some("sky".into()), ..Opening::default() };
        let source = Source::of_word("builtin:sphere_room");
        std::fs::write(&path, text((&wish, DVec3::ZERO), (&source, &opened), &path).unwrap()).unwrap();
        let loaded = import::load(&path).unwrap();
        let scene = loaded.pose(&PoseOptions::default()).unwrap();
        assert_eq!((&scene.positions, &scene.normals), (&shown.positions, &shown.normals));
        assert_ne!(scene.positions, before.positions);
        let ball = scene.objects.iter().position(|object| object.name == "sphere").unwrap() as u32;
        assert_eq!(scene.material_of(ball), shown.material_of(ball));
        let place = scene.camera(None, 1.0).unwrap().world_from_camera;
        assert!(place.abs_diff_eq(wish.camera.world_from_camera, 1e-5));
        assert!(model.environment.is_none() && loaded.environment.is_some());
        assert_eq!(loaded.method_settings["environment_map"]["parallax"].as_str(), Some("box"));
    }
}
