//! `catoptric info`: what is in a scene.

use super::{columns, pretty};
use crate::args::{InfoArgs, SceneArgs, Shadows};
use crate::failure::Failure;
use crate::failure::text;
use crate::scene_source;
use catoptric::math::Aabb;
use catoptric::progress::Silent;
use catoptric::scene::model::Animation;
use catoptric::scene::{AlphaMode, Camera, LightKind, Material, Model, Projection, Role, Scene};
use clap::ArgMatches;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

pub(crate) fn run(args: &InfoArgs, options: &ArgMatches) -> Result<String, Failure> {
    let roles = scene_source::roles(&args.scene, options)?;
    let SceneArgs { scene, environment, pose, .. } = &args.scene;
    let mut model = scene_source::load(scene, &pose.choice, environment, !roles.is_empty())?;
    let mut clips = clips(&model);
    if let Some(chosen) = scene_source::choose_animation(&pose.choice, &mut model)? {
        clips.iter_mut().enumerate().for_each(|(index, clip)| clip.plays = index == chosen);
    }
    let scene = scene_source::pose(&model, pose.time, &roles, Shadows::Off, None, &Silent)?;
    scene_source::remark_on_bodies(&mut model, &scene);
    model.warnings.extend(scene_source::remark_on_time(&model, pose.time));
    if args.format.json { pretty(&as_json(&model, &scene, &clips)) } else { Ok(as_text(&model, &scene, &clips)) }
}

/// An animation of the file.
#[derive(serde::Serialize)]
struct Clip {
    name: String,
    channels: usize,
    /// In seconds.
    duration: f32,
    /// True if it moves something.
    plays: bool,
}

fn clips(model: &Model) -> Vec<Clip> {
    let playing = model.playing();
    let clip = |(index, animation): (usize, &Animation)| Clip {
        name: animation.name.clone(),
        channels: animation.channels.len(),
        duration: animation.duration(),
        plays: playing.contains(&index),
    };
    model.animations.iter().enumerate().map(clip).collect()
}

fn as_json(model: &Model, scene: &Scene, clips: &[Clip]) -> Value {
    let objects = scene.objects.iter().map(|object| {
        let material = &scene.materials[object.material as usize];
        json!({
            "name": object.name,
            "role": material.role.name(),
            "material": material.name,
            "triangles": object.triangles.len(),
            "vertices": object.vertices.len(),
            "surface": object.surface.as_ref().map(|placed| placed.surface.kind()),
            "inside": object.inside,
            "bounds": bounds_json(scene, &object.bounds),
        })
    });
    let materials = scene.materials.iter().map(|material| {
        json!({
            "name": material.name,
            "role": material.role.name(),
            "base_color": material.base_color.to_array(),
            "base_texture": material.base_texture.as_ref().map(|binding| binding.texture),
            "unlit": material.unlit,
            "blend": material.blend.as_ref().map(|blend| json!({
                "fresnel": blend.fresnel,
                "attenuation": blend.attenuation.map(|attenuation| json!({
                    "distance": attenuation.distance, "specularity": attenuation.specularity,
                })),
                "diffuse": blend.diffuse.map(|diffuse| diffuse.to_array()),
            })),
            "lobes": material.lobes().map(|lobes| json!({
                "metallic": material.microfacets.as_ref().map(|facets| facets.metallic),
                "roughness": material.microfacets.as_ref().map(|facets| facets.roughness),
                "transmission": lobes.transmission,
                "thin": lobes.is_thin,
                "coat": material.coat,
                "sheen": lobes.sheen.to_array(),
                "blends": material.alpha_mode == AlphaMode::Blend,
            })),
            "ior": if matches!(material.role, Role::Lens | Role::Coated) { Some(material.ior) } else { None },
        })
    });
    let cameras = scene.cameras.iter().enumerate().map(|(index, camera)| {
        let (kind, field) = projection(camera);
        let eye = point_json(scene, camera.world_from_camera.translation.into());
        json!({ "index": index, "name": camera.name, "kind": kind, "eye": eye, field.0: field.1 })
    });
    let lights = scene.lights.iter().map(|light| {
        json!({
            "kind": light_kind(light.kind),
            "intensity": light.intensity.to_array(),
            "position": point_json(scene, light.position),
            "direction": light.direction.to_array(),
        })
    });
    let textures = scene.textures.iter().map(|texture| {
        let (width, height) = texture.size();
        json!({ "name": texture.name, "size": [width, height], "bytes": texture.byte_count() })
    });
    as_written(json!({
        "scene": model.name,
        "triangles": scene.triangles.len(),
        "vertices": scene.positions.len(),
        "bounds": bounds_json(scene, &scene.bounds),
        "objects": objects.collect::<Vec<_>>(),
        "materials": materials.collect::<Vec<_>>(),
        "cameras": cameras.collect::<Vec<_>>(),
        "lights": lights.collect::<Vec<_>>(),
        "environment": scene.environment.as_ref().map(|environment| environment.name.clone()),
        "textures": textures.collect::<Vec<_>>(),
        "variants": model.variants,
        "variant": model.variant,
        "animations": clips,
        "duration": model.duration(),
        "region": scene.region.as_ref().map(|region| bounds_json(scene, region)),
        "methods": model.method_settings,
        "warnings": model.warnings,
    }))
}

/// The same values with numbers of single precision by their fewest digits: 0.1, not 0.10000000149011612.
fn as_written(value: Value) -> Value {
    match value {
        Value::Number(number) => match number.as_f64() {
            Some(double) if number.is_f64() && f64::from(double as f32) == double => {
                (double as f32).to_string().parse::<f64>().map_or(Value::Number(number), Value::from)
            }
            _ => Value::Number(number),
        },
        Value::Array(values) => values.into_iter().map(as_written).collect(),
        Value::Object(fields) => fields.into_iter().map(|(name, value)| (name, as_written(value))).collect(),
        other => other,
    }
}

fn as_text(model: &Model, scene: &Scene, clips: &[Clip]) -> String {
    let mut text = format!("{}\n", text::name(&model.name));
    let specular = scene.specular_objects().len();
    text += &format!(
        "{} triangles, {} vertices, {} objects ({specular} reflectors or lenses), bounds {}\n",
        scene.triangles.len(),
        scene.positions.len(),
        scene.objects.len(),
        bounds_text(scene, &scene.bounds)
    );
    section(&mut text, "Objects", &scene.objects, |object| {
        let material = &scene.materials[object.material as usize];
        let shape = match &object.surface {
            Some(placed) => placed.surface.kind().to_owned(),
            None => format!("{} triangles", object.triangles.len()),
        };
        vec![shown(&object.name), material.role.name().into(), shape, format!("material {}", shown(&material.name))]
    });
    section(&mut text, "Materials", &scene.materials, |material| {
        let [r, g, b, _] = material.base_color.to_array();
        let mut row = vec![shown(&material.name), material.role.name().into(), format!("colour {r:.3} {g:.3} {b:.3}")];
        if material.bindings().next().is_some() {
            row.push("textured".into());
        }
        if material.unlit {
            row.push("unlit".into());
        }
        row.extend(lobes(material));
        if let Some(blend) = &material.blend {
            let weights = [("by angle", blend.fresnel.is_some()), ("by distance", blend.attenuation.is_some())];
            row.extend(weights.into_iter().filter(|(_, given)| *given).map(|(what, _)| format!("blended {what}")));
        }
        if matches!(material.role, Role::Lens | Role::Coated) {
            row.push(format!("ior {}", material.ior));
        }
        row
    });
    section(&mut text, "Cameras", &scene.cameras, |camera| {
        let eye = Vec3::from(camera.world_from_camera.translation);
        let (kind, (field, value)) = projection(camera);
        vec![shown(&camera.name), kind.into(), format!("{field} {value:.3}"), format!("eye {}", point_text(scene, eye))]
    });
    section(&mut text, "Lights", &scene.lights, |light| {
        vec![light_kind(light.kind).into(), format!("intensity {}", vector_text(light.intensity))]
    });
    section(&mut text, "Textures", &scene.textures, |texture| {
        let (width, height) = texture.size();
        vec![shown(&texture.name), format!("{width}x{height}")]
    });
    section(&mut text, "Variants", &model.variants, |variant| {
        let chosen = if model.variant.as_ref() == Some(variant) { "chosen" } else { "" };
        vec![shown(variant), chosen.into()]
    });
    section(&mut text, "Animations", clips, |clip| {
        let plays = if clip.plays { "plays" } else { "" };
        vec![shown(&clip.name), format!("{} s", clip.duration), format!("{} channels", clip.channels), plays.into()]
    });
    if let Some(environment) = &scene.environment {
        text += &format!("\nEnvironment: {}\n", text::name(&environment.name));
    }
    section(&mut text, "Warnings", &model.warnings, |warning| vec![text::one_line(warning)]);
    text
}

/// The lines about a surface's lobes: roughness, shares above 0 and the like.
fn lobes(material: &Material) -> Vec<String> {
    let (Some(lobes), Some(facets)) = (material.lobes(), &material.microfacets) else { return Vec::new() };
    let thin = if lobes.is_thin { "thin wall" } else { "transmission" };
    let shares = [
        ("metal", facets.metallic),
        (thin, lobes.transmission),
        ("light through", lobes.diffuse_transmission),
        ("coat", material.coat),
        ("sheen", lobes.sheen.max_element()),
        ("film", lobes.film.as_ref().map_or(0.0, |film| film.share)),
        ("anisotropy", lobes.anisotropy),
        ("dispersion", lobes.dispersion),
    ];
    let mut shown = vec![format!("roughness {:.2}", facets.roughness)];
    shown.extend(shares.iter().filter(|(_, share)| *share > 0.0).map(|(name, share)| format!("{name} {share:.2}")));
    if material.alpha_mode == AlphaMode::Blend {
        shown.push("blended".into());
    }
    shown
}

fn section<T>(text: &mut String, title: &str, items: &[T], row: impl Fn(&T) -> Vec<String>) {
    if items.is_empty() {
        return;
    }
    *text += &format!("\n{title} ({})\n", items.len());
    let rows: Vec<Vec<String>> =
        items.iter().enumerate().map(|(index, item)| [vec![format!("  {index}")], row(item)].concat()).collect();
    *text += &columns(&rows);
}

fn shown(name: &str) -> String {
    if name.is_empty() { "(no name)".into() } else { text::name(name) }
}

fn projection(camera: &Camera) -> (&'static str, (&'static str, f32)) {
    match camera.projection {
        Projection::Perspective { fov_y } => ("perspective", ("fov_deg", degrees(fov_y))),
        Projection::Orthographic { half_height } => ("orthographic", ("half_height", half_height)),
    }
}

/// An angle in degrees without the digits that radians of single precision add to it.
fn degrees(radians: f32) -> f32 {
    ((f64::from(radians).to_degrees() * 1e4).round() / 1e4) as f32
}

fn light_kind(kind: LightKind) -> &'static str {
    match kind {
        LightKind::Directional => "directional",
        LightKind::Point { .. } => "point",
        LightKind::Spot { .. } => "spot",
    }
}

fn bounds_json(scene: &Scene, bounds: &Aabb) -> Value {
    if bounds.is_empty() {
        return Value::Null;
    }
    json!({ "min": point_json(scene, bounds.min), "max": point_json(scene, bounds.max) })
}

/// A point of a scene in the coordinates of its file.
fn point_json(scene: &Scene, point: Vec3) -> Value {
    match scene.origin {
        DVec3::ZERO => json!(point.to_array()),
        origin => json!((origin + point.as_dvec3()).to_array()),
    }
}

fn point_text(scene: &Scene, point: Vec3) -> String {
    let point = scene.origin + point.as_dvec3();
    // Three decimals tell nothing of tiny scenes.
    match f64::from(scene.bounds.diagonal()).max(scene.origin.length()) {
        size if size > 0.0 && size < 0.1 => format!("({:.3e}, {:.3e}, {:.3e})", point.x, point.y, point.z),
        _ => format!("({:.3}, {:.3}, {:.3})", point.x, point.y, point.z),
    }
}

fn bounds_text(scene: &Scene, bounds: &Aabb) -> String {
    if bounds.is_empty() {
        "none".into()
    } else {
        format!("{} to {}", point_text(scene, bounds.min), point_text(scene, bounds.max))
    }
}

fn vector_text(vector: Vec3) -> String {
    format!("({:.3}, {:.3}, {:.3})", vector.x, vector.y, vector.z)
}
