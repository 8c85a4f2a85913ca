//! Basis Universal pictures.

use super::materials::textured;
use super::*;
use catoptric_core::math::random::Stream;
use catoptric_core::scene::{Sampler, Texture};
use std::sync::Arc;

/// A UASTC picture of 4 x 4 texels of one colour (mode 8 of the format: solid).
fn solid([r, g, b, a]: [u8; 4]) -> Vec<u8> {
    let block_bits = 0b10111u128 | u128::from(r) << 5 | u128::from(g) << 13 | u128::from(b) << 21 | u128::from(a) << 29;
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let (descriptor, data) = (104u32, 148u32);
    // Format, type size, width, height, depth, layers, faces, levels, scheme; descriptor, key values; global data.
    for word in [0, 1, 4, 4, 0, 0, 1, 1, 0, descriptor, 44, 0, 0, 0, 0, 0, 0, data, 0, 16, 0, 16, 0] {
        bytes.extend(u32::to_le_bytes(word));
    }
    let model = 166 | 1 << 8 | 2 << 16; // UASTC, BT.709, sRGB
    for word in [44, 0, 2 | 40 << 16, model, 3 | 3 << 8, 16, 0, 127 << 16 | 3 << 24, 0, 0, u32::MAX] {
        bytes.extend(u32::to_le_bytes(word));
    }
    assert_eq!(bytes.len(), data as usize);
    bytes.extend(block_bits.to_le_bytes());
    bytes
}

/// The texture of a file's picture, or the message about its fault.
fn decode(bytes: &[u8]) -> Result<Arc<Texture>, String> {
    let mut file = textured(bytes, false);
    file.json["textures"][0] = json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } });
    let model = file.model();
    let problem = model.warnings.iter().find_map(|warning| warning.strip_prefix("picture `images[0]` is not drawn"));
    problem.map_or_else(|| Ok(model.textures[0].clone()), |problem| Err(problem.into()))
}

#[test]
fn a_solid_picture_is_transcoded() {
    let picture = decode(&solid([10, 200, 30, 255])).unwrap();
    assert_eq!(picture.size(), (4, 4));
    let expected = Texture::from_srgb8("", 4, 4, &[[10, 200, 30, 255]; 16], Sampler::default());
    assert_eq!(picture.texels(), expected.texels());
}

#[test]
fn broken_headers_are_errors() {
    let sound = solid([1, 2, 3, 4]);
    for length in 12..sound.len() {
        assert!(decode(&sound[..length]).is_err(), "{length}");
    }
    for (byte, needle) in [
        (12, "two dimensions"),
        (36, "two dimensions"),
        (41, "levels"),
        (45, "supercompression"),
        (51, "format descriptor"),
        (71, "global data"),
        (87, "level"),
        (88, "level lies outside"),
        (20, "16 bytes for 2 blocks"),
        (116, "colour model"),
    ] {
        let mut bytes = sound.clone();
        bytes[byte] += 1;
        let problem = decode(&bytes).unwrap_err();
        assert!(problem.contains(needle), "{byte}: {problem}");
    }
}

#[test]
fn mutated_pictures_never_panic() {
    let sound = solid([1, 2, 3, 4]);
    let mut decoded = 0;
    for iteration in 0..2000u64 {
        let mut random = Stream::new(iteration);
        let mut below = |limit: usize| (random.next_unit() * limit as f32) as usize;
        let mut bytes = sound.clone();
        for _ in 0..1 + below(3) {
            let place = 12 + below(bytes.len() - 12);
            bytes[place] = below(256) as u8;
        }
        decoded += u32::from(decode(&bytes).is_ok());
    }
    assert!(decoded > 50, "only {decoded}");
}
