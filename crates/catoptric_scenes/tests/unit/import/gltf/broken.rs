//! Broken, hostile and mutated files: an error or a scene, never a panic.

use super::*;
use catoptric_core::math::random::Stream;

#[test]
fn unknown_required_extensions_are_named() {
    let mut file = File::triangle();
    file.json["extensionsUsed"] = json!(["VENDOR_magic"]);
    assert_eq!(file.scene().objects.len(), 1);
    file.json["extensionsRequired"] = json!(["VENDOR_magic"]);
    file.assert_error("the glTF extension VENDOR_magic");
    file.json["extensionsRequired"] = json!(["KHR_materials_iridescence"]);
    assert!(file.model().warnings.iter().all(|warning| !warning.contains("iridescence")));
}

#[test]
fn counts_and_offsets_are_checked_against_the_data() {
    for (path, value, needle) in [
        ("/accessors/0/count", json!(4), "accessors[0]: 4 elements of 12 bytes"),
        ("/accessors/0/count", json!(u64::MAX), "accessors[0]"),
        ("/accessors/0/byteOffset", json!(u64::MAX - 3), "accessors[0]"),
        ("/accessors/0/componentType", json!(5124), "accessors[0].componentType: 5124"),
        ("/bufferViews/0/byteLength", json!(37), "bufferViews[0]: 37 bytes"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "bufferViews[0]"),
        ("/bufferViews/0/byteStride", json!(u64::MAX), "accessors[0]"),
        ("/accessors/0/bufferView", json!(-1), "accessors[0].bufferView"),
        ("/accessors/0/count", json!(2.5), "accessors[0].count"),
        ("/meshes/0/primitives/0/mode", json!(7), "primitives[0].mode"),
    ] {
        let mut file = File::triangle();
        match file.json.pointer_mut(path) {
            Some(target) => *target = value,
            None => {
                let (parent, key) = path.rsplit_once('/').unwrap();
                file.json.pointer_mut(parent).unwrap()[key] = value;
            }
        }
        file.assert_error(needle);
    }
    let mut file = File::triangle();
    file.json["buffers"] = json!([{ "byteLength": 1000 }]);
    file.assert_error("buffers[0].byteLength: 1000 bytes, but only 36 are there");
    let mut file = File::triangle();
    file.json["accessors"][0] = json!({ "componentType": F32, "type": "VEC3", "count": 1u64 << 40 });
    file.assert_error("accessors[0].count: 1099511627776 elements without data");
}

/// As some optimisers leave them behind.
#[test]
fn an_empty_primitive_is_left_out() {
    let mut file = File::triangle();
    let empty = file.json["accessors"][0].clone();
    file.push("accessors", empty);
    file.json["accessors"][1]["count"] = json!(0);
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": { "POSITION": 1 } }));
    file.assert_warning("meshes[0].primitives[1]: is empty");
    assert_eq!(file.scene().triangles.len(), 1);
}

#[test]
fn memory_stays_in_proportion_to_the_file() {
    // A thousand primitives of a million vertices that are all zero.
    let mut file = File::new();
    file.push("accessors", json!({ "componentType": F32, "type": "VEC3", "count": 1 << 20 }));
    let primitives: Vec<Value> = (0..1000).map(|_| json!({ "attributes": { "POSITION": 0 } })).collect();
    file.push("meshes", json!({ "primitives": primitives }));
    file.push("nodes", json!({ "mesh": 0 }));
    file.assert_error("bytes of decoded data; allowed are");
}

#[test]
fn indices_beyond_the_vertices_are_named() {
    let mut file = File::triangle();
    let indices = file.accessor(U16, "SCALAR", 3, &[0u16, 1, 3]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    file.assert_error("meshes[0].primitives[0].indices: element 2 is 3, but there are only 3 vertices");
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(0);
    file.assert_error("indices");
}

#[test]
fn numbers_that_are_none_do_not_reach_the_scene() {
    let mut file = File::triangle();
    file.binary[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(file.scene().positions.iter().all(|position| position.is_finite()));
    assert!(file.model().warnings[0].contains("not finite"));
    file.json["nodes"][0] = json!({ "mesh": 0, "scale": [1e38, 1e38, 1e38], "translation": [3e38, 0, 0] });
    assert!(file.scene().positions.iter().all(|position| position.is_finite()));
    file.json["nodes"][0] = json!({ "mesh": 0, "rotation": [0, 0, 0, 0] });
    assert!(file.scene().positions.iter().all(|position| position.is_finite()));
}

#[test]
fn faults_in_what_is_not_drawn_are_warnings() {
    let mut file = File::triangle();
    file.push("bufferViews", json!({ "buffer": 3, "byteLength": 4 }));
    file.push("bufferViews", json!({ "buffer": 0, "byteLength": 1000 }));
    file.push("accessors", json!({ "bufferView": 9, "componentType": U8, "type": "SCALAR", "count": 1 }));
    file.push("accessors", json!({ "bufferView": 1, "componentType": U8, "type": "VEC4", "count": 2 }));
    file.push("textures", json!({ "source": 1, "sampler": 1, "extensions": { "EXT_texture_webp": { "source": 2 } } }));
    file.push("images", json!({ "bufferView": 8 }));
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": 7 }, "targets": [{ "NORMAL": 6 }] }] }));
    let warnings = file.model().warnings.join("\n");
    for needle in [
        "bufferViews[1].buffer: there is no buffers[3]",
        "bufferViews[2]: 1000 bytes from byte 0 in a buffer of 36 bytes",
        "accessors[1].bufferView: there is no bufferViews[9]",
        "accessors[2]: 2 elements are more than the 4 bytes",
        "textures[0].sampler",
        "textures[0].source",
        "textures[0].extensions.EXT_texture_webp.source: there is no images[2]",
        "images[0].bufferView",
        "meshes[1].primitives[0].attributes.POSITION: there is no accessors[7]",
        "meshes[1].primitives[0].targets[0].NORMAL",
    ] {
        assert!(warnings.contains(needle), "{needle} in\n{warnings}");
    }
}

#[test]
fn buffers_of_files_without_binary_part_must_have_an_address() {
    let mut file = File::triangle();
    file.json["buffers"] = json!([{ "byteLength": 36 }]);
    let message = from_slice("a.gltf", file.json.to_string().as_bytes(), &NoFiles).unwrap_err().to_string();
    assert!(message.contains("buffers[0].uri: missing"), "{message}");
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&file.binary);
    file.json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{data}"));
    let model = from_slice("a.gltf", file.json.to_string().as_bytes(), &NoFiles).unwrap();
    assert_eq!(model.meshes[0].primitives[0].triangles.len(), 1);
}

#[test]
fn names_of_files_are_percent_decoded() {
    struct One(&'static str, Vec<u8>);
    impl catoptric_scenes::import::Resolver for One {
        fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, catoptric_core::error::SceneError> {
            if name == self.0 { Ok(self.1.clone()) } else { NoFiles.read(name, limit) }
        }
    }
    let mut file = File::triangle();
    for (uri, name) in [("a%20b%E2%9D%A4.bin", "a b\u{2764}.bin"), ("50%.bin", "50%.bin"), ("a%20b.bin", "a%20b.bin")] {
        file.json["buffers"] = json!([{ "byteLength": 36, "uri": uri }]);
        let resolver = One(name, file.binary.clone());
        assert!(from_slice("a.gltf", file.json.to_string().as_bytes(), &resolver).is_ok(), "{uri}");
    }
}

/// A file with as many features as fit into a few kilobytes.
fn seed() -> File {
    let mut file = compression::draco_file();
    let positions = file.positions(&TRIANGLE);
    let uvs = file.accessor(U8, "VEC2", 3, &[0u8, 0, 255, 0, 0, 255]);
    let joints = file.accessor(U8, "VEC4", 3, &[0u8; 12]);
    let weights = file.accessor(F32, "VEC4", 3, &[0.25f32; 12]);
    let times = file.accessor(F32, "SCALAR", 2, &[0.0f32, 1.0]);
    let rotations = file.accessor(I16, "VEC4", 2, &[0i16, 0, 0, 32767, 0, 32767, 0, 0]);
    let indices = file.accessor(U8, "SCALAR", 4, &[0u8, 1, 2, 0]);
    let sparse_indices = file.view(&[1u8]);
    let sparse_values = file.view(&[1.0f32, 1.0, 1.0].bytes());
    file.json["accessors"][positions]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": sparse_indices, "componentType": U8 },
        "values": { "bufferView": sparse_values },
    });
    let picture = file.view(&materials::png([9, 8, 7, 6]));
    file.push("images", json!({ "bufferView": picture }));
    file.push("samplers", json!({ "magFilter": 9728, "wrapS": 33648 }));
    file.push("textures", json!({ "source": 0, "sampler": 0 }));
    file.push(
        "materials",
        json!({
            "alphaMode": "BLEND",
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "roughnessFactor": 0.0 },
            "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1 } },
        }),
    );
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uvs, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let targets = json!([{ "POSITION": positions }]);
    let primitive =
        json!({ "attributes": attributes, "indices": indices, "mode": 5, "material": 0, "targets": targets });
    let node = file.show(primitive);
    file.json["nodes"][node]["skin"] = json!(0);
    file.json["nodes"][node]["children"] = json!([0]);
    file.push("skins", json!({ "joints": [node] }));
    let channel = json!({ "sampler": 0, "target": { "node": node, "path": "rotation" } });
    let sampler = json!({ "input": times, "output": rotations });
    file.push("animations", json!({ "channels": [channel], "samplers": [sampler] }));
    file.push("nodes", json!({ "extras": { "catoptric": { "surface": "sphere", "radius": 1 } } }));
    file
}

#[test]
fn the_seed_of_the_mutations_is_sound() {
    let scene = seed().scene();
    assert_eq!((scene.objects.len(), scene.textures.len()), (3, 1));
}

/// Reads and poses; any result without a panic is fine.
fn digest(bytes: &[u8]) -> bool {
    let Ok(model) = from_slice("mutated", bytes, &NoFiles) else { return false };
    let scene = model.pose(&PoseOptions { time: 0.4, ..Default::default() });
    scene.is_ok_and(|scene| {
        assert!(scene.positions.iter().chain(&scene.normals).all(|v| v.is_finite()));
        true
    })
}

#[test]
fn mutated_files_never_panic() {
    let seed = seed().glb();
    let json_end = 20 + u32::from_le_bytes([seed[12], seed[13], seed[14], seed[15]]) as usize;
    let mut survivors = 0;
    for iteration in 0..3000u64 {
        let mut bytes = seed.clone();
        let mut random = Stream::new(iteration);
        let mut below = |limit: usize| (random.next_unit() * limit as f32) as usize;
        for _ in 0..1 + below(4) {
            let place =
                if below(2) == 0 { below(json_end) } else { json_end + below(bytes.len().saturating_sub(json_end)) };
            let place = place.min(bytes.len() - 1);
            match below(6) {
                0 => bytes[place] ^= 1 << below(8),
                1 => bytes[place] = below(256) as u8,
                2 => bytes[place] = [0, 127, 128, 255][below(4)],
                3 if bytes[place].is_ascii_digit() => bytes[place] = b'0' + below(10) as u8,
                4 => {
                    let from = below(bytes.len());
                    let length = below(16).min(bytes.len() - from.max(place));
                    bytes.copy_within(from..from + length, place);
                }
                5 if below(8) == 0 => bytes.truncate(place.max(1)),
                _ => {}
            }
        }
        survivors += u32::from(digest(&bytes));
    }
    assert!(survivors > 100, "only {survivors} files were still sound: the mutations are too wild to find anything");
}

#[test]
fn cut_off_files_never_panic() {
    let seed = seed().glb();
    for length in (0..seed.len()).step_by(7) {
        digest(&seed[..length]);
        // The same with a true header, so that the cut is found later.
        let mut bytes = seed[..length].to_vec();
        if let Some(field) = bytes.get_mut(8..12) {
            field.copy_from_slice(&(length as u32).to_le_bytes());
        }
        assert!(!digest(&bytes), "{length}");
    }
}
