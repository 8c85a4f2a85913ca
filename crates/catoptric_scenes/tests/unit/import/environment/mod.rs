//! Pictures of environments.

mod exr;
mod hdr;
mod unfolded;

use catoptric_core::error::SceneError;
use catoptric_core::scene::Environment;
use catoptric_scenes::import::load_environment;
use glam::Vec3;
use std::io::Cursor;
use std::path::Path;

/// The environment of a file of this name, and the warnings about it but for that about proportions: most pictures here
/// are as small as can be.
fn load_with_warnings(name: &str, bytes: &[u8]) -> Result<(Environment, Vec<String>), SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let mut warnings = Vec::new();
    let loaded = load_environment(&path, &mut warnings);
    warnings.retain(|warning| !warning.contains("stretched"));
    loaded.map(|environment| (environment, warnings))
}

/// The environment of a file of this name.
fn load(name: &str, bytes: &[u8]) -> Result<Environment, SceneError> {
    load_with_warnings(name, bytes).map(|(environment, _)| environment)
}

/// The picture of a sound file, without a warning.
fn picture(name: &str, bytes: &[u8]) -> Vec<[f32; 3]> {
    let (environment, warnings) = load_with_warnings(name, bytes).expect("a sound file");
    assert_eq!(warnings, [""; 0]);
    environment.picture().2.to_vec()
}

/// The message about a file that is refused.
fn refusal(name: &str, bytes: &[u8]) -> String {
    let Err(error) = load(name, bytes) else { panic!("{name} is to be refused") };
    let message = error.to_string();
    assert!(message.contains(name), "{message}");
    message
}

/// No byte that is changed and no end that is cut off is worse than an error.
fn survives(name: &str, bytes: &[u8]) {
    for end in (0..bytes.len()).step_by(7) {
        assert!(load(name, &bytes[..end]).is_err(), "cut off after {end} bytes");
    }
    for place in 0..bytes.len() {
        let mut broken = bytes.to_vec();
        broken[place] ^= [0x01u8, 0x80, 0xff][place % 3];
        if let Err(error) = load(name, &broken) {
            assert!(error.to_string().contains(name));
        }
    }
}

/// A picture for screens of one colour, encoded.
fn for_screens(color: [u8; 3], format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image::RgbImage::from_pixel(16, 8, image::Rgb(color)).write_to(&mut bytes, format).expect("it is encoded");
    bytes.into_inner()
}

#[test]
fn pictures_for_screens_become_linear_with_a_warning() {
    use image::ImageFormat::{Jpeg, Png, WebP};
    for (name, format) in [("sky.png", Png), ("sky.jpg", Jpeg), ("sky.webp", WebP)] {
        // By the standard's formula 188 is 0.5029 of white.
        let (sky, warnings) = load_with_warnings(name, &for_screens([255, 188, 0], format)).expect("a sound file");
        let expected = Vec3::new(1.0, 0.5029, 0.0);
        let allowed = if format == Jpeg { 0.02 } else { 2e-4 };
        assert!((sky.radiance(Vec3::X) - expected).length() < allowed, "{name}: {}", sky.radiance(Vec3::X));
        let [warning] = &warnings[..] else { panic!("{name}: {warnings:?}") };
        assert!(warning.contains(name) && warning.contains("8-bit"), "{warning}");
    }
    assert!(refusal("sky.png", &for_screens([9; 3], Png)[..60]).contains("cut off"));
}

/// Names do not matter: content does.
#[test]
fn content_decides_the_kind() {
    let (_, warnings) = load_with_warnings("sky.hdr", &for_screens([9; 3], image::ImageFormat::Png)).unwrap();
    assert_eq!(warnings.len(), 1);
    assert_eq!(picture("sky.hdr", &exr::flat(2, 1, [0.5, 0.25, 2.0])), [[0.5, 0.25, 2.0]; 2]);
}

#[test]
fn what_is_no_environment_is_told_with_the_remedy() {
    for (name, named) in [("sky.hdr", "#?RADIANCE"), ("sky.exr", "OpenEXR"), ("sky.txt", ".hdr")] {
        let message = refusal(name, b"nonsense");
        assert!(message.contains(named) && message.contains("save it"), "{message}");
    }
    let message = load_environment(Path::new("moon"), &mut Vec::new()).unwrap_err().to_string();
    for named in ["moon", "no such file", ".exr", "studio, sky"] {
        assert!(message.contains(named), "{message}");
    }
    assert_eq!(load_environment(Path::new("studio"), &mut Vec::new()).unwrap().name, "studio");
}
