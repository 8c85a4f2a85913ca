//! Environment maps against the reference, on scenes for which they are exact.

use catoptric::methods::Quality;
use catoptric::scene::{Camera, Environment, Material, Scene};
use catoptric_testkit::drawing::{error_without_fallbacks, picture};
use catoptric_testkit::scenes::SceneBuilder;
use glam::Vec3;
use std::sync::Arc;

/// A ball in a sky of smooth colours, with nothing near.
fn ball_in_sky(material: Material) -> Scene {
    let mut builder = SceneBuilder::new();
    let material = builder.material(material);
    builder.sphere("ball", Vec3::ZERO, 1.0, material);
    builder.camera(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 40.0);
    let mut scene = builder.build();
    let (width, height) = (256, 128);
    let texel = |i: u32| {
        let d = Environment::direction((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
        ((d + 1.0) * 0.5).to_array()
    };
    let sky = Environment::new("sky", width, height, (0..width * height).map(texel).collect());
    scene.environment = Some(Arc::new(sky));
    scene
}

#[test]
fn environment_maps_are_exact_for_what_is_infinitely_far() {
    let scene = ball_in_sky(Material::mirror("mirror", Vec3::new(0.9, 0.8, 0.7)));
    let view = scene.default_view(200, 150);
    let quality = Quality { samples: 1, order: 1 };
    let given = error_without_fallbacks("environment_map", "source = 'environment'", &scene, &view, quality);
    assert!(given.rmse < 1e-4, "{given:?}");
    let captured = error_without_fallbacks("environment_map", "", &scene, &view, quality);
    assert!(captured.rmse < 5e-3, "{captured:?}");
}

#[test]
fn box_parallax_is_exact_in_a_bare_box_and_infinity_is_not() {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 4, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::new(-3.0, -2.0, -3.0), Vec3::new(3.0, 2.0, 3.0), true, walls);
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.sphere("ball", Vec3::new(0.5, -0.3, -0.5), 1.0, mirror);
    builder.camera(Vec3::new(0.0, 1.0, 2.8), Vec3::new(0.3, -0.2, -0.5), 50.0);
    let scene = builder.build();
    let view = scene.default_view(200, 150);
    let quality = Quality { samples: 4, order: 1 };
    let corrected = error_without_fallbacks("environment_map", "parallax = 'box'\nsize = 1024", &scene, &view, quality);
    let plain = error_without_fallbacks("environment_map", "size = 1024", &scene, &view, quality);
    // The remaining error is the filtering of the map at the edges of the checker.
    assert!(corrected.flip_mean < 0.05, "{corrected:?}");
    assert!(plain.flip_mean > 3.0 * corrected.flip_mean, "{plain:?} against {corrected:?}");
    assert!(plain.over_0_1 > 3.0 * corrected.over_0_1, "{plain:?} against {corrected:?}");
}

#[test]
fn glass_by_environment_map_mixes_by_fresnel() {
    // Light is met straight on at the centre of the ball: 4 % are reflected, the rest goes on undeviated.
    let scene = ball_in_sky(Material::glass("glass", 1.5));
    let camera = Camera::look_at("", Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 10.0);
    let view = scene.view(&camera, 1, 1);
    let quality = Quality { samples: 1, order: 1 };
    let drawn = picture("environment_map", "source = 'environment'", &scene, &view, quality);
    let expected = scene.background(Vec3::Z) * 0.04 + scene.background(Vec3::NEG_Z) * 0.96;
    let [r, g, b, _] = drawn.pixels[0];
    assert!((Vec3::new(r, g, b) - expected).length() < 1e-3, "{r} {g} {b} against {expected}");
}
