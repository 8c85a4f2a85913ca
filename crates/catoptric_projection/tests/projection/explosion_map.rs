//! Explosion maps against the reference, by pictures and by round trips; their errors against sizes and tessellations.

use catoptric::methods::Quality;
use catoptric::methods::projection::explosion_map::{ExplosionMapSettings, Preset, ReflectorMap};
use catoptric::methods::projector::Projections;
use catoptric::scene::Scene;
use catoptric_testkit::drawing::{assert_measured as check, measured, round_trips, scene, with_projector};
use glam::Vec3;

#[test]
fn a_ball_of_triangles_in_a_room_equals_the_reference() {
    let scene = scene("sphere_room?tess=48");
    check("sphere_room", &measured("explosion_map", &scene, "", 1, 1), 0.01, 1e-3, 0.04);
}

#[test]
fn formulas_are_as_near_as_their_tessellation() {
    let found = measured("explosion_map", &scene("ellipsoid"), "", 1, 1);
    check("ellipsoid", &found, 0.02, 1e-3, 0.05);
}

#[test]
fn balls_in_balls_are_found_by_recursion() {
    let scene = scene("two_spheres?tess=48");
    let found = measured("explosion_map", &scene, "", 2, 1);
    check("two_spheres", &found, 0.02, 1e-3, 0.05);
    assert!(found.1.orders[1].count > 10 && found.1.orders[1].max.is_some_and(|max| max < 0.02), "{found:?}");
}

#[test]
fn a_hollow_mirror_shows_things_on_both_sides_of_its_focus() {
    let found = measured("explosion_map", &scene("dish?surface=mesh"), "", 1, 1);
    check("dish", &found, 0.05, 2e-3, 0.05);
}

#[test]
fn a_lens_refracts_through_both_faces() {
    let found = measured("explosion_map", &scene("lens?distance=0.8"), "", 2, 1);
    let through = found.1.orders[1];
    assert!(through.count > 500 && through.missing < 1e-3 && through.invented == 0.0, "{found:?}");
    assert!(through.p50.is_some_and(|p50| p50 < 0.001) && through.p99.is_some_and(|p99| p99 < 0.4), "{found:?}");
}

/// Light that enters by one face and leaves by another, by edges on which no rays of one face arrive.
#[test]
fn faces_of_a_slab_are_distinguished() {
    let found = measured("explosion_map", &scene("glass_slab"), "", 2, 2);
    check("glass_slab", &found, 0.05, 2e-3, 0.05);
    assert!(found.1.orders[1].count > 100, "{found:?}");
}

/// Rays cross within the ball and beyond: its middle and its rim show the room in different ways.
#[test]
fn a_ball_of_glass_shows_what_is_behind_it() {
    let through = measured("explosion_map", &scene("glass_sphere"), "", 2, 2).1.orders[1];
    assert!(through.count > 100 && through.missing < 0.095 && through.invented == 0.0, "{through:?}");
    assert!(through.p50.is_some_and(|p50| p50 < 0.1) && through.p99.is_some_and(|p99| p99 < 0.5), "{through:?}");
}

#[test]
fn places_in_the_saddle_of_a_ring_are_not_confused() {
    let trips = round_trips("explosion_map", &scene("torus"), "", 6).all;
    assert!(trips.count > 1000 && trips.missing < 1e-3, "{trips:?}");
    assert!(trips.p50.is_some_and(|p50| p50 < 0.03) && trips.p99.is_some_and(|p99| p99 < 1.5), "{trips:?}");
}

fn median_px(scene: &Scene, settings: &str) -> f64 {
    round_trips("explosion_map", scene, settings, 6).all.p50.expect("something is seen")
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn errors_fall_with_larger_maps_more_spheres_and_finer_triangles() {
    let fine = scene("sphere_room?tess=160");
    let maps = [10, 20, 40].map(|size| median_px(&fine, &format!("preset = 'fast'\nspheres = 16\nmap_size = {size}")));
    assert!(maps[1] < 0.7 * maps[0] && maps[2] < 0.7 * maps[1], "{maps:?}");
    let spheres = [2, 4, 8].map(|count| median_px(&fine, &format!("preset = 'fast'\nspheres = {count}")));
    assert!(spheres[1] < 0.3 * spheres[0] && spheres[2] < 0.6 * spheres[1], "{spheres:?}");
    let triangles = [16, 32, 64].map(|tess| {
        let coarse = scene(&format!("sphere_room?tess={tess}"));
        median_px(&coarse, "virtual_vertex = 'mirrored'\nlongest_edge = 10.0")
    });
    // Errors go by the square of the edges.
    assert!(triangles[1] < 0.35 * triangles[0] && triangles[2] < 0.35 * triangles[1], "{triangles:?}");
}

/// Images in two tangent planes, blended, are nearer than the image in a blended plane (20 px here).
#[test]
fn two_spheres_blend_the_images_of_a_vertex() {
    let scene = scene("sphere_room?tess=64");
    let trips = round_trips("explosion_map", &scene, "preset = 'faithful'", 6).all;
    assert!(trips.p50.is_some_and(|p50| p50 < 16.0) && trips.p99.is_some_and(|p99| p99 < 30.0), "{trips:?}");
}

/// Points have the same images one by one and many at once, and these move as their derivatives predict.
#[test]
fn blended_images_move_as_predicted() {
    let scene = scene("sphere_room?tess=64");
    let view = scene.default_view(640, 480);
    let mut map =
        ReflectorMap::new(&scene, scene.specular_objects()[0], &ExplosionMapSettings::preset(Preset::Faithful));
    map.look(&view);
    let center = scene.objects[scene.specular_objects()[0] as usize].bounds.center();
    let point = |k: u16| {
        let turn = f32::from(k) * 0.61;
        let away = 0.7 + f32::from(k % 11) * 0.15;
        center + (view.eye() - center).normalize() * 0.6 + Vec3::new(turn.cos(), 0.3 * turn.sin(), turn.sin()) * away
    };
    let points: Vec<Vec3> = (0..400).map(point).collect();
    let step = Vec3::new(1.0, -2.0, 1.5) * 1e-3;
    let moved: Vec<Vec3> = points.iter().map(|point| *point + step).collect();
    let mut images = vec![Vec3::NAN; points.len()];
    map.virtual_vertices(&points, &mut images);
    let quality = Quality { samples: 1, order: 1 };
    with_projector("explosion_map", "preset = 'faithful'", &scene, &view, quality, |projector| {
        let [mut here, mut there] = [Projections::default(), Projections::default()];
        projector.project_on(0, &points, &mut here);
        projector.project_on(0, &moved, &mut there);
        let (mut compared, mut jumps) = (0, 0);
        for (number, image) in images.iter().enumerate() {
            let ([one], [next]) = (here.of(number), there.of(number)) else { continue };
            let seen = view.pixel_of(*image).expect("it is before the eye");
            assert!(seen.distance(one.image_px) < 0.05, "{seen}, not {}", one.image_px);
            let by = next.image_px - one.image_px;
            // Images jump from texel to texel.
            jumps += u32::from(one.predicted(step).distance(next.image_px) > 0.05 * by.length() + 0.01);
            compared += 1;
        }
        assert!(compared > 100 && 10 * jumps < compared, "{jumps} of {compared}");
    });
}
