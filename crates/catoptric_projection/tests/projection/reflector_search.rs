//! The search in pictures of reflectors against the reference, by pictures and by round trips; its errors against
//! sizes.

use catoptric_testkit::drawing::{assert_measured as check, measured, round_trips, scene};

#[test]
fn a_ball_of_triangles_in_a_room_equals_the_reference() {
    let scene = scene("sphere_room?tess=48");
    for images in ["eye", "cube"] {
        let found = measured("reflector_search", &scene, &format!("images = '{images}'"), 1, 1);
        check(images, &found, 0.02, 2e-3, 0.05);
    }
}

#[test]
fn balls_in_balls_are_found_by_recursion() {
    let found = measured("reflector_search", &scene("two_spheres?tess=48"), "", 2, 1);
    check("two_spheres", &found, 0.02, 2e-3, 0.05);
    assert!(found.1.orders[1].count > 10 && found.1.orders[1].max.is_some_and(|max| max < 0.05), "{found:?}");
}

#[test]
fn a_hollow_mirror_shows_things_on_both_sides_of_its_focus() {
    let found = measured("reflector_search", &scene("dish?surface=mesh"), "", 1, 1);
    check("dish", &found, 0.05, 5e-3, 0.05);
}

#[test]
fn a_lens_refracts_through_both_faces() {
    let found = measured("reflector_search", &scene("lens?distance=0.8"), "", 2, 1);
    let through = found.1.orders[1];
    // A texel or two are missing along the rim, where the picture of the back has a crease.
    assert!(through.count > 500 && through.missing < 0.06, "{found:?}");
    assert!(through.p50.is_some_and(|p50| p50 < 0.002) && through.p99.is_some_and(|p99| p99 < 0.3), "{found:?}");
    assert!(through.invented < 1e-3 && through.doubled < 1e-3, "{found:?}");
}

/// A flat mirror is edge-on for an eye at its centre.
#[test]
fn flat_mirrors_have_cube_maps_too() {
    let found = measured("reflector_search", &scene("planar_mirror"), "images = 'cube'", 2, 2);
    check("planar_mirror", &found, 0.05, 0.05, 0.1);
    assert!(found.1.orders[1].count > 50 && found.1.orders[1].missing < 0.1, "{found:?}");
}

#[test]
fn faces_of_a_slab_are_distinguished() {
    let found = measured("reflector_search", &scene("glass_slab"), "", 2, 2);
    // Most of the pixels that are off lie at the bottom face, which touches the feet: they are seen there, too.
    check("glass_slab", &found, 0.05, 2e-2, 0.052);
    assert!(found.1.orders[1].count > 100, "{found:?}");
}

#[test]
#[ignore = "slow: cargo xtask check-all --only slow"]
fn errors_fall_with_larger_pictures() {
    // The mesh is finer than the texels: the rest of the error is theirs.
    let fine = scene("sphere_room?tess=160");
    for images in ["eye", "cube"] {
        let p99 = |size: u32| {
            let settings = format!("images = '{images}'\nmap_size = {size}");
            round_trips("reflector_search", &fine, &settings, 6).all.p99.expect("something is seen")
        };
        let found = [200, 400, 800].map(p99);
        assert!(found[1] < 0.7 * found[0] && found[2] < 0.7 * found[1], "{images}: {found:?}");
    }
}
