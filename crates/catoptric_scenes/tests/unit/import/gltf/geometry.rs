use super::*;
use glam::{Vec2, Vec3};

#[test]
fn a_triangle_without_indices_or_normals_is_flat() {
    let scene = File::triangle().scene();
    assert_eq!(scene.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(scene.normals, [Vec3::Z; 3]);
    assert!(File::triangle().model().meshes[0].primitives[0].normals.is_empty());
}

#[test]
fn indices_of_every_type() {
    let check = |component: u32, bytes: Vec<u8>| {
        let mut file = File::new();
        let positions = file.positions(&[5.0, 5.0, 5.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let view = file.view(&bytes);
        let indices = file
            .push("accessors", json!({ "bufferView": view, "componentType": component, "type": "SCALAR", "count": 3 }));
        file.show(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
        assert_eq!(file.scene().positions, [Vec3::X, Vec3::Y, Vec3::ZERO]);
    };
    check(U8, [2u8, 3, 1].bytes());
    check(U16, [2u16, 3, 1].bytes());
    check(U32, [2u32, 3, 1].bytes());
}

#[test]
fn strips_and_fans() {
    let corners: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let triangles = |mode: u32, indices: &[u16]| {
        let mut file = File::new();
        let positions = file.positions(&corners);
        let indices = file.accessor(U16, "SCALAR", indices.len(), indices);
        file.show(json!({ "attributes": { "POSITION": positions }, "indices": indices, "mode": mode }));
        file.model().meshes[0].primitives[0].triangles.clone()
    };
    assert_eq!(triangles(4, &[0, 1, 2, 2, 1, 3, 0]), [[0, 1, 2], [2, 1, 3]]);
    // Every second triangle of a strip is turned, so that all face the same way.
    assert_eq!(triangles(5, &[0, 1, 2, 3]), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(triangles(5, &[0, 1, 2, 2, 3]), [[0, 1, 2]]);
    assert_eq!(triangles(6, &[0, 1, 3, 2]), [[0, 1, 3], [0, 3, 2]]);
    assert!(triangles(6, &[0]).is_empty() && triangles(5, &[0, 1]).is_empty());
}

#[test]
fn points_lines_and_meshes_without_positions_are_left_out_with_a_warning() {
    let mut file = File::triangle();
    file.json["meshes"][0]["primitives"] = json!([
        { "attributes": { "POSITION": 0 }, "mode": 1 },
        { "attributes": { "NORMAL": 0 } },
        { "attributes": { "POSITION": 0 } },
    ]);
    let model = file.model();
    assert_eq!(model.meshes[0].primitives.len(), 1);
    assert!(model.warnings[0].contains("primitives[0]: points and lines"), "{:?}", model.warnings);
    assert!(model.warnings[1].contains("primitives[1]: without POSITION"), "{:?}", model.warnings);
}

#[test]
fn component_types_and_normalised_integers() {
    fn positions(component: u32, normalized: bool, bytes: Vec<u8>) -> Vec<Vec3> {
        let mut file = File::new();
        let view = file.view(&bytes);
        let accessor = json!({
            "bufferView": view, "componentType": component, "type": "VEC3", "count": 3, "normalized": normalized
        });
        let accessor = file.push("accessors", accessor);
        file.show(json!({ "attributes": { "POSITION": accessor } }));
        file.model().meshes[0].primitives[0].positions.clone()
    }
    let numbers = [1, 2, 3, -128, 127, 0, 0, 0, -127];
    let plain = positions(I8, false, numbers.map(|n| n as i8).bytes());
    assert_eq!(plain, [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-128.0, 127.0, 0.0), Vec3::new(0.0, 0.0, -127.0)]);
    let scaled = positions(I8, true, numbers.map(|n| n as i8).bytes());
    assert_eq!(scaled[1], Vec3::new(-1.0, 1.0, 0.0));
    assert_eq!(positions(U8, true, [0u8, 51, 255, 0, 0, 0, 0, 0, 0].bytes())[0], Vec3::new(0.0, 0.2, 1.0));
    assert_eq!(positions(I16, true, [-32768i16, 0, 32767, 0, 0, 0, 0, 0, 0].bytes())[0], Vec3::new(-1.0, 0.0, 1.0));
    assert_eq!(positions(U16, true, [0u16, 13107, 65535, 0, 0, 0, 0, 0, 0].bytes())[0], Vec3::new(0.0, 0.2, 1.0));
    assert_eq!(positions(U32, false, [7u32, 8, 9, 0, 0, 0, 0, 0, 0].bytes())[0], Vec3::new(7.0, 8.0, 9.0));
}

#[test]
fn interleaved_attributes() {
    let mut file = File::new();
    let vertex = |x: f32, y: f32| [x, y, 0.0, 0.0, 0.0, 1.0];
    let numbers = [vertex(0.0, 0.0), vertex(1.0, 0.0), vertex(0.0, 1.0)].concat();
    let view = file.view(&numbers.bytes());
    file.json["bufferViews"][view]["byteStride"] = json!(24);
    for offset in [0, 12] {
        file.push(
            "accessors",
            json!({ "bufferView": view, "byteOffset": offset, "componentType": F32, "type": "VEC3", "count": 3 }),
        );
    }
    file.show(json!({ "attributes": { "POSITION": 0, "NORMAL": 1 } }));
    let scene = file.scene();
    assert_eq!((scene.positions[1], scene.normals[1]), (Vec3::X, Vec3::Z));
}

#[test]
fn sparse_accessors_with_and_without_a_base() {
    let mut file = File::triangle();
    let indices = file.view(&[2u16].bytes());
    let values = file.view(&[0.0f32, 3.0, 0.0].bytes());
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": U16 },
        "values": { "bufferView": values },
    });
    file.json["accessors"][0]["sparse"] = sparse;
    assert_eq!(file.scene().positions, [Vec3::ZERO, Vec3::X, Vec3::Y * 3.0]);
    file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(file.model().meshes[0].primitives[0].positions, [Vec3::ZERO, Vec3::ZERO, Vec3::Y * 3.0]);
    file.json["accessors"][0]["sparse"]["count"] = json!(4);
    file.assert_error("accessors[0].sparse.count");
    file.json["accessors"][0]["sparse"]["count"] = json!(1);
    file.json["accessors"][0]["sparse"]["indices"]["componentType"] = json!(F32);
    file.assert_error("accessors[0].sparse.indices.componentType");
    file.json["accessors"][0]["sparse"]["indices"]["componentType"] = json!(U8);
    file.binary[36] = 3;
    file.assert_error("index 3 is beyond the 3 elements");
}

#[test]
fn only_the_vertices_that_are_used_are_kept() {
    let mut file = File::new();
    let numbers: Vec<f32> = (0..300).map(|number| number as f32).collect();
    let positions = file.positions(&numbers);
    let indices = file.accessor(U8, "SCALAR", 3, &[90u8, 10, 50]);
    file.show(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    let primitive = &file.model().meshes[0].primitives[0];
    assert_eq!(primitive.positions, [10.0, 50.0, 90.0].map(|v: f32| Vec3::new(v * 3.0, v * 3.0 + 1.0, v * 3.0 + 2.0)));
    assert_eq!(primitive.triangles, [[2, 0, 1]]);
}

#[test]
fn vertex_colors_of_every_type() {
    let color = |kind: &str, component: u32, bytes: Vec<u8>| {
        let mut file = File::triangle();
        let view = file.view(&bytes);
        let accessor =
            file.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": 3 }));
        file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
        file.scene().colors[2]
    };
    let nine = [0.0f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25, 0.5, 1.0];
    assert_eq!(color("VEC3", F32, nine.bytes()), [0.25, 0.5, 1.0, 1.0]);
    assert_eq!(color("VEC3", U8, [0u8, 0, 0, 0, 0, 0, 0, 51, 255].bytes()), [0.0, 0.2, 1.0, 1.0]);
    let twelve = [0u16, 0, 0, 0, 0, 0, 0, 0, 65535, 13107, 0, 13107];
    assert_eq!(color("VEC4", U16, twelve.bytes()), [1.0, 0.2, 0.0, 0.2]);
}

#[test]
fn each_texture_gets_its_own_coordinates() {
    let mut file = File::triangle();
    let mut attributes = json!({ "POSITION": 0 });
    for set in 0..3 {
        let uv = set as f32;
        attributes[format!("TEXCOORD_{set}")] = file.accessor(F32, "VEC2", 3, &[uv; 6]).into();
    }
    let png = materials::png([255; 4]);
    let view = file.view(&png);
    file.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    file.push("textures", json!({ "source": 0 }));
    let transform = json!({ "KHR_texture_transform": { "texCoord": 1, "offset": [0.5, 0.25] } });
    file.push(
        "materials",
        json!({
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 2 } },
            "emissiveTexture": { "index": 0, "texCoord": 0, "extensions": transform },
            "emissiveFactor": [1, 1, 1],
        }),
    );
    file.json["meshes"][0]["primitives"][0] = json!({ "attributes": attributes, "material": 0 });
    let scene = file.scene();
    assert_eq!(scene.uvs[0], [Vec2::splat(2.0), Vec2::splat(1.0)]);
    let material = &scene.materials[0];
    let (base, emissive) = (material.base_texture.as_ref().unwrap(), material.emissive_texture.as_ref().unwrap());
    assert_eq!((base.uv_channel, emissive.uv_channel), (0, 1));
    assert_eq!(emissive.texture_from_uv.translation, Vec2::new(0.5, 0.25));
    assert_eq!(scene.textures.len(), 1);
}

#[test]
fn attributes_must_match_the_positions() {
    let mut file = File::triangle();
    let normals = file.accessor(F32, "VEC3", 2, &[0.0f32; 6]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    file.assert_error("meshes[0].primitives[0].attributes.NORMAL: 2 elements for 3 positions");
    file.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0, "TEXCOORD_0": 0, "NORMAL": 0 });
    file.json["accessors"][0]["type"] = json!("VEC4");
    file.assert_error("attributes.POSITION: accessors[0] has type `VEC4`; allowed are VEC3");
}
