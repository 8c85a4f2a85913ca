//! Any bytes as a glTF or GLB file: an error or a scene without a number that is none.
#![no_main]

use catoptric_core::scene::PoseOptions;
use catoptric_scenes::import::{NoFiles, gltf};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(model) = gltf::from_slice("fuzz", bytes, &NoFiles) else { return };
    if let Ok(scene) = model.pose(&PoseOptions { time: 0.4, ..PoseOptions::default() }) {
        assert!(scene.positions.iter().chain(&scene.normals).all(|vector| vector.is_finite()));
    }
});
