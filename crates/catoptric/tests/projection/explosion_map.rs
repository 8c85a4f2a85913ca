//! Explosion maps against the reference, by pictures and by round trips; their errors against sizes and tessellations.

use catoptric::scene::Scene;
use catoptric_testkit::drawing::{assert_measured as check, measured, round_trips, scene};

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
    assert!(through.count > 500 && through.missing < 0.05, "{found:?}");
    assert!(through.p50.is_some_and(|p50| p50 < 0.01), "{found:?}");
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
    assert!(through.count > 100 && through.missing < 0.12, "{through:?}");
    assert!(through.p50.is_some_and(|p50| p50 < 0.2) && through.p99.is_some_and(|p99| p99 < 1.0), "{through:?}");
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
    // With the square of the edges.
    assert!(triangles[1] < 0.35 * triangles[0] && triangles[2] < 0.35 * triangles[1], "{triangles:?}");
}
