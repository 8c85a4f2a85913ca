//! Files of pictures.

use catoptric_core::error::SceneError;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::picture::{PictureFormat, encode_mask, read, read_channel, write};
use std::path::Path;

fn sample() -> Framebuffer {
    let mut picture = Framebuffer::new(5, 3);
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        *pixel = [index as f32 * 0.25, 0.5, 1e-4, 1.0];
    }
    picture
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn exr_keeps_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, &sample()).unwrap();
    assert_eq!(read(&path).unwrap(), sample());
    assert_eq!(names(folder.path()), ["a.exr"]);
}

#[test]
fn png_is_srgb_rounded_to_8_bits() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.PNG");
    write(&path, &sample()).unwrap();
    let back = read(&path).unwrap();
    assert_eq!((back.width, back.height), (5, 3));
    assert_eq!(back.to_srgb8(), sample().to_srgb8());
}

#[test]
fn masks_hold_shares_of_pixels() {
    let shares = [1.0, 0.25, 0.0];
    let png = encode_mask(PictureFormat::Png, 3, 1, &shares).unwrap();
    assert_eq!(image::load_from_memory(&png).unwrap().into_luma8().into_raw(), [255, 64, 0]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mask.exr");
    std::fs::write(&path, encode_mask(PictureFormat::Exr, 3, 1, &shares).unwrap()).unwrap();
    assert_eq!(read_channel(&path, &["Y"]).unwrap(), (3, 1, shares.to_vec()));
    for format in [PictureFormat::Png, PictureFormat::Exr] {
        assert!(encode_mask(format, 2, 2, &shares).is_err(), "{format:?}");
    }
    assert!(encode_mask(PictureFormat::Jpeg, 3, 1, &shares).is_err());
}

#[test]
fn files_that_cannot_be_written_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no/where.png");
    let message = write(&missing, &sample()).unwrap_err().to_string();
    assert!(message.contains("where.png") && message.contains("does not exist"), "{message}");
    assert!(matches!(write(&folder.path().join("a.bmp"), &sample()), Err(SceneError::Unsupported { .. })));
    assert!(names(folder.path()).is_empty());
}

#[test]
fn what_is_no_picture_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    for bytes in [&b""[..], b"nonsense", b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01broken", b"#?RADIANCE\n"] {
        std::fs::write(&path, bytes).unwrap();
        assert!(matches!(read(&path), Err(SceneError::Invalid { .. })), "{bytes:?}");
    }
    assert!(matches!(read(&folder.path().join("none.png")), Err(SceneError::Read { .. })));
}
