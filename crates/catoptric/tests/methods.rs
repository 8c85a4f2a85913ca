//! The methods against the reference, and against scenes where they are exact.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::reference::specular_mask;
use catoptric::methods::{self, Job, Quality, Report};
use catoptric::metrics::{Comparison, PictureError};
use catoptric::progress::Silent;
use catoptric::scene::{Camera, Environment, Material, PoseOptions, Projection, Scene, View, builtin};
use catoptric_testkit::scenes::{SceneBuilder, sphere_in_room};
use glam::Vec3;
use std::sync::Arc;

fn picture(id: &str, settings: &str, scene: &Scene, view: &View, quality: Quality) -> (Framebuffer, Report) {
    let mut method = methods::create(id, &toml::from_str(settings).expect("the test's input is valid"))
        .expect("the test's input is valid");
    let mut report = method.prepare(scene, quality, &Silent).expect("the test's input is valid");
    let mut target = Framebuffer::new(view.width, view.height);
    let frame = method
        .render(&Job { scene, view, quality, progress: &Silent }, &mut target)
        .expect("the test's input is valid");
    report.fallbacks.extend(frame.fallbacks);
    assert!(target.pixels.iter().flatten().all(|value| value.is_finite()), "{id}");
    (target, report)
}

/// The error over reflector pixels.
fn error(id: &str, settings: &str, scene: &Scene, view: &View, quality: Quality) -> PictureError {
    let (drawn, report) = picture(id, settings, scene, view, quality);
    assert!(report.fallbacks.is_empty(), "{:?}", report.fallbacks);
    let (truth, _) = picture("reference", "", scene, view, quality);
    let mask = specular_mask(scene, view);
    Comparison::new(&drawn, &truth)
        .expect("the test's input is valid")
        .masked(&mask)
        .expect("the test's input is valid")
        .expect("the reflector is seen")
}

#[test]
fn planar_mirrors_are_exact_to_the_fourth_order() {
    for mirrors in ["1", "2", "3", "4"] {
        let scene = builtin::load("planar_mirror", &[("mirrors", mirrors)]).expect("the test's input is valid");
        let scene = scene.pose(&PoseOptions::default()).expect("the test's input is valid");
        let view = scene.default_view(360, 240);
        for order in 1..=4 {
            let error = error("planar_mirror", "", &scene, &view, Quality { samples: 1, order });
            assert!(error.over_0_1 <= 1e-3, "{mirrors} mirrors, order {order}: {error:?}");
        }
    }
}

#[test]
fn planar_mirrors_are_exact_with_antialiasing_and_parallel_rays() {
    let scene = builtin::load("planar_mirror", &[("mirrors", "2")]).expect("the test's input is valid");
    let scene = scene.pose(&PoseOptions::default()).expect("the test's input is valid");
    let view = scene.default_view(300, 200);
    let quality = Quality { samples: 8, order: 3 };
    let over = error("planar_mirror", "", &scene, &view, quality).over_0_1;
    assert!(over <= 1e-3, "{over}");
    let mut camera = scene.camera(None).expect("the test's input is valid");
    camera.projection = Projection::Orthographic { half_height: 1.2 };
    let view = scene.view(&camera, 300, 200);
    let over = error("planar_mirror", "", &scene, &view, quality).over_0_1;
    assert!(over <= 1e-3, "{over}");
}

#[test]
fn a_cube_mirror_has_six_planes_and_coats_mix() {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 6, [40, 60, 90], [230, 220, 200]);
    builder.cuboid("room", Vec3::splat(-4.0), Vec3::splat(4.0), true, walls);
    let paint = builder.material(Material {
        role: catoptric::scene::Role::Coated,
        coat: 1.0,
        unlit: true,
        ..Material::diffuse("paint", Vec3::new(0.7, 0.1, 0.1))
    });
    builder.cuboid("block", Vec3::new(-1.0, -1.0, -1.0), Vec3::new(1.0, 0.5, 1.0), false, paint);
    builder.camera(Vec3::new(2.0, 1.5, 3.0), Vec3::new(0.0, -0.2, 0.0), 45.0);
    let scene = builder.build();
    let view = scene.default_view(240, 160);
    let error = error("planar_mirror", "", &scene, &view, Quality { samples: 4, order: 2 });
    assert!(error.over_0_1 <= 1e-3, "{error:?}");
}

#[test]
fn planar_mirror_says_what_it_cannot_draw() {
    let scene = sphere_in_room(false);
    let view = scene.default_view(60, 40);
    let (_, report) = picture("planar_mirror", "", &scene, &view, Quality { samples: 1, order: 1 });
    assert!(report.fallbacks["curved_triangles"] > 1000);
    assert_eq!(report.warnings.len(), 1);
}

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
    let given = error("environment_map", "source = 'environment'", &scene, &view, quality);
    assert!(given.rmse < 1e-4, "{given:?}");
    let captured = error("environment_map", "", &scene, &view, quality);
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
    let corrected = error("environment_map", "parallax = 'box'\nsize = 1024", &scene, &view, quality);
    let plain = error("environment_map", "size = 1024", &scene, &view, quality);
    // What is left is the filtering of the map at the edges of the checker.
    assert!(corrected.flip_mean < 0.05, "{corrected:?}");
    assert!(plain.flip_mean > 3.0 * corrected.flip_mean, "{plain:?} against {corrected:?}");
    assert!(plain.over_0_1 > 3.0 * corrected.over_0_1, "{plain:?} against {corrected:?}");
}

#[test]
fn glass_by_environment_map_mixes_by_fresnel() {
    // At the centre of the ball light is met straight on: 4 % are reflected, the rest goes on undeviated.
    let scene = ball_in_sky(Material::glass("glass", 1.5));
    let camera = Camera::look_at("", Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 10.0);
    let view = scene.view(&camera, 1, 1);
    let quality = Quality { samples: 1, order: 1 };
    let (drawn, _) = picture("environment_map", "source = 'environment'", &scene, &view, quality);
    let expected = scene.background(Vec3::Z) * 0.04 + scene.background(Vec3::NEG_Z) * 0.96;
    let [r, g, b, _] = drawn.pixels[0];
    assert!((Vec3::new(r, g, b) - expected).length() < 1e-3, "{r} {g} {b} against {expected}");
}

#[test]
fn order_zero_draws_reflectors_black_in_every_method() {
    let scene = sphere_in_room(true);
    let view = scene.default_view(40, 30);
    let mask = specular_mask(&scene, &view);
    for info in methods::all() {
        let (drawn, _) = picture(info.id, "", &scene, &view, Quality { samples: 1, order: 0 });
        for (pixel, reflector) in drawn.pixels.iter().zip(&mask) {
            assert_eq!(pixel[..3] == [0.0; 3], *reflector, "{}", info.id);
        }
    }
}

#[test]
fn settings_that_do_not_exist_are_named() {
    for info in methods::all() {
        let table = toml::from_str("no_such_setting = 1").expect("the test's input is valid");
        let message = methods::create(info.id, &table).err().expect("it is refused").to_string();
        assert!(message.contains("no_such_setting") && message.contains(info.id), "{message}");
        for setting in (info.settings)() {
            assert!(message.contains(&setting.name), "{message}");
        }
    }
    assert!(methods::find("nothing").unwrap_err().to_string().contains("reference"));
}
