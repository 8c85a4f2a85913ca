//! Any bytes as a Wavefront `.obj` file.
#![no_main]

use catoptric_core::scene::PoseOptions;
use catoptric_scenes::import::{NoFiles, obj};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(model) = obj::from_slice("fuzz", bytes, &NoFiles) else { return };
    if let Ok(scene) = model.pose(&PoseOptions::default()) {
        assert!(scene.positions.iter().chain(&scene.normals).all(|vector| vector.is_finite()));
    }
});
