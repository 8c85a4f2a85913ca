//! Pieces of pictures that a method of projection cannot draw are drawn by something else, or counted: never wrong
//! without a word.

use catoptric::methods::Quality;
use catoptric::scene::{Material, Scene};
use catoptric_testkit::Drawn;
use catoptric_testkit::drawing::{draw, picture, reflector_error, scene};
use catoptric_testkit::scenes::SceneBuilder;
use glam::Vec3;

const METHODS: [&str; 4] = ["path_perturbation", "sample_based_camera", "explosion_map", "reflector_search"];

fn warns(drawn: &Drawn, word: &str) -> bool {
    drawn.report.warnings.iter().any(|warning| warning.contains(word))
}

fn fallback(drawn: &Drawn, name: &str) -> u64 {
    drawn.report.fallbacks.get(name).copied().unwrap_or(0)
}

#[test]
fn paths_of_more_bounces_than_are_projected_are_drawn_by_tiles() {
    assert_longer_paths_are_drawn(&METHODS[..1]);
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn other_methods_leave_longer_paths_to_tiles_too() {
    assert_longer_paths_are_drawn(&METHODS[1..]);
}

/// Three flat mirrors that face each other show a fifth bounce and a sixth: projected paths have four.
fn assert_longer_paths_are_drawn(methods: &[&str]) {
    let scene = scene("planar_mirror?mirrors=3&tess=8");
    let view = scene.default_view(96, 72);
    let [four, six] = [4, 6].map(|order| Quality { samples: 4, order });
    let truths = [four, six].map(|quality| picture("reference", "", &scene, &view, quality));
    let longer = reflector_error(&truths[0], &truths[1], &scene, &view).over_0_1;
    assert!(longer > 0.01, "longer paths show in {longer} of the mirrors alone");
    for &id in methods {
        let own = |quality| draw(id, "work = 150.0\nedge_error_px = 1.0\npiece_px = 2.0", &scene, &view, quality);
        let (drawn, shorter) = (own(six), own(four));
        let errors = [(&shorter, &truths[0]), (&drawn, &truths[1])]
            .map(|(drawn, truth)| reflector_error(&drawn.picture, truth, &scene, &view).over_0_1);
        assert!(errors[1] < errors[0] + 0.003, "{id}: {} of the pixels, and {} at order 4", errors[1], errors[0]);
        assert_eq!(fallback(&shorter, "paths_drawn_by_tiles"), 0, "{id}");
        assert!(fallback(&drawn, "paths_drawn_by_tiles") > 0 && warns(&drawn, "bounces"), "{id}: {:?}", drawn.report);
        let coarse =
            draw(id, "work = 150.0\nedge_error_px = 2.0\npiece_px = 4.0\nbeyond_work = 'coarse'", &scene, &view, six);
        assert!(fallback(&coarse, "paths_too_long") > 0 && warns(&coarse, "bounces"), "{id}: {:?}", coarse.report);
    }
}

/// A ball of glass or, with its axes stretched, an egg: a mesh in a checkered room.
fn lens_in_room(stretch: Vec3) -> Scene {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 8, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::new(-3.0, 0.0, -3.0), Vec3::new(3.0, 3.0, 3.0), true, walls);
    let red = builder.checker("red", 4, [200, 30, 20], [240, 190, 60]);
    builder.cuboid("box", Vec3::new(0.2, 0.0, -2.5), Vec3::new(1.0, 1.2, -1.7), false, red);
    let glass = builder.material(Material::glass("glass", 1.5));
    builder.sphere_mesh("lens", Vec3::ZERO, 0.7, 24, glass);
    let lens = builder.model_mut().meshes.last_mut().expect("the lens was added last");
    for primitive in &mut lens.primitives {
        for (position, normal) in primitive.positions.iter_mut().zip(&mut primitive.normals) {
            *position = *position * stretch + Vec3::new(0.0, 1.3, 0.0);
            *normal = (*normal / stretch).normalize();
        }
    }
    builder.camera(Vec3::new(0.3, 1.5, 2.6), Vec3::new(0.0, 1.3, 0.0), 50.0);
    builder.build()
}

#[test]
fn no_part_of_an_egg_of_glass_is_drawn_wrong_without_a_word() {
    assert_lens_is_right_or_told(Vec3::new(0.9, 1.5, 0.9), &[("", 0.01)]);
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn no_part_of_a_ball_of_glass_is_drawn_wrong_without_a_word() {
    // The method's own drawing may be off by a pixel: by parts of the narrow squares here.
    assert_lens_is_right_or_told(Vec3::ONE, &[("", 0.01), ("work = 150.0", 0.03)]);
}

/// Beside the rim of a lens, and where its rays cross, virtual objects have holes and appear where they do not.
fn assert_lens_is_right_or_told(stretch: Vec3, limits: &[(&str, f64)]) {
    let quality = Quality { samples: 4, order: 2 };
    let scene = lens_in_room(stretch);
    let view = scene.default_view(96, 72);
    let truth = picture("reference", "", &scene, &view, quality);
    for id in ["explosion_map", "reflector_search"] {
        for &(settings, most) in limits {
            let drawn = draw(id, settings, &scene, &view, quality);
            let error = reflector_error(&drawn.picture, &truth, &scene, &view);
            assert!(error.over_0_1 < most, "{id} {settings}: {error:?}, {:?}", drawn.report.fallbacks);
        }
        let coarse = draw(id, "work = 8.0\nbeyond_work = 'coarse'", &scene, &view, quality);
        let error = reflector_error(&coarse.picture, &truth, &scene, &view);
        let is_told = fallback(&coarse, "wrong_lens_blocks") > 0 && warns(&coarse, "parts of lenses are wrong");
        assert!(error.over_0_1 < 0.03 || is_told, "{id}: {error:?}, {:?}", coarse.report.fallbacks);
    }
}

/// Whoever draws the paths, and whatever limit ends them.
#[test]
fn rough_mirrors_look_the_same_whatever_the_work() {
    let scene = scene("brushed?tess=16");
    let view = scene.default_view(96, 64);
    let quality = Quality { samples: 4, order: 1 };
    let blurred = picture("multiperspective", "", &scene, &view, quality);
    let error = |picture| reflector_error(&picture, &blurred, &scene, &view).flip_mean;
    let smooth_scene = self::scene("brushed?tess=16&roughness=0.01");
    let smooth = error(picture("multiperspective", "", &smooth_scene, &view, quality));
    for id in METHODS {
        for settings in ["work = 0.0", "", "work = 1000.0", "work = 1000.0\nbeyond_work = 'coarse'"] {
            let drawn = draw(id, settings, &scene, &view, quality);
            assert!(!warns(&drawn, "rough"), "{id} {settings}: {:?}", drawn.report.warnings);
            let error = error(drawn.picture);
            assert!(error < 0.4 * smooth, "{id} {settings}: {error}, smooth ones {smooth}");
        }
    }
}
