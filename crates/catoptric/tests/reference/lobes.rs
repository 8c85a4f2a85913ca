//! Lobes of surfaces that rays follow, against closed forms: the white furnace, thin walls, veils; by the reference and
//! as they are drawn without tracing first rays.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::Quality;
use catoptric::optics::fresnel_dielectric;
use catoptric::scene::{AlphaMode, Environment, Lobes, Material, Microfacets, Scene};
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
        for (name, facets, lobes) in [
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
