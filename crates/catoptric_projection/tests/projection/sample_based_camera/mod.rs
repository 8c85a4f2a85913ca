//! Sample-based cameras against the reference, by pictures and by round trips, and where there is little to draw.

mod baked_nodes;
mod morphing;
mod moving_mirrors;
mod panoramic_cameras;

use catoptric::methods::projection::measure::round_trip::RoundTripOptions;
use catoptric::methods::projection::sample_based_camera::SampleBasedCameraSettings;
use catoptric::methods::{Quality, Settings};
use catoptric::scene::{Material, Scene};
use catoptric_testkit::drawing::{draw, measured, picture, round_trips_in, scene, session};
use catoptric_testkit::scenes::SceneBuilder;
use glam::Vec3;

const ID: &str = "sample_based_camera";

/// A count of the report of a small picture.
fn count(scene: &Scene, settings: &str, what: &str) -> u64 {
    let view = scene.default_view(120, 90);
    let quality = Quality { samples: 1, order: 1 };
    draw(ID, settings, scene, &view, quality).report.counts[what]
}

#[test]
fn all_pixels_are_within_the_accuracy_on_smooth_mirrors() {
    for name in ["sphere_room?surface=analytic&tess=24", "ellipsoid?tess=24", "dish?tess=24"] {
        let scene = scene(name);
        // Rays every second pixel; every pixel is tested, those between the last ray and the silhouette too.
        let (picture, trips) = measured(ID, &scene, "accuracy_px = 0.5", 1, 1);
        assert!(trips.all.count > 300, "{name}: {trips:?}");
        let (p99, max) = (trips.all.p99.expect("some are found"), trips.all.max.expect("some are found"));
        assert!(p99 <= 0.3 && max <= 0.7 && trips.all.missing == 0.0, "{name}: {trips:?}");
        assert!(trips.all.invented == 0.0, "{name}: {trips:?}");
        assert!(picture.over_0_1 <= 0.022, "{name}: {picture:?}");
    }
}

#[test]
fn leaves_are_one_for_a_flat_mirror_and_fewer_where_accuracy_is_less() {
    assert_eq!(count(&scene("planar_mirror?mirrors=1"), "accuracy_px = 0.05", "leaves"), 1);
    let ball = scene("sphere_room?surface=analytic&tess=8");
    let leaves = ["2", "0.5", "0.05"].map(|accuracy| count(&ball, &format!("accuracy_px = {accuracy}"), "leaves"));
    assert!(1 < leaves[0] && leaves[0] < leaves[1] && leaves[1] < leaves[2], "{leaves:?}");
    assert_eq!(count(&ball, "accuracy_px = 0.5", "ray_lists"), 0);
}

#[test]
fn pinholes_of_the_paper_keep_their_accuracy_too() {
    for name in ["sphere_room?surface=analytic&tess=24", "dish?tess=24"] {
        let scene = scene(name);
        let (_, trips) = measured(ID, &scene, "preset = 'faithful'", 1, 1);
        let (p99, max) = (trips.all.p99.expect("some are found"), trips.all.max.expect("some are found"));
        assert!(p99 <= 1.0 && max <= 3.0 && trips.all.missing <= 1e-3, "{name}: {trips:?}");
    }
    // The rays of a flat mirror meet behind it: one pinhole, and from very far away one affine camera.
    assert_eq!(count(&scene("planar_mirror?mirrors=1"), "preset = 'faithful'\naccuracy_px = 0.05", "leaves"), 1);
    // Wherever a flat mirror lies: no image plane stands upright on it.
    let mut builder = SceneBuilder::new();
    let grey = builder.flat("grey", Vec3::splat(0.5));
    builder.cuboid("room", Vec3::splat(-3.0), Vec3::splat(3.0), true, grey);
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.quad("floor", Vec3::new(-1.0, -0.5, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0, mirror);
    assert_eq!(count(&builder.build(), "preset = 'faithful'\naccuracy_px = 0.05", "leaves"), 1);
    let ball = scene("sphere_room?surface=analytic&tess=8");
    let leaves = |settings: &str| count(&ball, settings, "leaves") + count(&ball, settings, "ray_lists");
    assert!(leaves("preset = 'faithful'") > leaves("accuracy_px = 1"), "bundles need fewer leaves than pinholes");
}

#[test]
fn pinholes_that_are_split_to_the_end_are_more_and_end_where_rays_cross_everywhere() {
    let ball = scene("sphere_room?surface=analytic&tess=8");
    let stops = ["1", "1.5", "2"];
    let leaves = stops.map(|stop| count(&ball, &format!("camera = 'pinhole'\nmax_shared = {stop}"), "leaves"));
    assert!(leaves[0] < leaves[1] && leaves[1] < leaves[2], "{leaves:?}");
    // Normals of a mesh bend from triangle to triangle: the paper's rule alone would not end there, nor on the ball.
    let teapot = scene("teapot?tess=4");
    let rays = |scene: &Scene, stop: &str, what: &str| count(scene, &format!("preset = 'faithful'\n{stop}"), what);
    for scene in [&ball, &teapot] {
        let (kept, listed) = (rays(scene, "", "ray_map_rays"), rays(scene, "", "rays_in_lists"));
        assert!(listed > rays(scene, "max_shared = 1.5", "rays_in_lists"), "{listed} of {kept}");
        // A level of splits may not hold more rays than all splits may share out.
        assert!(listed <= 48 * kept, "{listed} of {kept}");
    }
}

#[test]
fn finer_rays_are_traced_where_those_of_the_map_are_too_few() {
    // A map of a dozen rays across the ball; and a neck, whose rays cross.
    for (name, settings) in [("sphere_room?surface=analytic&tess=24", "downsampling = 8"), ("vase?tess=32", "")] {
        let scene = scene(name);
        let (picture, trips) = measured(ID, &scene, settings, 1, 1);
        let (_, coarse) = measured(ID, &scene, &format!("finest_ray_px = 1000\n{settings}"), 1, 1);
        let [fine, coarse] = [&trips, &coarse].map(|trips| trips.all.p99.expect("some are found"));
        assert!(fine <= 0.09 && fine < 0.1 * coarse, "{name}: {fine} px, {coarse} px without finer rays");
        assert!(trips.all.missing <= 1e-3 && picture.over_0_1 <= 0.012, "{name}: {trips:?}, {picture:?}");
    }
}

/// Reflections beside the end of a mirror in another one move as the root of the distance.
#[test]
fn second_and_third_reflections_are_found_up_to_their_silhouettes() {
    for (spec, missing) in [("two_spheres?surface=analytic&tess=16", 0.0), ("two_spheres?tess=48", 3e-3)] {
        let scene = scene(spec);
        let view = scene.default_view(240, 160);
        let found = round_trips_in(ID, &scene, "work = 1000", &view, RoundTripOptions { order: 3, every: 1 });
        for (order, least) in [(2, 400), (3, 10)] {
            let of_order = &found.orders[order - 1];
            assert!(of_order.count > least && of_order.missing <= missing, "{spec}, order {order}: {of_order:?}");
            assert!(of_order.p99.is_some_and(|p99| p99 <= 0.15), "{spec}, order {order}: {of_order:?}");
        }
    }
}

#[test]
fn polished_appearances_are_exact() {
    for (name, order) in [("ellipsoid?tess=24", 1), ("two_spheres?surface=analytic&tess=16", 2)] {
        let scene = scene(name);
        let (_, trips) = measured(ID, &scene, "polish = 8", order, 1);
        assert!(trips.all.p99.expect("some are found") <= 0.01 && trips.all.missing <= 1e-3, "{name}: {trips:?}");
    }
}

#[test]
fn named_and_small_reflectors_show_environment_maps_and_are_counted() {
    let scene = scene("two_spheres?tess=16");
    let view = scene.default_view(160, 120);
    let quality = Quality { samples: 1, order: 2 };
    let hybrid = |settings: &str| {
        let drawn = draw(ID, settings, &scene, &view, quality);
        let mapped = drawn.report.fallbacks.get("environment_mapped_reflectors").copied();
        (mapped, drawn.report.counts["paths"], drawn.picture.pixels)
    };
    let name = &scene.objects[scene.specular_objects()[0] as usize].name;
    let (none, all_paths, plain) = hybrid("");
    let (one, fewer_paths, some_mapped) = hybrid(&format!("environment = '{name}'"));
    assert_eq!((none, one), (None, Some(1)));
    assert!(fewer_paths < all_paths && plain != some_mapped, "{fewer_paths} of {all_paths} paths");
    let (both, no_paths, mapped) = hybrid("environment_below_px = 100000\nenvironment_size = 64");
    assert_eq!((both, no_paths), (Some(2), 0));
    // Environment maps alone give the picture of that method.
    let target = picture("environment_map", "size = 64", &scene, &view, quality);
    let differs = |(a, b): &(&[f32; 4], &[f32; 4])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-3);
    let different = mapped.iter().zip(&target.pixels).filter(differs).count();
    assert!(different <= 20, "{different} pixels");
    let refused = session(ID, "environment = 'nobody'", &scene, quality).draw(&view);
    let error = refused.err().expect("nobody has that name").to_string();
    assert!(error.contains("nobody") && error.contains(name.as_str()), "{error}");
}

#[test]
fn presets_are_where_settings_start_from() {
    let read = |text: &str| SampleBasedCameraSettings::from_table(&toml::from_str(text).expect("valid"));
    assert_eq!(read("").expect("allowed"), SampleBasedCameraSettings::default());
    let fast = read("preset = 'fast'\naccuracy_px = 0.5").expect("allowed");
    assert_eq!((fast.downsampling, fast.accuracy_px), (4, 0.5));
    for wrong in ["preset = 'slow'", "accuracy_px = 0", "environment = '['", "polish = 1000", "unknown = 1"] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
}
