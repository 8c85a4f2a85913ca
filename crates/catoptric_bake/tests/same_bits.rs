//! Bakes have the same bits on every machine: those written down here. Run it for another target to compare that
//! system's library with this one's:
//! `cargo test -p catoptric_bake --test same_bits --target x86_64-unknown-linux-musl`.

use catoptric::methods::{self, Quality};
use catoptric::scene::{PoseOptions, Scene};
use catoptric_bake::{MethodBake, Work};
use catoptric_scenes::builtin;

fn scene(spec: &str) -> Scene {
    // Between two keys of its motions.
    let options = PoseOptions { time: 1.3, ..PoseOptions::default() };
    builtin::parse(spec).expect("there is the scene").pose(&options).expect("it has a pose then")
}

/// All units of a bake.
fn bits_of_bake(spec: &str, method: &str, settings: &str) -> String {
    let (scene, settings) = (scene(spec), toml::from_str(settings).expect("the settings are valid"));
    let method = methods::find(method).expect("there is the method");
    let bake = MethodBake::new(method, &settings, &scene, Quality { samples: 1, order: 3 }).expect("it can be baked");
    let identity = bake.identity().expect("it has units");
    let units = bake.units().expect("they can be made");
    let mut hasher = blake3::Hasher::new();
    for batch in identity.batches() {
        for payload in units.batch(batch).expect("it is made") {
            hasher.update(&payload.bytes);
        }
    }
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Names with their bits, as one text: all that differ are shown at once.
fn listed(found: impl IntoIterator<Item = (String, String)>) -> String {
    found.into_iter().map(|(name, bits)| format!("{name} {bits}\n")).collect()
}

#[test]
fn bakes_have_the_same_bits() {
    // Rough and coloured glass, textures, lights, curved reflectors, environments, and surfaces by formulas.
    let bakes = [
        ("glass_sphere?tess=12", "light_field", "st = 2\nuv = 8"),
        ("sphere_room?tess=12", "light_field", "st = 2\nuv = 8\ncompression = 'bc1'"),
        ("vase?tess=12", "light_field", "st = 2\nuv = 8\ncompression = 'bc6h'"),
        ("glass_sphere?tess=12", "layered_environment_map", "size = 16\ncapture_samples = 1"),
        ("two_spheres?tess=12", "sample_based_camera", "mode = 'morph'\ngrid = '3x3x2'\nnode_size = 32"),
        (
            "two_spheres?tess=12",
            "layered_environment_map",
            "size = 16\npicture_size = 32\ncapture_samples = 1\nviewpoint_count = 3\ntextures = 'inferred'",
        ),
    ];
    let found = listed(
        bakes.map(|(scene, method, settings)| (format!("{scene} {method}"), bits_of_bake(scene, method, settings))),
    );
    assert_eq!(found, include_str!("same_bits_bakes.txt"));
}
