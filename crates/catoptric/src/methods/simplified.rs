//! Warnings about mirrors and lenses that a method draws simpler than they are.

use crate::scene::{Material, Role, Scene};

/// The warning that rough mirrors are drawn as smooth ones; `None` if the scene has none.
pub(crate) fn rough_mirrors(scene: &Scene) -> Option<String> {
    let names = named(scene, |material| material.reflection_roughness() > 0.0)?;
    Some(format!("rough mirrors are drawn as smooth ones: {names} (`multiperspective` blurs what they reflect)"))
}

/// The warning that normal maps of mirrors and lenses are not drawn; `None` if the scene has none.
pub(crate) fn bumpy_surfaces(scene: &Scene) -> Option<String> {
    let names = named(scene, |material| material.turning_map().is_some())?;
    Some(format!("bumpy surfaces reflect and refract as smooth ones: {names} (`multiperspective` draws normal maps)"))
}

/// The names of mirrors and lenses whose materials are such.
fn named(scene: &Scene, is_such: impl Fn(&Material) -> bool) -> Option<String> {
    /// More are counted, not named.
    const NAMED: usize = 3;
    let such = (0..scene.objects.len() as u32).filter(|&object| {
        let material = scene.material_of(object);
        material.role != Role::Diffuse && is_such(material)
    });
    let mut names: Vec<&str> = such.map(|object| scene.objects[object as usize].name.as_str()).collect();
    names.dedup();
    let more = names.len().saturating_sub(NAMED);
    names.truncate(NAMED);
    let all = names.join(", ");
    match (names.is_empty(), more) {
        (true, _) => None,
        (_, 0) => Some(all),
        _ => Some(format!("{all} and {more} more")),
    }
}
