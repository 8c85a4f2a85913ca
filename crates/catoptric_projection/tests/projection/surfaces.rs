//! Rough and bumpy mirrors against the reference.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::cast_shadows;
use catoptric::methods::Quality;
use catoptric_testkit::drawing::{draw, picture, reflector_error, scene};

/// Rays from each place of a rough mirror that make the truth: 256 a pixel.
const TRUTH: &str = "rough_rays = 64";

const QUALITY: Quality = Quality { samples: 4, order: 2 };

fn assert_blurred(roughness: f32) {
    let scene = scene(&format!("brushed?tess=24&roughness={roughness}"));
    let view = scene.default_view(120, 80);
    let truth = picture("reference", TRUTH, &scene, &view, QUALITY);
    let error = |method: &str| reflector_error(&picture(method, "", &scene, &view, QUALITY), &truth, &scene, &view);
    let (tiles, auto, map) = (error("multiperspective"), error("auto"), error("environment_map"));
    assert!(tiles.flip_mean < 0.05, "roughness {roughness}: {tiles:?}");
    assert!(auto.flip_mean < 0.05, "roughness {roughness}: {auto:?}");
    assert!(map.flip_mean > 2.0 * tiles.flip_mean, "roughness {roughness}: {map:?}");
}

#[test]
fn rough_mirrors_are_blurred_as_their_facets_do() {
    assert_blurred(0.2);
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn smoother_and_rougher_mirrors_are_blurred_as_their_facets_do() {
    assert_blurred(0.1);
    assert_blurred(0.4);
}

#[test]
fn other_methods_say_that_they_draw_rough_and_bumpy_surfaces_as_smooth_ones() {
    let searching = ["path_perturbation", "sample_based_camera", "reflector_search"];
    for (spec, word) in [("brushed?tess=8", "rough"), ("rippled?tess=8", "bumpy")] {
        let scene = scene(spec);
        let view = scene.default_view(24, 16);
        let warns = |method: &str| {
            let drawn = draw(method, "", &scene, &view, Quality { samples: 1, order: 1 });
            drawn.setup.warnings.iter().chain(&drawn.report.warnings).any(|warning| warning.contains(word))
        };
        assert!(warns("planar_mirror"), "{spec}");
        for method in searching {
            assert_eq!(warns(method), word == "bumpy", "{method} on {spec}");
        }
        for method in ["multiperspective", "auto", "environment_map"] {
            assert!(!warns(method), "{method} on {spec}");
        }
    }
}

#[test]
fn bumps_turn_rays_as_in_the_reference() {
    let scene = scene("rippled?tess=16");
    for camera in 0..2 {
        let view = scene.view(&scene.cameras[camera], 240, 160);
        let truth: Framebuffer = picture("reference", "", &scene, &view, Quality { samples: 16, order: 2 });
        for method in ["multiperspective", "auto"] {
            let found = picture(method, "", &scene, &view, Quality { samples: 16, order: 2 });
            let error = reflector_error(&found, &truth, &scene, &view);
            assert!(error.over_0_1 < 0.02, "{method}, camera {camera}: {error:?}");
        }
        // Smooth surfaces show other things.
        let smooth = picture("path_perturbation", "", &scene, &view, Quality { samples: 4, order: 1 });
        assert!(reflector_error(&smooth, &truth, &scene, &view).over_0_1 > 0.2);
    }
}

#[test]
fn ripples_smaller_than_a_pixel_blur_what_water_shows() {
    let scene = scene("rippled?tess=16&copies=40");
    let view = scene.default_view(240, 160);
    let truth = picture("reference", "", &scene, &view, Quality { samples: 16, order: 2 });
    for method in ["multiperspective", "auto"] {
        let error = reflector_error(&picture(method, "", &scene, &view, QUALITY), &truth, &scene, &view);
        assert!(error.flip_mean < 0.08, "{method}: {error:?}");
    }
    let map = reflector_error(&picture("environment_map", "", &scene, &view, QUALITY), &truth, &scene, &view);
    assert!(map.flip_mean > 0.2, "{map:?}");
}

fn assert_workbench(camera: usize) {
    let mut scene = scene("workshop?tess=24");
    cast_shadows(&mut scene);
    let view = scene.view(&scene.cameras[camera], 120, 80);
    let truth = picture("reference", TRUTH, &scene, &view, QUALITY);
    let error = |method: &str| reflector_error(&picture(method, "", &scene, &view, QUALITY), &truth, &scene, &view);
    let (tiles, map) = (error("multiperspective"), error("environment_map"));
    assert!(tiles.flip_mean < 0.055, "{tiles:?}");
    assert!(map.flip_mean > 3.0 * tiles.flip_mean, "{map:?}");
}

#[test]
fn things_on_a_workbench_look_as_in_the_reference() {
    assert_workbench(0);
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn things_on_a_workbench_look_as_in_the_reference_from_nearby() {
    assert_workbench(1);
}
