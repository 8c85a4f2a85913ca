//! Points that are shaded together.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::shade::Barycentrics;
use catoptric_core::scene::{
    AlphaMode, Environment, Light, LightKind, Material, Microfacets, NormalMap, Object, OcclusionMap, Sampler, Scene,
    SurfaceQuery, Texture, TextureBinding,
};
use glam::{Affine2, Vec2, Vec3};
use std::sync::Arc;

/// Random triangles of ten materials: lit, unlit, glowing, with facets and normal maps, with and without textures.
fn scene(random: &mut Stream, colors: bool) -> Scene {
    let texel = |i: u32| [(i * 7919 % 65_536) as u16, (i * 104_729 % 65_536) as u16, 40_000, 65_535];
    let texture = Texture::from_linear16("", 32, 16, (0..512).map(texel).collect(), Sampler::default());
    let binding = |texture, uv_channel| {
        let texture_from_uv = Affine2::from_scale_angle_translation(Vec2::new(2.0, 0.5), 0.4, Vec2::new(0.1, -3.0));
        Some(TextureBinding { texture, uv_channel, texture_from_uv })
    };
    let plain = Material::diffuse("", Vec3::new(0.2, 0.5, 0.9));
    let textured = Material { base_texture: binding(0, 0), ..plain.clone() };
    let materials = vec![
        Material { base_texture: binding(0, 1), unlit: true, ..plain.clone() },
        Material { emissive: Vec3::new(3.0, 0.0, 0.5), ..textured.clone() },
        Material { emissive: Vec3::ONE, emissive_texture: binding(0, 1), ..textured.clone() },
        // A texture that does not exist is white.
        Material { base_texture: binding(7, 0), ..plain.clone() },
        Material { unlit: true, ..plain.clone() },
        Material { microfacets: Some(Microfacets { roughness: 0.4, ..Microfacets::default() }), ..plain.clone() },
        Material {
            microfacets: Some(Microfacets {
                metallic: 0.9,
                roughness: 0.7,
                texture: binding(0, 0),
                coat: 0.3,
                ..Microfacets::default()
            }),
            occlusion_map: binding(0, 0).map(|binding| OcclusionMap { binding, strength: 0.7 }),
            emissive: Vec3::ONE,
            emissive_texture: binding(0, 1),
            ..textured.clone()
        },
        Material {
            microfacets: Some(Microfacets { roughness: 0.3, texture: binding(0, 1), ..Microfacets::default() }),
            normal_map: binding(1, 0).map(|binding| NormalMap { binding, scale: 1.5 }),
            occlusion_map: binding(0, 1).map(|binding| OcclusionMap { binding, strength: 1.0 }),
            ..plain.clone()
        },
        plain,
        textured,
    ];
    let bump = |i: u32| [(i * 7919 % 256) as u8, (i * 1031 % 256) as u8, 200, 255];
    let bumps: Vec<[u8; 4]> = (0..256).map(bump).collect();
    let bumps = Texture::from_normals8("", 16, 16, &bumps, Sampler::default());
    let mut scene = Scene { materials, textures: vec![Arc::new(texture), Arc::new(bumps)], ..Scene::default() };
    let materials = scene.materials.len() as u32;
    for triangle in 0..70u32 {
        let mut number = || random.next_between(-1.0, 1.0);
        for _ in 0..3 {
            scene.positions.push(Vec3::new(number(), number(), number()) * 3.0);
            scene.normals.push(Vec3::new(number(), number(), number()).normalize_or_zero());
            scene.uvs.push([Vec2::new(number(), number()), Vec2::new(number(), number()) * 9.0]);
            let tangent = Vec3::new(number(), number(), number()).normalize_or(Vec3::X);
            scene.tangents.push(tangent.extend(if number() < 0.0 { -1.0 } else { 1.0 }));
            if colors {
                scene.colors.push([number().abs(), number().abs(), number().abs(), 1.0]);
            }
        }
        // Corners whose normals cancel out.
        if triangle % 10 == 9 {
            let last = scene.normals.len() - 1;
            scene.normals[last - 2..].copy_from_slice(&[Vec3::X, Vec3::NEG_X, Vec3::ZERO]);
        }
        scene.triangles.push([triangle * 3, triangle * 3 + 1, triangle * 3 + 2]);
        scene.triangle_objects.push(triangle % materials);
    }
    for material in 0..materials {
        scene.objects.push(Object {
            name: String::new(),
            material,
            triangles: 0..0,
            vertices: 0..0,
            surface: None,
            inside: false,
            bounds: Default::default(),
        });
    }
    scene
}

fn lights() -> Vec<Light> {
    let (inner_cos, outer_cos) = (0.9, 0.3);
    let kinds = [
        LightKind::Directional,
        LightKind::Point { range: f32::INFINITY },
        LightKind::Point { range: 2.5 },
        LightKind::Spot { range: f32::INFINITY, inner_cos, outer_cos },
        LightKind::Spot { range: 4.0, inner_cos: 0.5, outer_cos: 0.5 },
    ];
    let light = |kind| Light {
        kind,
        intensity: Vec3::new(1.0, 2.0, 0.3),
        position: Vec3::new(0.3, -0.7, 1.9),
        direction: Vec3::new(0.6, 0.0, -0.8),
    };
    kinds.map(light).to_vec()
}

#[test]
fn batches_give_what_single_points_give() {
    let mut random = Stream::new(9);
    for round in 0..8 {
        let mut scene = scene(&mut random, round & 1 != 0);
        if round & 2 != 0 {
            scene.lights = lights();
        }
        if round & 4 != 0 {
            let sky = (0..32).map(|i| [i as f32, 1.0, 0.2]).collect();
            scene.environment = Some(Arc::new(Environment::new("sky", 8, 4, sky)));
        }
        for (count, alike) in [(0, 1), (1, 1), (7, 1), (8, 8), (9, 8), (333, 1), (333, 20)] {
            let queries: Vec<SurfaceQuery> = (0..count)
                .map(|index| {
                    let mut pair = |scale: f32| Vec2::new(random.next_unit(), random.next_unit()) * scale;
                    let barycentrics =
                        Barycentrics { value: pair(0.5), dx: pair(0.2), dy: pair(0.02), samples: index % 9 };
                    // The middle of an edge, where opposite normals cancel out.
                    let middle = Barycentrics { value: Vec2::new(0.5, 0.0), ..barycentrics };
                    SurfaceQuery {
                        triangle: index / alike * 31 % 70,
                        barycentrics: if index % 5 == 0 { middle } else { barycentrics },
                        towards_viewer: (pair(2.0) - 1.0).extend(1.0 - random.next_unit()) * 7.0,
                    }
                })
                .collect();
            let mut colors = vec![Vec3::NAN; queries.len()];
            scene.radiance_batch(&queries, &mut colors);
            for (query, color) in queries.iter().zip(&colors) {
                let point = scene.surface_point(query.triangle, &query.barycentrics);
                let expected = scene.radiance(&point, query.towards_viewer.normalize_or_zero());
                let error = (*color - expected).abs().max_element();
                assert!(error <= 2e-5 * (1.0 + expected.max_element()), "{color} against {expected}: {query:?}");
            }
        }
    }
}

/// Somewhere in a triangle.
fn within() -> Barycentrics {
    Barycentrics { value: Vec2::splat(0.3), dx: Vec2::ZERO, dy: Vec2::ZERO, samples: 1 }
}

/// Where glTF keeps them: a texture of one colour is a factor.
#[test]
fn roughness_is_in_the_green_channel_and_metal_in_the_blue_one() {
    let mut scene = scene(&mut Stream::new(3), false);
    scene.lights = lights();
    let texel = [60_000, 20_000, 50_000, 65_535];
    let texture = scene.textures.len() as u32;
    scene.textures.push(Arc::new(Texture::from_linear16("", 1, 1, vec![texel], Sampler::default())));
    let of_texture = TextureBinding { texture, uv_channel: 0, texture_from_uv: Affine2::IDENTITY };
    let shades = |of_facets: Microfacets| -> Vec<Vec3> {
        let mut scene = scene.clone();
        for material in &mut scene.materials {
            *material = Material::diffuse("", Vec3::new(0.9, 0.5, 0.1));
            material.microfacets = Some(of_facets.clone());
        }
        let towards_viewer = Vec3::new(0.3, 0.4, 0.9);
        let query = |triangle| SurfaceQuery { triangle, barycentrics: within(), towards_viewer };
        let queries: Vec<SurfaceQuery> = (0..70).map(query).collect();
        let mut colors = vec![Vec3::NAN; queries.len()];
        scene.radiance_batch(&queries, &mut colors);
        colors
    };
    let [roughness, metallic] = [20_000.0, 50_000.0].map(|value| value / 65_535.0);
    let textured = Microfacets { metallic: 1.0, texture: Some(of_texture), ..Microfacets::default() };
    let found = shades(textured);
    let expected = shades(Microfacets { metallic, roughness, ..Microfacets::default() });
    assert!(expected.iter().any(|color| color.max_element() > 0.1));
    for (found, expected) in found.iter().zip(&expected) {
        assert!(found.abs_diff_eq(*expected, 1e-4 * (1.0 + expected.max_element())), "{found} against {expected}");
    }
}

#[test]
fn masks_leave_out_what_is_below_their_cutoff() {
    let scene = scene(&mut Stream::new(3), false);
    let point = scene.surface_point(0, &within());
    for (alpha, is_present) in [(0.0, false), (0.49, false), (0.5, true), (1.0, true)] {
        let base_color = Vec3::ONE.extend(alpha);
        let material = Material { base_color, alpha_mode: AlphaMode::Mask(0.5), ..Material::default() };
        assert_eq!(scene.is_present(&material, &point), is_present, "alpha {alpha}");
        assert!(scene.is_present(&Material { alpha_mode: AlphaMode::Opaque, ..material }, &point));
    }
}
