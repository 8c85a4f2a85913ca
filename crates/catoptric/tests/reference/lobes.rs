//! Lobes of surfaces that rays follow, against closed forms: the white furnace, thin walls, veils; by the reference and
//! as they are drawn without tracing first rays.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::Quality;
use catoptric::optics::fresnel_dielectric;
use catoptric::scene::{AlphaMode, Environment, Film, FilmAt, Lobes, Material, Microfacets, Scene};
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// A ball under a sky that is 1 everywhere.
fn furnace(facets: Microfacets, lobes: Lobes) -> Scene {
    let mut builder = SceneBuilder::new();
    let (microfacets, lobes) = (Some(facets), Some(Box::new(lobes)));
    let material = builder.material(Material { microfacets, lobes, ..Material::diffuse("white", Vec3::ONE) });
    builder.sphere_mesh("ball", Vec3::ZERO, 1.0, 32, material);
    builder.camera(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 32.0);
    let mut scene = builder.build();
    scene.tangents =
        scene.normals.iter().map(|normal| Vec3::Y.cross(*normal).normalize_or(Vec3::X).extend(1.0)).collect();
    scene.environment = Some(Arc::new(Environment::new("white", 16, 8, vec![[1.0; 3]; 16 * 8])));
    scene
}

fn mean(picture: &Framebuffer) -> f32 {
    picture.pixels.iter().map(|pixel| pixel[1]).sum::<f32>() / picture.pixels.len() as f32
}

#[test]
fn white_surfaces_under_a_white_sky_are_not_seen() {
    let quality = Quality { samples: 4, order: 16 };
    for roughness in [0.1, 0.4, 1.0] {
        let metal = Microfacets { metallic: 1.0, roughness, ..Microfacets::default() };
        let paint = Microfacets { roughness, ..Microfacets::default() };
        let glass = |is_thin: bool| Lobes { transmission: 1.0, is_thin, ..Lobes::default() };
        let brushed = Lobes { anisotropy: 0.7, anisotropy_rotation: 0.4, ..Lobes::default() };
        for (name, facets, lobes) in [
            ("brushed metal", metal.clone(), brushed),
            ("metal", metal, Lobes::default()),
            ("paint", paint.clone(), Lobes::default()),
            ("a wall", paint.clone(), glass(true)),
            ("glass", paint, glass(false)),
        ] {
            let scene = furnace(facets, lobes);
            let view = scene.default_view(24, 24);
            for method in ["reference", "auto"] {
                let found = mean(&picture(method, "", &scene, &view, quality));
                assert!((0.98..=1.02).contains(&found), "{name}, roughness {roughness}, {method}: {found}");
            }
        }
    }
}

/// The centre of a picture of a red, glowing wall, seen along the normal of a sheet before it.
fn behind(sheet: Material) -> [Vec4; 2] {
    let mut builder = SceneBuilder::new();
    let sheet = builder.material(sheet);
    builder.quad("sheet", Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0, sheet);
    let wall = builder.flat("wall", Vec3::new(0.8, 0.2, 0.1));
    builder.quad("wall", Vec3::new(-9.0, -9.0, -1.0), Vec3::X * 18.0, Vec3::Y * 18.0, wall);
    builder.camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 20.0);
    let mut scene = builder.build();
    // Without light there would be a headlight.
    scene.environment = Some(Arc::new(Environment::new("black", 4, 2, vec![[0.0; 3]; 8])));
    let view = scene.default_view(9, 9);
    let quality = Quality { samples: 1, order: 2 };
    ["reference", "auto"].map(|method| picture(method, "", &scene, &view, quality).pixel(4, 4).into())
}

#[test]
fn a_thin_wall_lets_what_one_interface_leaves_pass_straight_on() {
    let lobes = Some(Box::new(Lobes { transmission: 1.0, is_thin: true, ..Lobes::default() }));
    let smooth = Microfacets { roughness: 0.0, ..Microfacets::default() };
    let base = Vec3::new(0.9, 0.6, 0.3);
    let wall = Material { microfacets: Some(smooth), lobes, ior: 1.5, ..Material::diffuse("pane", base) };
    let passing = 1.0 - fresnel_dielectric(1.0, 1.0 / 1.5);
    for found in behind(wall) {
        let expected = Vec3::new(0.8, 0.2, 0.1) * base * passing;
        assert!((found.truncate() - expected).length() < 1e-3, "{found} against {expected}");
    }
}

#[test]
fn a_veil_covers_by_its_alpha() {
    let base_color = Vec4::new(0.0, 1.0, 0.0, 0.25);
    let lobes = Some(Box::default());
    let veil = Material {
        base_color,
        unlit: true,
        alpha_mode: AlphaMode::Blend,
        lobes,
        ..Material::diffuse("veil", Vec3::ONE)
    };
    for found in behind(veil) {
        let expected = Vec3::new(0.6, 0.25 + 0.15, 0.075);
        assert!((found.truncate() - expected).length() < 1e-3, "{found} against {expected}");
    }
}

#[test]
fn what_a_film_reflects_of_one_colour_passes_it_in_none() {
    let film = Film { share: 1.0, ior: 1.8, thickness_nm: [0.0, 300.0] };
    let lobes = Some(Box::new(Lobes { transmission: 1.0, is_thin: true, film: Some(film), ..Lobes::default() }));
    let smooth = Microfacets { roughness: 0.0, ..Microfacets::default() };
    let pane = Material { microfacets: Some(smooth), lobes, ior: 1.5, ..Material::diffuse("pane", Vec3::ONE) };
    let reflected = FilmAt { share: 1.0, ior: 1.8, thickness_nm: 300.0 }.reflectance(1.0, Vec3::splat(0.04));
    for found in behind(pane) {
        let expected = Vec3::new(0.8, 0.2, 0.1) * (1.0 - reflected.max_element());
        assert!((found.truncate() - expected).length() < 1e-3, "{found} against {expected}");
    }
}

#[test]
fn a_prism_parts_red_from_blue() {
    let (sine, cosine) = 20f32.to_radians().sin_cos();
    // Red light bends by 8.0 degrees, green by 10.9, blue by 13.8 (indices 1.375, 1.5, 1.625): 5 behind the prism they
    // are 0.71, 0.96 and 1.23 aside.
    let lobes = Some(Box::new(Lobes { transmission: 1.0, dispersion: 10.0, ..Lobes::default() }));
    let smooth = Microfacets { roughness: 0.0, ..Microfacets::default() };
    let glass = Material { microfacets: Some(smooth), lobes, ior: 1.5, ..Material::diffuse("glass", Vec3::ONE) };
    for (edge, expected) in [(-0.6, [false; 3]), (-0.85, [true, false, false]), (-1.1, [true, true, false])] {
        let mut builder = SceneBuilder::new();
        let prism = builder.material(glass.clone());
        builder.quad("front", Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0, prism);
        let across = Vec3::new(cosine, 0.0, sine);
        builder.quad("back", Vec3::new(0.0, -2.0, -1.0) - across * 2.0, Vec3::Y * 4.0, across * 4.0, prism);
        let wall = builder.flat("wall", Vec3::ONE);
        builder.quad("wall", Vec3::new(edge, -9.0, -6.0), Vec3::X * 9.0, Vec3::Y * 18.0, wall);
        builder.camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 2.0);
        let mut scene = builder.build();
        scene.environment = Some(Arc::new(Environment::new("black", 4, 2, vec![[0.0; 3]; 8])));
        let view = scene.default_view(9, 9);
        for method in ["reference", "auto"] {
            let quality = Quality { samples: 1, order: 2 };
            let found = picture(method, "", &scene, &view, quality).pixel(4, 4);
            for (channel, is_seen) in expected.into_iter().enumerate() {
                let range = if is_seen { 0.85..=0.95 } else { 0.0..=0.01 };
                assert!(range.contains(&found[channel]), "{method}, edge {edge}: {found:?}");
            }
        }
    }
}

#[test]
fn light_from_behind_shines_through_a_leaf() {
    let mut builder = SceneBuilder::new();
    let color = Vec3::new(0.2, 0.4, 0.8);
    let lobes = Lobes { diffuse_transmission: 0.5, diffuse_transmission_color: color, ..Lobes::default() };
    let matte = Microfacets { specular: Vec3::ZERO, specular_at_grazing: 0.0, ..Microfacets::default() };
    let (microfacets, lobes) = (Some(matte), Some(Box::new(lobes)));
    let leaf = builder.material(Material { microfacets, lobes, ..Material::diffuse("leaf", Vec3::ONE) });
    builder.quad("leaf", Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0, leaf);
    builder.camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 20.0);
    let mut scene = builder.build();
    let (width, height) = (64, 32);
    let sky = (0..width * height).map(|texel| {
        let (u, v) = ((texel % width) as f32 + 0.5, (texel / width) as f32 + 0.5);
        let direction = Environment::direction(u / width as f32, v / height as f32);
        [if direction.z < 0.0 { 1.0 } else { 0.0 }; 3]
    });
    scene.environment = Some(Arc::new(Environment::new("behind", width, height, sky.collect())));
    let view = scene.default_view(9, 9);
    for method in ["reference", "auto"] {
        let found = picture(method, "", &scene, &view, Quality { samples: 1, order: 2 }).pixel(4, 4);
        let found = Vec4::from(found).truncate();
        assert!((found - color * 0.5).abs().max_element() < 0.01, "{method}: {found}");
    }
}

#[test]
fn what_lies_beyond_the_order_is_the_environment_where_the_scene_says_so() {
    let mut builder = SceneBuilder::new();
    let tint = Vec3::new(0.9, 0.8, 0.7);
    let mirror = builder.material(Material::mirror("mirror", tint));
    // The mirror turns the view from -z to +x.
    builder.quad("mirror", Vec3::new(-1.0, -2.0, -1.0), Vec3::new(2.0, 0.0, 2.0), Vec3::Y * 4.0, mirror);
    builder.camera(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 4.0);
    let mut scene = builder.build();
    let sky = (0..64 * 32).map(|texel| {
        let direction = Environment::direction(((texel % 64) as f32 + 0.5) / 64.0, ((texel / 64) as f32 + 0.5) / 32.0);
        [1.5 + direction.x, 1.5 + direction.y, 1.5 + direction.z]
    });
    scene.environment = Some(Arc::new(Environment::new("sky", 64, 32, sky.collect())));
    let view = scene.default_view(9, 9);
    for method in ["reference", "auto"] {
        let mut seen = [Vec3::ZERO; 2];
        for (ends, seen) in [false, true].into_iter().zip(&mut seen) {
            scene.ends_in_environment = ends;
            let pixel = picture(method, "", &scene, &view, Quality { samples: 1, order: 0 }).pixel(4, 4);
            *seen = Vec4::from(pixel).truncate();
        }
        let side = seen[1].x / tint.x - 1.5;
        assert_eq!(seen[0], Vec3::ZERO, "{method}");
        assert!((side.abs() - 1.0).abs() < 0.02, "{method}: {seen:?}");
        let expected = tint * Vec3::new(1.5 + side.signum(), 1.5, 1.5);
        assert!((seen[1] - expected).abs().max_element() < 0.03, "{method}: {} against {expected}", seen[1]);
    }
}
