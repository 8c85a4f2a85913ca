//! Pictures of environments.

use catoptric_core::error::SceneError;
use catoptric_core::scene::Environment;
use catoptric_scenes::import::load_environment;
use glam::Vec3;
use std::io::Cursor;
use std::path::Path;

/// The environment of a file of this name.
fn load(name: &str, bytes: &[u8]) -> Result<Environment, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    load_environment(&path)
}

#[test]
fn both_formats_are_read() {
    let colors = [[0.5f32, 0.25, 2.0]; 8];
    let mut hdr = Vec::new();
    let pixels: Vec<image::Rgb<f32>> = colors.iter().map(|c| image::Rgb(*c)).collect();
    image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&pixels, 4, 2).unwrap();
    let sky = load("sky.hdr", &hdr).unwrap();
    assert_eq!(sky.name, "sky.hdr");
    assert!((sky.radiance(Vec3::X) - Vec3::new(0.5, 0.25, 2.0)).length() < 0.02);

    let mut exr = Cursor::new(Vec::new());
    {
        use exr::prelude::*;
        let channels = SpecificChannels::rgb(|p: exr::math::Vec2<usize>| {
            let [r, g, b] = colors[p.y() * 4 + p.x()];
            (r, g, b)
        });
        Image::from_channels((4, 2), channels).write().to_buffered(&mut exr).unwrap();
    }
    let sky = load("sky.exr", exr.get_ref()).unwrap();
    assert_eq!(sky.radiance(Vec3::Z), Vec3::new(0.5, 0.25, 2.0));
}

#[test]
fn broken_and_huge_pictures_are_errors() {
    assert!(load("a.hdr", b"nonsense").is_err());
    assert!(load("a.exr", b"nonsense").is_err());
    let huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n";
    let message = load("huge.hdr", huge).unwrap_err().to_string();
    assert!(message.contains("huge.hdr") && message.contains("100000"), "{message}");
    let message = load_environment(Path::new("sky.png")).unwrap_err().to_string();
    assert!(message.contains(".hdr"), "{message}");
}
