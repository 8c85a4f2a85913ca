//! Any text as a scene file of ours.
#![no_main]

use catoptric_core::scene::PoseOptions;
use catoptric_scenes::import::toml_scene;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(scene) = toml_scene::parse("fuzz", text) else { return };
    if let Ok(scene) = scene.model.pose(&PoseOptions::default()) {
        assert!(scene.positions.iter().chain(&scene.normals).all(|vector| vector.is_finite()));
    }
});
