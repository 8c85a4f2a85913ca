//! Scenes have the same bits on every machine: those written down here. Run it for another target to compare that
//! system's library with this one's:
//! `cargo test -p catoptric_scenes --test same_bits --target x86_64-unknown-linux-musl`.

use catoptric_core::scene::PoseOptions;
use catoptric_scenes::builtin;

/// The beginning of the BLAKE3 hash of what `write` gives.
fn bits(write: impl FnOnce(&mut dyn FnMut(&[u8]))) -> String {
    let mut hasher = blake3::Hasher::new();
    write(&mut |piece| {
        hasher.update(piece);
    });
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Everything of a scene that pictures depend on.
fn bits_of_scene(name: &str) -> String {
    // Between two keys of its motions.
    let options = PoseOptions { time: 1.3, ..PoseOptions::default() };
    let scene = builtin::parse(name).and_then(|model| model.pose(&options)).expect("there is the scene");
    bits(|sink| scene.write_identity(|_| false, sink))
}

/// Names with their bits, as one text: all that differ are shown at once.
fn listed(found: impl IntoIterator<Item = (String, String)>) -> String {
    found.into_iter().map(|(name, bits)| format!("{name} {bits}\n")).collect()
}

#[test]
fn scenes_have_the_same_bits() {
    let found = listed(builtin::all().iter().map(|scene| (scene.name.to_owned(), bits_of_scene(scene.name))));
    assert_eq!(found, include_str!("same_bits_scenes.txt"));
}
