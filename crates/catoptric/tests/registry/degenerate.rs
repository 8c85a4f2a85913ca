//! Eyes within reflectors and on them, objects without size, and scenes without objects, for every method.

use catoptric_testkit::drawing::survives;
use catoptric_testkit::scenes::{SceneBuilder, eyes_within_and_on_a_sphere, things_without_size};
use glam::Vec3;

const LAYERS: &str = "size = 8\npicture_size = 16\ncapture_samples = 1\nviewpoint_count = 2";

/// Methods with settings that are coarse enough for small pictures, and the order of these.
fn cases() -> Vec<(&'static str, String, u32)> {
    let stored = "st = 3\nuv = 8\ntransfer = 'stored'\ntransfer_st = 3\ntransfer_uv = 8";
    vec![
        ("light_field", "st = 3\nuv = 8".into(), 2),
        ("light_field", stored.into(), 2),
        ("layered_environment_map", format!("{LAYERS}\ntextures = 'projected'"), 3),
        ("layered_environment_map", format!("{LAYERS}\ntextures = 'inferred'"), 3),
        ("path_perturbation", String::new(), 2),
        ("sample_based_camera", String::new(), 2),
        // The last eye is so near that a part of one triangle fills its view: finer pieces would only take longer.
        ("explosion_map", "edge_error_px = 4.0\npiece_px = 8.0".into(), 2),
        ("reflector_search", "edge_error_px = 4.0\npiece_px = 8.0".into(), 2),
    ]
}

#[test]
fn eyes_within_reflectors_and_on_them_are_survived() {
    let (scene, eyes) = eyes_within_and_on_a_sphere();
    for (id, settings, order) in cases() {
        survives(id, &settings, &scene, &eyes, order);
    }
}

#[test]
fn things_without_size_are_survived() {
    let (scene, eyes) = things_without_size();
    for (id, settings, order) in cases() {
        survives(id, &settings, &scene, &eyes, order);
    }
}

#[test]
fn scenes_without_objects_are_survived() {
    for id in ["path_perturbation", "sample_based_camera", "explosion_map", "reflector_search"] {
        survives(id, "", &SceneBuilder::new().build(), &[(Vec3::Z, Vec3::ZERO)], 2);
    }
}
