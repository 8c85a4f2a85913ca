//! Planar mirrors against the reference, which they equal at any order.

use catoptric::methods::Quality;
use catoptric::scene::{Material, Projection};
use catoptric_testkit::drawing::{draw, error_without_fallbacks, scene};
use catoptric_testkit::scenes::{SceneBuilder, sphere_in_room};
use glam::Vec3;

#[test]
fn planar_mirrors_are_exact_to_the_fourth_order() {
    for mirrors in ["1", "4"] {
        let scene = scene(&format!("planar_mirror?mirrors={mirrors}"));
        let view = scene.default_view(360, 240);
        for order in 1..=4 {
            let error = error_without_fallbacks("planar_mirror", "", &scene, &view, Quality { samples: 1, order });
            assert!(error.over_0_1 <= 6e-4 && error.flip_mean <= 3e-3, "{mirrors} mirrors, order {order}: {error:?}");
        }
    }
}

#[test]
fn planar_mirrors_are_exact_with_antialiasing_and_parallel_rays() {
    let scene = scene("planar_mirror?mirrors=2");
    let view = scene.default_view(300, 200);
    let quality = Quality { samples: 8, order: 3 };
    let over = error_without_fallbacks("planar_mirror", "", &scene, &view, quality).over_0_1;
    assert!(over <= 1e-4, "{over}");
    let mut camera = scene.camera(None, 1.0).expect("the test's input is valid");
    camera.projection = Projection::Orthographic { half_height: 1.2 };
    let view = scene.view(&camera, 300, 200);
    let over = error_without_fallbacks("planar_mirror", "", &scene, &view, quality).over_0_1;
    assert!(over <= 1e-4, "{over}");
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
    let error = error_without_fallbacks("planar_mirror", "", &scene, &view, Quality { samples: 4, order: 2 });
    assert!(error.over_0_1 == 0.0 && error.flip_mean <= 6e-4, "{error:?}");
}

#[test]
fn planar_mirror_says_what_it_cannot_draw() {
    let scene = sphere_in_room(false);
    let view = scene.default_view(60, 40);
    let report = draw("planar_mirror", "", &scene, &view, Quality { samples: 1, order: 1 }).setup;
    assert!(report.fallbacks["curved_triangles"] > 1000);
    assert_eq!(report.warnings.len(), 1);
}
