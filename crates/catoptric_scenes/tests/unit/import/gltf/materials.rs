use super::*;
use catoptric_core::scene::{AlphaMode, Material, Role, UvFootprint};
use glam::{Vec2, Vec3, Vec4};
use std::io::Cursor;

/// A picture of one texel.
pub(in super::super) fn png(texel: [u8; 4]) -> Vec<u8> {
    picture(texel, image::ImageFormat::Png)
}

fn picture(texel: [u8; 4], format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = image::DynamicImage::from(image::RgbaImage::from_pixel(1, 1, image::Rgba(texel)));
    let picture = if format == image::ImageFormat::Jpeg { picture.to_rgb8().into() } else { picture };
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn material(entry: Value) -> Material {
    with_material(entry).model().materials[0].clone()
}

fn with_material(entry: Value) -> File {
    let mut file = File::triangle();
    file.push("materials", entry);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file
}

#[test]
fn plain_metals_are_mirrors_and_others_have_lobes() {
    let metal = |metallic: f32, roughness: f32| {
        json!({ "pbrMetallicRoughness": {
            "metallicFactor": metallic, "roughnessFactor": roughness, "baseColorFactor": [0.9, 0.8, 0.7, 1]
        } })
    };
    let mirror = material(metal(1.0, 0.0));
    assert_eq!((mirror.role, mirror.schlick), (Role::Reflector, true));
    assert_eq!(mirror.base_color, Vec4::new(0.9, 0.8, 0.7, 1.0));
    assert_eq!(mirror.highlight_roughness(), None);
    for (metallic, roughness) in [(0.99, 0.0), (0.5, 0.0), (1.0, 0.3), (1.0, 1.0), (0.0, 0.0), (0.0, 0.5)] {
        let found = material(metal(metallic, roughness));
        assert_eq!(found.role, Role::Diffuse);
        assert!(found.lobes().is_some(), "{metallic} {roughness}");
        let facets = found.microfacets.unwrap();
        assert_eq!((facets.metallic, facets.roughness), (metallic, roughness));
    }
    // A rough dielectric has no lobes: its reflection is the environment's, as wide as half of the sky.
    assert!(material(metal(0.0, 0.9)).lobes().is_none());
    // By the format's defaults: white, rough metal.
    assert!(material(json!({})).lobes().is_some());
    let mut unlit = metal(1.0, 0.0);
    unlit["extensions"] = json!({ "KHR_materials_unlit": {} });
    let unlit = material(unlit);
    assert!(unlit.unlit && unlit.role == Role::Diffuse && unlit.lobes().is_none());
    let mut special = metal(1.0, 0.5);
    special["extensions"] = json!({ "VENDOR_materials_glitter": {} });
    let warnings = with_material(special).model().warnings;
    assert!(warnings[0].contains("drawn without VENDOR_materials_glitter"), "{warnings:?}");
}

#[test]
fn modifiers_of_lobes_are_read() {
    let smooth = |extensions: Value| {
        material(json!({
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 }, "extensions": extensions
        }))
    };
    let clear = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_volume": { "thicknessFactor": 1 } });
    assert_eq!(smooth(clear.clone()).role, Role::Lens);
    let mut prism = clear;
    prism["KHR_materials_dispersion"] = json!({ "dispersion": 5 });
    assert_eq!(smooth(prism).lobes().unwrap().dispersion, 5.0);
    let brushed = smooth(json!({ "KHR_materials_anisotropy": { "anisotropyStrength": 0.6, "anisotropyRotation": 1 } }));
    let brushed = brushed.lobes().unwrap().clone();
    assert_eq!((brushed.anisotropy, brushed.anisotropy_rotation), (0.6, 1.0));
    let film = smooth(json!({ "KHR_materials_iridescence": { "iridescenceFactor": 1 } })).lobes().unwrap().film;
    let film = film.unwrap();
    assert_eq!((film.share, film.ior, film.thickness_nm), (1.0, 1.3, [100.0, 400.0]));
    let leaf = smooth(json!({ "KHR_materials_diffuse_transmission": {
        "diffuseTransmissionFactor": 0.5, "diffuseTransmissionColorFactor": [0.1, 0.2, 0.3] } }));
    let leaf = leaf.lobes().unwrap().clone();
    assert_eq!((leaf.diffuse_transmission, leaf.diffuse_transmission_color), (0.5, Vec3::new(0.1, 0.2, 0.3)));
}

#[test]
fn specular_glossiness_becomes_a_reflectance_and_a_roughness() {
    let entry = |more: Value| {
        let mut given = json!({ "diffuseFactor": [0.5, 0.4, 0.3, 1], "specularFactor": [0.9, 0.6, 0.2],
            "glossinessFactor": 0.75 });
        if let Some(texture) = more.get("specularGlossinessTexture") {
            given["specularGlossinessTexture"] = texture.clone();
        }
        json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": given } })
    };
    let gilded = material(entry(json!({})));
    let facets = gilded.microfacets.as_ref().unwrap();
    assert_eq!((facets.metallic, facets.roughness), (0.0, 0.25));
    assert!((facets.specular - Vec3::new(0.9, 0.6, 0.2)).length() < 1e-5, "{}", facets.specular);
    assert_eq!(gilded.base_color, Vec4::new(0.5, 0.4, 0.3, 1.0));
    // Roughness is one minus the factor times alpha.
    let mut file = with_material(entry(json!({ "specularGlossinessTexture": { "index": 0 } })));
    let view = file.view(&png([255, 0, 255, 102]));
    let image = file.push("images", json!({ "bufferView": view }));
    file.push("textures", json!({ "source": image }));
    let uvs = file.accessor(F32, "VEC2", 3, &[0.0f32, 1.0, 1.0, 1.0, 0.0, 0.0]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    let model = file.model();
    let facets = model.materials[0].microfacets.as_ref().unwrap();
    let texture = &model.textures[facets.texture.as_ref().unwrap().texture as usize];
    let texel = texture.sample(Vec2::splat(0.5), &UvFootprint::default());
    assert!((texel.y - (1.0 - 0.75 * 0.4)).abs() < 0.005 && texel.z == 0.0, "{texel}");
}

#[test]
fn a_metallic_roughness_texture_is_evaluated_at_each_point() {
    let mut file = with_material(json!({ "pbrMetallicRoughness": {
        "metallicFactor": 1, "roughnessFactor": 0, "metallicRoughnessTexture": { "index": 0 }
    } }));
    file.push("textures", json!({}));
    let model = file.model();
    assert_eq!(model.materials[0].role, Role::Diffuse);
    assert!(model.materials[0].lobes().is_some());
}

#[test]
fn clear_glass_is_a_lens_and_other_glass_has_lobes() {
    let glass = |transmission: f32, roughness: f32, thickness: f32| {
        json!({
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": roughness },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": transmission },
                "KHR_materials_ior": { "ior": 1.7 },
                "KHR_materials_volume": {
                    "thicknessFactor": thickness, "attenuationColor": [0.5, 1, 0], "attenuationDistance": 2
                },
            },
        })
    };
    let lens = material(glass(1.0, 0.0, 0.1));
    assert_eq!((lens.role, lens.ior), (Role::Lens, 1.7));
    let expected = Vec3::new(0.5f32.ln() * -0.5, 0.0, 1e-6f32.ln() * -0.5);
    assert!((lens.absorption - expected).length() < 1e-5, "{}", lens.absorption);
    for (transmission, roughness) in [(0.4, 0.0), (1.0, 0.2)] {
        let found = material(glass(transmission, roughness, 0.1));
        let lobes = found.lobes().unwrap();
        assert_eq!((lobes.transmission, lobes.is_thin, found.ior), (transmission, false, 1.7));
        assert!((found.absorption - expected).length() < 1e-5);
    }
    // Without a thickness it is a wall, and absorbs nothing.
    let wall = material(glass(1.0, 0.0, 0.0));
    assert!(wall.lobes().unwrap().is_thin && wall.absorption == Vec3::ZERO);
    let mut wall = glass(1.0, 0.0, 0.0);
    wall["extensions"] = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } });
    assert!(material(wall).lobes().unwrap().is_thin);
    let mut odd = glass(1.0, 0.0, 0.1);
    odd["extensions"]["KHR_materials_ior"] = json!({ "ior": 20 });
    assert_eq!(material(odd.clone()).ior, 1.5);
    assert!(with_material(odd).model().warnings[0].contains("ior 20"));
}

#[test]
fn coats_and_sheen_are_lobes() {
    let found = material(json!({ "extensions": {
        "KHR_materials_clearcoat": { "clearcoatFactor": 0.4, "clearcoatRoughnessFactor": 0.3 },
        "KHR_materials_sheen": { "sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.6 },
    } }));
    let facets = found.microfacets.clone().unwrap();
    assert_eq!((found.coat, facets.coat, facets.coat_roughness), (0.4, 0.4, 0.3));
    let lobes = found.lobes().unwrap();
    assert_eq!((lobes.sheen, lobes.sheen_roughness), (Vec3::new(0.1, 0.2, 0.3), 0.6));
}

#[test]
fn emission_has_a_strength() {
    let entry = json!({
        "emissiveFactor": [1, 0.5, 0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 4 } },
    });
    assert_eq!(material(entry).emissive, Vec3::new(4.0, 2.0, 0.0));
}

#[test]
fn alpha_modes() {
    let alpha = |mode: &str, alpha: f32| {
        with_material(json!({
            "alphaMode": mode, "alphaCutoff": 0.3, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, alpha] }
        }))
    };
    assert_eq!(alpha("OPAQUE", 0.2).model().materials[0].alpha_mode, AlphaMode::Opaque);
    assert_eq!(alpha("MASK", 0.2).model().materials[0].alpha_mode, AlphaMode::Mask(0.3));
    let blended = alpha("BLEND", 0.2).model();
    assert_eq!((blended.materials[0].alpha_mode, blended.warnings.len()), (AlphaMode::Blend, 0));
    assert!(blended.materials[0].lobes().is_some());
    let opaque = alpha("BLEND", 1.0).model();
    assert_eq!((opaque.materials[0].alpha_mode, opaque.warnings.len()), (AlphaMode::Opaque, 0));
    alpha("HAZE", 1.0).assert_error("materials[0].alphaMode: `HAZE`");
}

/// A file with a texture of one texel that is embedded, as a buffer view or a data URI.
pub(in super::super) fn textured(bytes: &[u8], by_uri: bool) -> File {
    let mut file = with_material(json!({
        "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } }
    }));
    let uvs = file.accessor(F32, "VEC2", 3, &[0.5f32; 6]);
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    let image = if by_uri {
        use base64::Engine;
        json!({ "uri": format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes)) })
    } else {
        json!({ "bufferView": file.view(bytes) })
    };
    file.push("images", image);
    file.push("textures", json!({ "source": 0 }));
    file
}

#[test]
fn pictures_of_every_format() {
    for (format, by_uri) in [
        (image::ImageFormat::Png, true),
        (image::ImageFormat::Png, false),
        (image::ImageFormat::Jpeg, false),
        (image::ImageFormat::WebP, false),
    ] {
        let file = textured(&picture([255, 0, 0, 255], format), by_uri);
        let texel = file.scene().textures[0].sample(Vec2::splat(0.5), &UvFootprint::default());
        assert!((texel - Vec4::new(1.0, 0.0, 0.0, 1.0)).length() < 0.02, "{format:?}: {texel}");
        assert_eq!(file.model().materials[0].alpha_mode, AlphaMode::Opaque);
    }
    let translucent = textured(&png([255, 255, 255, 100]), false).model();
    assert_eq!(translucent.materials[0].alpha_mode, AlphaMode::Blend);
}

#[test]
fn pictures_of_extensions_come_first() {
    let mut file = textured(&png([0, 0, 0, 255]), false);
    let view = file.view(&picture([255; 4], image::ImageFormat::WebP));
    file.push("images", json!({ "bufferView": view }));
    file.json["textures"][0]["extensions"] = json!({ "EXT_texture_webp": { "source": 1 } });
    let texel = file.scene().textures[0].sample(Vec2::ZERO, &UvFootprint::default());
    assert_eq!(texel, Vec4::ONE);
}

#[test]
fn broken_pictures_are_named_and_the_factor_is_drawn_alone() {
    let broken = textured(b"nothing", false);
    broken.assert_warning("`images[0]` is not drawn, its factors alone are: is no PNG, JPEG, WebP, TGA or BMP picture");
    let texel = broken.scene().textures[0].sample(Vec2::ZERO, &UvFootprint::default());
    assert_eq!(texel, Vec4::ONE);
    let whole = png([1, 2, 3, 4]);
    textured(&whole[..whole.len() - 20], false).assert_warning("is broken or cut off");
    let mut file = textured(&whole, false);
    file.json["images"][0] = json!({ "uri": "gone.png" });
    file.assert_warning("images[0].uri");
    file.json["images"][0] = json!({ "uri": "https://example.org/a.png" });
    file.assert_warning("is an address");
    file.json["images"][0] = json!({ "uri": "data:image/png;base64,****" });
    file.assert_warning("no base64");
    file.json["textures"][0] = json!({});
    assert!(file.model().warnings[0].contains("textures[0] has no picture"));
    // Pictures that no triangle uses are not looked for.
    file.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    file.json["textures"][0] = json!({ "source": 0 });
    assert_eq!(file.model().textures.len(), 0);
}

#[test]
fn huge_pictures_are_refused_before_they_are_decoded() {
    // The header of a PNG file of 60000 x 60000 texels, with a right checksum.
    let mut bytes = png([0; 4]);
    bytes[16..20].copy_from_slice(&60_000u32.to_be_bytes());
    bytes[20..24].copy_from_slice(&60_000u32.to_be_bytes());
    let mut checksum = u32::MAX;
    for byte in &bytes[12..29] {
        checksum ^= u32::from(*byte);
        for _ in 0..8 {
            checksum = (checksum >> 1) ^ (0xedb8_8320 & 0u32.wrapping_sub(checksum & 1));
        }
    }
    bytes[29..33].copy_from_slice(&(!checksum).to_be_bytes());
    textured(&bytes, false).assert_warning("has 60000 x 60000 texels");
}

#[test]
fn texture_indices_are_checked_even_where_unused() {
    for field in ["normalTexture", "occlusionTexture", "emissiveTexture"] {
        with_material(json!({ field: { "index": 3 } })).assert_error(&format!("materials[0].{field}.index"));
    }
}

/// A triangle of material 0, which is material 1 in the first of two variants and is not mentioned by the second.
pub(in super::super) fn with_variants() -> File {
    let mut file = with_material(json!({ "name": "plain" }));
    file.push("materials", json!({ "name": "gilt" }));
    file.json["extensions"]["KHR_materials_variants"] = json!({ "variants": [{ "name": "Gold" }, { "name": "Bare" }] });
    file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"] =
        json!({ "mappings": [{ "material": 1, "variants": [0] }] });
    file
}

#[test]
fn a_variant_has_the_materials_that_its_mappings_name() {
    let (json, binary) = (with_variants().json, with_variants().binary);
    let read = |variant| {
        let file = File { json: json.clone(), binary: binary.clone() };
        from_slice_as("test.glb", &file.glb(), &NoFiles, variant).unwrap()
    };
    for (variant, material) in [(None, 0), (Some("Gold"), 1), (Some("Bare"), 0), (Some("Silver"), 0)] {
        let model = read(variant);
        assert_eq!(model.meshes[0].primitives[0].material, material, "{variant:?}");
        assert_eq!(model.variants, ["Gold", "Bare"]);
        assert_eq!(model.variant.as_deref(), variant.filter(|name| *name != "Silver"));
    }
    let mut broken = with_variants();
    broken.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] =
        json!(7);
    let error = from_slice_as("test.glb", &broken.glb(), &NoFiles, Some("Gold")).unwrap_err().to_string();
    assert!(error.contains("KHR_materials_variants.mappings[0].material"), "{error}");
}

/// The finish of objects in scene files is that of glTF's materials of the same factors.
#[test]
fn objects_of_scene_files_have_the_same_finish() {
    let cases = [
        ("metallic = 1\nroughness = 0.4", json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.4 } })),
        ("metallic = 1\nroughness = 0", json!({ "pbrMetallicRoughness": { "roughnessFactor": 0 } })),
        (
            "roughness = 0.1\ncoat = 0.7\ncoat_roughness = 0.2\nemission = [0, 0.5, 1]",
            json!({
                "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.1 },
                "emissiveFactor": [0, 0.5, 1],
                "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.2 } }
            }),
        ),
        (
            "roughness = 0\nior = 1.33\ntransmission = 1\nattenuation_color = [0.5, 0.9, 1]\nattenuation_distance = 2",
            json!({
                "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
                "extensions": {
                    "KHR_materials_ior": { "ior": 1.33 },
                    "KHR_materials_transmission": { "transmissionFactor": 1 },
                    "KHR_materials_volume": {
                        "thicknessFactor": 1, "attenuationColor": [0.5, 0.9, 1], "attenuationDistance": 2
                    }
                }
            }),
        ),
        (
            "roughness = 0.3\ntransmission = 0.5\nthin = true",
            json!({
                "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.3 },
                "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.5 } }
            }),
        ),
        (
            "roughness = 0\ntransmission = 1\ndispersion = 0.5",
            json!({
                "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
                "extensions": {
                    "KHR_materials_transmission": { "transmissionFactor": 1 },
                    "KHR_materials_volume": { "thicknessFactor": 1 },
                    "KHR_materials_dispersion": { "dispersion": 0.5 }
                }
            }),
        ),
        (
            "roughness = 0.9\nsheen = [0.2, 0.3, 0.4]\nsheen_roughness = 0.5",
            json!({
                "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.9 },
                "extensions": {
                    "KHR_materials_sheen": { "sheenColorFactor": [0.2, 0.3, 0.4], "sheenRoughnessFactor": 0.5 }
                }
            }),
        ),
    ];
    for (lines, entry) in cases {
        let text = format!("[[object]]\nshape = \"sphere\"\nradius = 1\n{lines}\n");
        let written = super::super::toml_model(&text).unwrap().materials.remove(0);
        let of_file = material(entry);
        let look = |material: Material| {
            let Material { role, ior, coat, absorption, mirror_roughness, schlick, emissive, .. } = material;
            (role, ior, coat, absorption, mirror_roughness, schlick, emissive, material.microfacets, material.lobes)
        };
        let (written, of_file) = (format!("{:?}", look(written)), format!("{:?}", look(of_file)));
        assert_eq!(written, of_file, "{lines}");
    }
    for (lines, message) in [
        ("roughness = 2", "line 4: object.roughness: 2; allowed is 0 to 1"),
        ("ior = 0.5", "line 4: object.ior: 0.5; allowed is 1 to 10"),
        ("unlit = true\ncoat = 1", "object.coat: is not for what is `unlit`"),
        ("coat_roughness = 0.1", "object.coat_roughness: has no effect without `coat`"),
        ("transmission = 1\nattenuation_distance = 1", "has no effect without `attenuation_color`"),
        ("roughnes = 0.5", "did you mean `roughness`"),
    ] {
        let text = format!("[[object]]\nshape = \"sphere\"\nradius = 1\n{lines}\n");
        let found = super::super::toml_model(&text).unwrap_err();
        assert!(found.contains(message), "{found}");
    }
}
