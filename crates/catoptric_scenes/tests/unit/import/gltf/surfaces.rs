//! Metallic-roughness surfaces: their numbers, textures and tangents.

use super::materials::png;
use super::*;
use catoptric_core::scene::{Light, LightKind, Material, Role, SurfaceQuery, UvFootprint, shade::Barycentrics};
use glam::{Vec2, Vec3};

/// A triangle with texture coordinates in two sets, and textures of one texel each.
fn textured(material: Value, texels: &[[u8; 4]]) -> File {
    let mut file = File::triangle();
    file.push("materials", material);
    let normals = file.positions(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    // As in a picture that stands upright: u to the right, v down.
    let uvs = file.accessor(F32, "VEC2", 3, &[0.0f32, 1.0, 1.0, 1.0, 0.0, 0.0]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["attributes"]["NORMAL"] = json!(normals);
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    primitive["attributes"]["TEXCOORD_1"] = json!(uvs);
    for texel in texels {
        let view = file.view(&png(*texel));
        let image = file.push("images", json!({ "bufferView": view }));
        file.push("textures", json!({ "source": image }));
    }
    file
}

fn material(entry: Value) -> Material {
    textured(entry, &[]).model().materials[0].clone()
}

#[test]
fn facets_take_the_numbers_of_the_format_and_its_defaults() {
    let plain = material(json!({})).microfacets.unwrap();
    assert_eq!((plain.metallic, plain.roughness), (1.0, 1.0));
    assert!((plain.specular - 0.04).abs().max_element() < 1e-6);
    let given = material(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.25, "roughnessFactor": 0.5 },
        "extensions": {
            "KHR_materials_ior": { "ior": 2 },
            "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 0.5, 20] },
            "KHR_materials_clearcoat": { "clearcoatFactor": 0.4, "clearcoatRoughnessFactor": 0.2 },
        },
    }));
    let facets = given.microfacets.unwrap();
    assert_eq!((facets.metallic, facets.roughness), (0.25, 0.5));
    // ((2 - 1) / (2 + 1))^2 times the colour, at most 1, times the factor.
    assert!((facets.specular - Vec3::new(1.0 / 18.0, 1.0 / 36.0, 0.5)).length() < 1e-6, "{}", facets.specular);
    assert_eq!((facets.specular_at_grazing, facets.coat, facets.coat_roughness), (0.5, 0.4, 0.2));
    assert_eq!(given.role, Role::Diffuse);
    let unlit = material(json!({ "extensions": { "KHR_materials_unlit": {} } }));
    assert!(unlit.microfacets.is_none() && unlit.unlit);
}

#[test]
fn what_has_no_material_is_plaster_and_said() {
    let model = File::triangle().model();
    assert!(model.materials[0].microfacets.is_none() && model.materials[0].base_color.x == 0.8);
    assert!(model.warnings.iter().any(|warning| warning.contains("no material")), "{:?}", model.warnings);
}

#[test]
fn textures_of_numbers_are_linear_and_those_of_colours_are_not() {
    let file = textured(
        json!({
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 0, "texCoord": 1 },
            },
            "occlusionTexture": { "index": 0, "strength": 0.5 },
            "normalTexture": { "index": 1, "scale": 2 },
        }),
        &[[128, 128, 128, 255], [128, 128, 255, 255]],
    );
    let model = file.model();
    let material = &model.materials[0];
    let value = |texture: u32| model.textures[texture as usize].sample(Vec2::splat(0.5), &UvFootprint::default());
    let facets = material.microfacets.as_ref().unwrap().texture.as_ref().unwrap();
    assert!((value(material.base_texture.as_ref().unwrap().texture).x - 0.2159).abs() < 1e-3);
    assert!((value(facets.texture).x - 128.0 / 255.0).abs() < 1e-4);
    let (base, occlusion) = (material.base_texture.as_ref().unwrap(), material.occlusion_map.as_ref().unwrap());
    assert_eq!((base.uv_channel, facets.uv_channel, occlusion.binding.uv_channel), (0, 1, 0));
    assert_eq!((occlusion.strength, occlusion.binding.texture), (0.5, facets.texture));
    let normals = material.normal_map.as_ref().unwrap();
    let normal = value(normals.binding.texture).truncate() * 2.0 - 1.0;
    assert!(normals.scale == 2.0 && (normal.length() - 1.0).abs() < 1e-4 && normal.x > 0.0, "{normal}");
    assert_eq!(model.textures.len(), 3, "one picture, as colours and as numbers, and the normals");
}

#[test]
fn coats_have_maps_of_their_own() {
    let coated = |coat: Value| {
        let entry = json!({
            "pbrMetallicRoughness": { "metallicFactor": 0 }, "normalTexture": { "index": 0 },
            "extensions": { "KHR_materials_clearcoat": coat },
        });
        textured(entry, &[[230, 128, 200, 255], [128, 128, 255, 255]]).model()
    };
    let model = coated(json!({ "clearcoatFactor": 1 }));
    let plain = &model.materials[0];
    assert!(
        plain.normal_map.is_some() && plain.coat_normal_map.is_none(),
        "what lies beneath is bumpy, the coat smooth"
    );
    let model = coated(json!({
        "clearcoatFactor": 0.8, "clearcoatTexture": { "index": 1 },
        "clearcoatNormalTexture": { "index": 0, "scale": 0.5 },
    }));
    let mapped = &model.materials[0];
    assert_eq!(mapped.coat_normal_map.as_ref().map(|map| map.scale), Some(0.5));
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    let scene = model.pose(&PoseOptions::default()).unwrap();
    let at = Barycentrics { value: Vec2::splat(0.3), ..Barycentrics::default() };
    let point = scene.encounter(0, &at).point;
    let found = scene.lobes_at(mapped, mapped.lobes().unwrap(), &point);
    assert!((found.coat - 0.8 * 128.0 / 255.0).abs() < 1e-3);
    assert!(found.coat_normal.x > 0.2, "the coat's map leans to the right");
    let rough = json!({
        "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.5, "clearcoatRoughnessTexture": { "index": 1 }
    });
    let model = coated(rough);
    let material = &model.materials[0];
    let scene = model.pose(&PoseOptions::default()).unwrap();
    let found = scene.lobes_at(material, material.lobes().unwrap(), &scene.encounter(0, &at).point);
    assert!((found.coat_alpha - (0.5f32 * 128.0 / 255.0).powi(2)).abs() < 1e-3, "the green channel: {found:?}");
}

#[test]
fn a_third_set_of_texture_coordinates_is_left_out_with_a_warning() {
    let file = textured(
        json!({
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 0, "texCoord": 1 },
            },
            "occlusionTexture": { "index": 0, "texCoord": 2 },
        }),
        &[[255; 4]],
    );
    let model = file.model();
    assert!(model.materials[0].occlusion_map.is_none());
    assert!(model.warnings.iter().any(|warning| warning.contains("two sets of texture coordinates")));
}

/// The light of a lamp in a direction, on the middle of the triangle, with a normal map that leans towards a texel.
fn lit(texel: [u8; 4], towards: Vec3, change: impl Fn(&mut File)) -> f32 {
    let facets = json!({ "metallicFactor": 0, "roughnessFactor": 1 });
    let mut file = textured(json!({ "pbrMetallicRoughness": facets, "normalTexture": { "index": 0 } }), &[texel]);
    change(&mut file);
    let mut scene = file.scene();
    let light = Light {
        kind: LightKind::Directional,
        intensity: Vec3::ONE,
        position: Vec3::ZERO,
        direction: -towards.normalize(),
    };
    scene.lights = vec![light];
    let barycentrics = Barycentrics { value: Vec2::splat(0.3), ..Barycentrics::default() };
    let mut colors = [Vec3::ZERO];
    let query = SurfaceQuery { triangle: 0, barycentrics, towards_viewer: Vec3::Z };
    scene.radiance_batch(&[query], &mut colors);
    colors[0].x
}

#[test]
fn normal_maps_lean_to_the_right_with_red_and_up_with_green() {
    let (right, up) = ([230, 128, 200, 255], [128, 230, 200, 255]);
    let (from_right, from_left) = (Vec3::new(1.0, 0.0, 1.0), Vec3::new(-1.0, 0.0, 1.0));
    let (from_above, from_below) = (Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, -1.0, 1.0));
    let as_it_is = |_: &mut File| {};
    assert!(lit(right, from_right, as_it_is) > 2.0 * lit(right, from_left, as_it_is));
    assert!(lit(up, from_above, as_it_is) > 2.0 * lit(up, from_below, as_it_is));
    assert!(
        (lit(up, from_left, as_it_is) / lit(up, from_right, as_it_is) - 1.0).abs() < 0.02,
        "128 is nearly in the middle"
    );
    // Mirrored by its node, the picture's right is on the left.
    let mirror = |file: &mut File| file.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    assert!(lit(right, from_left, mirror) > 2.0 * lit(right, from_right, mirror));
    assert!(lit(up, from_above, mirror) > 2.0 * lit(up, from_below, mirror));
    // Mirrored texture coordinates do the same.
    let turn = |file: &mut File| {
        let uvs = file.accessor(F32, "VEC2", 3, &[1.0f32, 1.0, 0.0, 1.0, 1.0, 0.0]);
        file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    };
    assert!(lit(right, from_left, turn) > 2.0 * lit(right, from_right, turn));
    assert!(lit(up, from_above, turn) > 2.0 * lit(up, from_below, turn));
    // Tangents of the file win.
    let own = |file: &mut File| {
        let tangents = [0.0f32, 1.0, 0.0, 1.0].repeat(3);
        let tangents = file.accessor(F32, "VEC4", 3, &tangents);
        file.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(tangents);
    };
    assert!(lit(right, from_above, own) > 2.0 * lit(right, from_below, own));
    assert!(lit(up, from_left, own) > 2.0 * lit(up, from_right, own));
    // Flat triangles have tangents, too.
    let flat = |file: &mut File| {
        file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    };
    assert!((lit(right, from_right, flat) / lit(right, from_right, as_it_is) - 1.0).abs() < 1e-4);
}

#[test]
fn vertices_at_the_seam_of_a_mirrored_texture_become_two() {
    let mut file = textured(json!({ "normalTexture": { "index": 0 } }), &[[128, 128, 255, 255]]);
    // Two squares side by side; the right one's texture is the left one's, mirrored.
    let positions =
        file.positions(&[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    let normals = file.positions(&[0.0, 0.0, 1.0].repeat(6));
    let uvs = file.accessor(F32, "VEC2", 6, &[0.0f32, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let indices = file.accessor(U16, "SCALAR", 12, &[0u16, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["indices"] = json!(indices);
    primitive["attributes"] = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
    let model = file.model();
    let primitive = &model.meshes[0].primitives[0];
    assert_eq!(primitive.positions.len(), 8, "two vertices lie on the seam");
    for (face, triangle) in primitive.triangles.iter().enumerate() {
        for &vertex in triangle {
            let tangent = primitive.tangents[vertex as usize];
            let expected = if face < 2 { 1.0 } else { -1.0 };
            assert!((tangent.x - expected).abs() < 1e-5 && tangent.w == expected, "{face}: {tangent}");
        }
    }
}
