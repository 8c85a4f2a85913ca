//! Several files in one scene.

use super::gltf::materials::{png, textured};
use super::gltf::{F32, File, U8, U16};
use catoptric_core::error::SceneError;
use catoptric_core::scene::Model;
use catoptric_scenes::import::{Resolver, gltf, toml_scene};
use serde_json::json;

/// A file with an entry of each kind that others name by its number.
fn file() -> File {
    let mut file = textured(&png([255; 4]), false);
    let joints = file.accessor(U16, "VEC4", 3, &[0u16; 12]);
    let weights = file.accessor(U8, "VEC4", 3, &[255u8, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    file.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    file.json["nodes"][0]["children"] = json!([1]);
    file.json["nodes"][0]["skin"] = json!(0);
    file.push("nodes", json!({ "camera": 0 }));
    file.push("nodes", json!({ "extras": { "catoptric": { "surface": "sphere", "radius": 1 } } }));
    file.push("skins", json!({ "joints": [1] }));
    file.push(
        "cameras",
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 9 } }),
    );
    let input = file.accessor(F32, "SCALAR", 1, &[0f32]);
    let output = file.accessor(F32, "VEC3", 1, &[0f32; 3]);
    file.push(
        "animations",
        json!({
            "samplers": [{ "input": input, "output": output, "interpolation": "STEP" }],
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }],
        }),
    );
    file.json["extensionsUsed"] = json!(["VENDOR_magic"]);
    file
}

/// Finds the same file under every name.
struct Everywhere(Vec<u8>);

impl Resolver for Everywhere {
    fn read(&self, _: &str, _: u64) -> Result<Vec<u8>, SceneError> {
        Ok(self.0.clone())
    }
}

#[test]
fn all_indices_move_up() {
    let files = Everywhere(file().glb());
    let alone: Model = gltf::from_slice("a.glb", &files.0, &files).unwrap();
    let joined = toml_scene::from_slice("both.toml", b"gltf = [\"a.glb\", \"b.glb\"]\n", &files).unwrap();
    let (nodes, materials) = (alone.nodes.len(), alone.materials.len());
    assert_eq!((nodes, alone.meshes.len(), alone.skins.len(), alone.textures.len()), (3, 1, 1, 1));
    assert_eq!((joined.nodes[0].mesh, joined.nodes[0].skin, joined.nodes[1].parent), (Some(0), Some(0), Some(0)));
    assert_eq!((joined.nodes[3].mesh, joined.nodes[3].skin, joined.nodes[4].parent), (Some(1), Some(1), Some(3)));
    let material_of = |model: &Model, node: usize| model.nodes[node].analytic.as_ref().unwrap().material;
    assert_eq!(material_of(&joined, 5), material_of(&alone, 2) + materials);
    let [before, after] = [&alone.meshes[0], &joined.meshes[1]].map(|mesh| mesh.primitives[0].material);
    assert_eq!(after, before + materials);
    assert_eq!(joined.skins[1].joints, [4]);
    assert_eq!(joined.animations[1].channels[0].node, 4);
    assert_eq!(joined.materials[after].base_texture.as_ref().unwrap().texture, 1);
    assert_eq!(joined.cameras[1].node, Some(4));
    assert_eq!((alone.warnings.len(), joined.warnings.len()), (1, 2));
    assert!(joined.pose(&Default::default()).is_ok());
}
