//! Explosion maps against the reference, by pictures and by round trips; their errors against sizes and tessellations;
//! how what they show moves.

use catoptric::methods::projection::{Projection, RoundTrip, RoundTripOptions, round_trip};
use catoptric::methods::{Job, Quality};
use catoptric::metrics::PictureError;
use catoptric::progress::Silent;
use catoptric::scene::{Material, Scene};
use catoptric_testkit::drawing::{measured, prepared, scene, survives, survives_with};
use catoptric_testkit::scenes::{SceneBuilder, sphere_in_room};
use glam::{Quat, Vec3};

fn check(what: &str, (picture, trips): &(PictureError, RoundTrip), p99: f64, missing: f64, over_0_1: f64) {
    assert!(trips.all.count > 300, "{what}: {trips:?}");
    assert!(trips.all.p99.is_some_and(|found| found <= p99), "{what}: {trips:?}");
    assert!(trips.all.missing <= missing, "{what}: {trips:?}");
    assert!(picture.over_0_1 <= over_0_1, "{what}: {picture:?}");
}

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

/// The round trips of some pixels at 640 x 480.
fn trips(scene: &Scene, settings: &str) -> RoundTrip {
    let view = scene.default_view(640, 480);
    let quality = Quality { samples: 1, order: 1 };
    let mut method = prepared("explosion_map", settings, scene, quality);
    let job = Job { scene, view: &view, quality, progress: &Silent };
    let projector = method.projector(&job).expect("it was prepared").expect("it projects");
    round_trip(scene, &view, projector.as_ref(), RoundTripOptions { order: 1, every: 6 }, &Silent)
}

fn median_px(scene: &Scene, settings: &str) -> f64 {
    trips(scene, settings).all.p50.expect("something is seen")
}

/// The goal of the method on convex reflectors.
#[test]
fn two_steps_of_polish_make_every_kind_of_start_exact() {
    // At the size of the goal.
    for spec in ["sphere_room?tess=48", "sphere_room?surface=analytic", "ellipsoid", "two_spheres?tess=48"] {
        for preset in ["balanced", "fast", "faithful"] {
            let settings = format!("preset = '{preset}'\npolish = 2");
            let trips = trips(&scene(spec), &settings);
            assert!(trips.all.p99.is_some_and(|p99| p99 <= 0.1), "{spec}, {preset}: {trips:?}");
            // From two spheres alone the start may be so far off that the solver gets nowhere.
            let missing = if preset == "faithful" { 5e-3 } else { 1e-3 };
            assert!(trips.all.missing <= missing, "{spec}, {preset}: {trips:?}");
        }
    }
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

/// The picture of a point moves as its own change says, frame by frame: nothing jumps, neither from cell to cell nor
/// where the map ends.
#[test]
fn reflections_of_moving_things_glide() {
    let scene = sphere_in_room(true);
    let center = Vec3::new(0.0, 1.0, -0.5);
    let view = scene.default_view(640, 480);
    let quality = Quality { samples: 1, order: 1 };
    for (settings, bound_px) in [("", 0.25), ("preset = 'fast'", 1.5)] {
        let mut method = prepared("explosion_map", settings, &scene, quality);
        let job = Job { scene: &scene, view: &view, quality, progress: &Silent };
        let projector = method.projector(&job).expect("it was prepared").expect("it projects");
        let mut compared = 0;
        for start in [Vec3::new(1.2, 0.1, 0.3), Vec3::new(0.3, 0.9, -1.0), Vec3::new(-1.0, -0.4, -0.9)] {
            let mut before = None;
            for frame in 0..60 {
                // All the way around, behind the ball as well.
                let turn = Quat::from_rotation_y(frame as f32 * std::f32::consts::TAU / 60.0);
                let point = center + turn * start;
                let mut found = Vec::new();
                projector.project_on(0, point, &mut found);
                assert!(found.len() <= 1, "a convex mirror shows a point once: {found:?}");
                if let (Some((old_point, old)), Some(new)) = (before, found.first()) {
                    // Half-way between what both ends predict: exact to second order.
                    let old: Projection = old;
                    let step = point - old_point;
                    let ahead = old.predicted(step) - old.image_px;
                    let back = new.image_px - new.predicted(-step);
                    let expected = old.image_px + (ahead + back) * 0.5;
                    let miss = expected.distance(new.image_px);
                    // Above the tangent planes of both feet it is a reflection; elsewhere it is seen beside the ball, and
                    // turns where it gets there.
                    let above = |point: Vec3, one: &Projection| {
                        (point - one.reflection_point).dot((one.reflection_point - center).normalize()) > 0.0
                    };
                    let seen = above(point, new) && above(old_point, &old);
                    let most = if seen { 0.1 * ahead.length() } else { ahead.length().max(back.length()) };
                    assert!(miss <= bound_px + most, "{settings} frame {frame}: {miss} px, {ahead}, {back}");
                    compared += 1;
                }
                before = found.first().map(|one| (point, *one));
            }
        }
        assert!(compared > 90, "{compared}");
    }
}

#[test]
fn eyes_within_reflectors_and_on_them_are_survived() {
    let scene = sphere_in_room(true);
    let center = Vec3::new(0.0, 1.0, -0.5);
    let eyes = [
        (center, Vec3::Z * 3.0),
        (center + Vec3::Z * 0.5, center),
        (center + Vec3::Z * 0.7, Vec3::Z * 3.0),
        (center + Vec3::Z * 0.700_01, center),
    ];
    // The last eye is so near that it sees a part of one triangle: finer pieces would only take longer.
    survives_with("explosion_map", "edge_error_px = 4.0\npiece_px = 8.0", &scene, &eyes, 2);
}

#[test]
fn things_without_size_are_survived() {
    let mut builder = SceneBuilder::new();
    let grey = builder.flat("grey", Vec3::splat(0.5));
    builder.cuboid("room", Vec3::splat(-3.0), Vec3::splat(3.0), true, grey);
    builder.quad("point", Vec3::new(0.5, 0.5, 0.5), Vec3::ZERO, Vec3::ZERO, grey);
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.sphere("ball", Vec3::ZERO, 0.3, mirror);
    builder.sphere("speck", Vec3::new(0.7, 0.0, 0.0), 1e-6, mirror);
    builder.quad("mirror point", Vec3::new(0.0, 0.8, 0.0), Vec3::ZERO, Vec3::ZERO, mirror);
    builder.quad("mirror line", Vec3::new(0.0, -0.8, 0.0), Vec3::X, Vec3::X, mirror);
    let eye = Vec3::new(0.0, 0.5, 2.0);
    survives("explosion_map", &builder.build(), &[(eye, Vec3::ZERO), (eye, Vec3::new(0.7, 0.0, 0.0))], 2);
    survives("explosion_map", &SceneBuilder::new().build(), &[(Vec3::Z, Vec3::ZERO)], 2);
}
