//! GLB containers.

use super::*;
use catoptric_core::error::SceneError;
use glam::Vec3;

const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

fn glb(chunks: &[(u32, &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, data) in chunks {
        body.extend((data.len() as u32).to_le_bytes());
        body.extend(kind.to_le_bytes());
        body.extend(*data);
    }
    let mut file = b"glTF".to_vec();
    file.extend(2u32.to_le_bytes());
    file.extend((12 + body.len() as u32).to_le_bytes());
    file.extend(body);
    file
}

fn read(name: &str, bytes: &[u8]) -> Result<Model, SceneError> {
    from_slice(name, bytes, &NoFiles)
}

/// The warnings about the container.
fn warnings(model: &Model) -> Vec<&str> {
    model.warnings.iter().map(String::as_str).filter(|warning| warning.starts_with("GLB container: ")).collect()
}

#[test]
fn chunks_are_found() {
    let mut triangle = File::triangle();
    triangle.json["buffers"] = json!([{ "byteLength": triangle.binary.len() }]);
    let mut text = triangle.json.to_string();
    text.push_str(&" ".repeat(text.len().next_multiple_of(4) - text.len()));
    let model = read("a", &glb(&[(JSON, text.as_bytes()), (BINARY, &triangle.binary), (7, b"else")])).unwrap();
    assert_eq!(model.meshes[0].primitives[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert!(warnings(&model).is_empty(), "{:?}", model.warnings);
    let model = read("a", b"\xef\xbb\xbf{\"asset\":{\"version\":\"2.0\"}}").unwrap();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    text.push_str("  ");
    let odd = read("a", &glb(&[(JSON, text.as_bytes()), (BINARY, &triangle.binary)])).unwrap();
    assert_eq!(warnings(&odd), ["GLB container: a chunk does not fill whole words of 4 bytes"]);
}

#[test]
fn every_cut_is_an_error() {
    let file = glb(&[(JSON, b"{}  "), (BINARY, &[1, 2, 3, 4])]);
    for length in 4..file.len() {
        let message = read("cut.glb", &file[..length]).unwrap_err().to_string();
        assert!(message.starts_with("cut.glb: GLB container: "), "{message}");
    }
}

#[test]
fn wrong_chunks_are_errors() {
    for chunks in [
        &[(JSON, &b"{}  "[..]), (JSON, b"{}  ")][..],
        &[(BINARY, b"1234"), (JSON, b"{}  ")],
        &[(JSON, b"{}  "), (BINARY, b"1234"), (BINARY, b"1234")],
        &[],
    ] {
        let message = read("a", &glb(chunks)).unwrap_err().to_string();
        assert!(message.starts_with("a: GLB container: "), "{chunks:?}: {message}");
    }
    let mut version_1 = glb(&[(JSON, b"{}  ")]);
    version_1[4] = 1;
    assert!(read("a", &version_1).unwrap_err().to_string().contains("version 1"));
}
