//! The command line that makes the same picture.

use super::super::state::Viewer;
use crate::studio::order::{Drawn, Opening, RoleChange, Source, Wish};
use catoptric::methods::Quality;
use catoptric::output::shell_word;
use catoptric::scene::{Projection, Role};
use catoptric::tone::Display;
use glam::{DVec3, Vec3};

/// The command that draws the left side, to be typed or pasted.
///
/// # Errors
/// Pictures that no command describes: of scenes that are no files, with objects that were moved or painted, or by
/// orthographic cameras that were moved.
pub(super) fn of(viewer: &Viewer) -> Result<String, String> {
    let wish = viewer.sent.as_ref().ok_or("there is no picture yet")?;
    if let Source::Bytes { name, .. } = &viewer.source {
        return Err(format!("`{name}` came from the browser: save it as a file to draw it by a command"));
    }
    if !wish.changes.looks.is_empty() || !wish.changes.moves.is_empty() {
        return Err(
            "what was moved or painted by hand cannot be written as a command: save the scene and draw its file".into(),
        );
    }
    let camera = viewer.camera.filter(|_| viewer.scene.as_ref().is_some_and(|scene| scene.cameras.len() > 1));
    let origin = viewer.scene.as_ref().map_or(DVec3::ZERO, |scene| scene.origin);
    let mut words = words((wish, origin), &viewer.source.word(), camera, viewer.camera.is_some())?;
    words.splice(3..3, opening(&viewer.opened, wish.clip));
    Ok(words.iter().map(|word| shell_word(word)).collect::<Vec<_>>().join(" "))
}

fn words(
    (wish, origin): (&Wish, DVec3),
    scene: &str,
    camera: Option<usize>,
    is_own_camera: bool,
) -> Result<Vec<String>, String> {
    let drawn = &wish.sides[0];
    let mut words: Vec<String> = ["catoptric", "render", scene].map(String::from).to_vec();
    let mut option = |name: &str, value: String| words.push(format!("--{name}={value}"));
    option("size", format!("{}x{}", wish.size[0], wish.size[1]));
    match (camera, is_own_camera) {
        (Some(index), true) => option("camera", index.to_string()),
        (None, true) => {}
        _ => {
            let Projection::Perspective { fov_y } = wish.camera.projection else {
                return Err("an orthographic camera that was moved cannot be written as a command".into());
            };
            let place = &wish.camera.world_from_camera;
            let vector = |v: Vec3| format!("{},{},{}", v.x, v.y, v.z);
            let eye = Vec3::from(place.translation);
            let in_file = |point: Vec3| match origin {
                DVec3::ZERO => vector(point),
                origin => (origin + point.as_dvec3()).to_array().map(|number| number.to_string()).join(","),
            };
            option("eye", in_file(eye));
            option("target", in_file(eye - Vec3::from(place.matrix3.z_axis)));
            option("up", vector(place.matrix3.y_axis.into()));
            option("fov", fov_y.to_degrees().to_string());
        }
    }
    if wish.time > 0.0 {
        option("time", wish.time.to_string());
    }
    for RoleChange { name, role, ior } in &wish.changes.roles {
        match (role, ior) {
            (Role::Reflector, _) => option("reflector", name.clone()),
            (Role::Lens, Some(ior)) => option("lens", format!("{name}:{ior}")),
            (Role::Lens, None) => option("lens", name.clone()),
            (Role::Diffuse | Role::Coated, _) => option("diffuse", name.clone()),
        }
    }
    words.extend(method(drawn));
    words.extend(quality(wish));
    words.extend(display(wish.display));
    words.extend(["-o", "picture.png"].map(String::from));
    Ok(words)
}

/// The options for how a scene was opened, but for roles, which are among the changes, and for what it plays.
fn opening(opened: &Opening, clip: Option<usize>) -> Vec<String> {
    let Opening { environment, environment_edit: edit, variant, allow_outside, .. } = opened;
    let mut words: Vec<String> = Vec::new();
    words.extend(environment.iter().map(|path| format!("--environment={}", path.display())));
    words.extend(edit.rotation_deg.map(|degrees| format!("--environment-rotation={degrees}")));
    words.extend(edit.strength.map(|factor| format!("--environment-strength={factor}")));
    words.extend(variant.iter().map(|name| format!("--variant={name}")));
    words.extend(allow_outside.then(|| "--allow-outside".into()));
    words.extend(clip.map(|index| format!("--animation={index}")));
    words.extend(beside_scene_file(opened));
    words
}

/// The options for what scene files do not say of how a scene was opened.
pub(super) fn beside_scene_file(opened: &Opening) -> Vec<String> {
    let glass = opened.has_solid_glass.then(|| "--thin-glass=solid".into());
    let shadows = match (opened.lacks_shadows, opened.lacks_bounces) {
        (true, _) => Some("--shadows=off".into()),
        (false, true) => Some("--shadows=direct".into()),
        (false, false) => None,
    };
    glass.into_iter().chain(shadows).collect()
}

/// The options for a method and its settings.
pub(super) fn method(drawn: &Drawn) -> Vec<String> {
    let all = settings(drawn).map(|setting| format!("--set={setting}"));
    std::iter::once(format!("--method={}", drawn.method)).chain(all).collect()
}

/// A method's settings as `KEY=VALUE`.
pub(super) fn settings(drawn: &Drawn) -> impl Iterator<Item = String> {
    drawn.settings.iter().map(|(key, value)| {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        format!("{key}={value}")
    })
}

fn quality(wish: &Wish) -> [String; 2] {
    let Quality { samples, order } = wish.sides[0].quality;
    let order = if wish.has_automatic_order { "auto".into() } else { order.to_string() };
    [format!("--samples={samples}"), format!("--order={order}")]
}

/// The options for the exposure and the tone curve.
fn display(Display { exposure_stops, curve }: Display) -> [String; 2] {
    [format!("--exposure={exposure_stops}"), format!("--tone={}", curve.name())]
}

/// The options for the view of a saved scene, which has the camera if that is a perspective one; `camera` is the
/// scene's own, if it is that.
///
/// # Errors
/// Orthographic cameras that were moved.
#[cfg(not(target_family = "wasm"))]
pub(super) fn view(wish: &Wish, camera: Option<usize>) -> Result<Vec<String>, String> {
    let mut words = vec![format!("--size={}x{}", wish.size[0], wish.size[1]), format!("--time={}", wish.time)];
    if !matches!(wish.camera.projection, Projection::Perspective { .. }) {
        let camera = camera.ok_or("an orthographic camera that was moved cannot be told to the program")?;
        words.push(format!("--camera={camera}"));
    }
    words.extend(quality(wish));
    words.extend(display(wish.display));
    Ok(words)
}
