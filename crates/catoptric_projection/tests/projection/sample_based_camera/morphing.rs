//! Reflection morphing: appearances blended from nodes against the reference, and its changes as the eye moves.

use catoptric::methods::Quality;
use catoptric::methods::projection::measure::round_trip::{RoundTrip, RoundTripOptions};
use catoptric::methods::projector::{Projection, Projections};
use catoptric::scene::{Camera, Scene, View};
use catoptric_testkit::drawing::{draw, picture, points_in, reflector_error, round_trips_in, scene, session};
use glam::Vec3;

const ID: &str = "sample_based_camera";

/// Coarse cameras at the nodes: they are where the solver starts.
const MORPH: &str = "mode = 'morph'\nnode_size = 128\nwork = 1000";

/// A small picture by the scene's camera from elsewhere.
fn view_from(scene: &Scene, eye: Vec3) -> View {
    let target = scene.objects[scene.specular_objects()[0] as usize].bounds.center();
    scene.view(&Camera::look_at("", eye, target, Vec3::Y, 50.0), 120, 90)
}

/// Round trips of every pixel.
fn trips(scene: &Scene, settings: &str, order: u32) -> RoundTrip {
    let options = RoundTripOptions { order, every: 1 };
    round_trips_in(ID, scene, &format!("{MORPH}\n{settings}"), &scene.default_view(120, 90), options)
}

#[test]
fn blended_appearances_are_near_the_true_ones() {
    // The paper states 5 pixels of a picture six times as wide; a tenth of a pixel is wanted after two steps.
    for (name, settings, order, p99) in [
        ("sphere_room?surface=analytic&tess=16", "", 1, 0.05),
        ("sphere_room?surface=analytic&tess=16", "polish = 2", 1, 0.005),
        ("sphere_room?tess=32", "", 1, 0.1),
        ("ellipsoid?tess=24", "", 1, 0.2),
        ("two_spheres?surface=analytic&tess=16", "", 2, 0.5),
        ("two_spheres?surface=analytic&tess=16", "polish = 2", 2, 0.1),
    ] {
        let found = trips(&scene(name), settings, order);
        assert!(found.all.count > 300 && found.all.missing <= 4e-3, "{name} {settings}: {found:?}");
        assert!(found.all.p99.is_some_and(|found| found <= p99), "{name} {settings}: {found:?}");
    }
}

#[test]
fn pictures_are_those_of_the_reference() {
    for (name, over) in [("sphere_room?tess=32", 0.03), ("two_spheres?tess=16", 0.03), ("dish?tess=24", 0.01)] {
        let scene = scene(name);
        let (view, quality) = (scene.default_view(160, 120), Quality { samples: 4, order: 2 });
        let drawn = draw(ID, MORPH, &scene, &view, quality);
        let error = reflector_error(&drawn.picture, &picture("reference", "", &scene, &view, quality), &scene, &view);
        assert!(error.over_0_1 <= over, "{name}: {error:?}, {:?}", drawn.report);
    }
}

/// Objects with environment maps look the same as without nodes, and paths end there at the nodes, too.
#[test]
fn environment_maps_are_shown_beside_nodes() {
    let scene = scene("two_spheres?tess=16");
    let (view, quality) = (scene.default_view(160, 120), Quality { samples: 4, order: 2 });
    let names = scene.specular_objects().into_iter().map(|object| scene.objects[object as usize].name.as_str());
    let [first, second] = names.collect::<Vec<_>>()[..] else { panic!("there are two spheres") };
    for (environment, mapped) in [(first.to_owned(), 1), (format!("{first},{second}"), 2)] {
        let settings = format!("environment = '{environment}'\nenvironment_size = 64");
        let blended = draw(ID, &format!("{MORPH}\n{settings}"), &scene, &view, quality);
        let at_runtime = draw(ID, &settings, &scene, &view, quality);
        for drawn in [&blended, &at_runtime] {
            assert_eq!(drawn.report.fallbacks["environment_mapped_reflectors"], mapped, "{:?}", drawn.report);
        }
        assert_eq!(blended.report.counts["nodes_blended"], 4 * (2 - mapped), "{:?}", blended.report);
        let error = reflector_error(&blended.picture, &at_runtime.picture, &scene, &view);
        assert!(error.over_0_1 <= if mapped == 2 { 0.0 } else { 0.02 }, "{environment}: {error:?}");
    }
}

#[test]
fn beyond_the_grid_and_within_a_reflectors_box_tiles_draw() {
    let scene = scene("sphere_room?tess=16");
    let quality = Quality { samples: 4, order: 1 };
    let ball = scene.objects[scene.specular_objects()[0] as usize].bounds;
    // This corner of the ball's box lies outside the ball.
    let corner = ball.center() + ball.size() * 0.48;
    for (eye, settings) in [(scene.default_view(8, 6).eye(), "grid_reach = 0.1"), (corner, "")] {
        let view = view_from(&scene, eye);
        let drawn = draw(ID, &format!("{MORPH}\n{settings}"), &scene, &view, quality);
        assert_eq!(drawn.report.fallbacks["reflectors_without_nodes"], 1, "{:?}", drawn.report);
        let error = reflector_error(&drawn.picture, &picture("reference", "", &scene, &view, quality), &scene, &view);
        assert!(error.over_0_1 <= 0.02, "{error:?}");
    }
}

/// The appearances of points, each with the number of its point.
fn appearances(scene: &Scene, eye: Vec3, points: &[Vec3]) -> Vec<(usize, Projection)> {
    let view = view_from(scene, eye);
    let mut session = session(ID, MORPH, scene, Quality { samples: 1, order: 1 });
    let found = session.with_projector(&view, |projector| {
        let mut found = Projections::default();
        projector.project(points, &mut found);
        found
    });
    let found = found.expect("the input is valid");
    (0..points.len()).flat_map(|point| found.of(point).iter().map(move |one| (point, *one))).collect()
}

#[test]
fn nothing_jumps_where_the_eye_passes_from_one_tetrahedron_to_the_next() {
    let scene = scene("sphere_room?surface=analytic&tess=8");
    let points = points_in(&scene, 300);
    // Through the middle of the ball's grid, where cells meet and, from there, in several tetrahedra.
    let ball = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let spacing = ball.diagonal() * 5.0 / 16.0;
    let border = ball.center() + Vec3::new(0.0, 0.5, 3.0) * spacing;
    for (eye, step) in [(border, Vec3::X), (border + Vec3::new(0.3, 0.0, 0.3) * spacing, Vec3::new(1.0, 0.0, -1.0))] {
        let [before, after] = [-1e-5, 1e-5].map(|side: f32| appearances(&scene, eye + step * side, &points));
        let mut compared = 0;
        for (point, one) in &before {
            let same = |(other, _): &&(usize, Projection)| other == point;
            let distances = after.iter().filter(same).map(|(_, other)| other.image_px.distance(one.image_px));
            if let Some(nearest) = distances.min_by(f32::total_cmp) {
                assert!(nearest < 0.05, "{nearest} px at {}", points[*point]);
                compared += 1;
            }
        }
        // A point or two may come or go at the horizon.
        assert!(compared > 100 && before.len() - compared <= 2, "{compared} of {}", before.len());
    }
}

#[test]
fn nodes_are_built_once() {
    let scene = scene("sphere_room?tess=8");
    let mut session = session(ID, MORPH, &scene, Quality { samples: 1, order: 1 });
    let eye = scene.default_view(8, 6).eye();
    let mut built = |eye: Vec3| {
        let report = session.draw(&view_from(&scene, eye)).expect("the input is valid").report;
        (report.counts["nodes_built"], report.counts["nodes_blended"])
    };
    let (first, blended) = built(eye);
    assert!(first == blended && (1..=4).contains(&first), "{first} of {blended}");
    assert_eq!(built(eye + Vec3::X * 1e-3).0, 0);
    // A cell away three at the most are shared.
    let (moved, _) = built(eye + Vec3::X * 0.9);
    assert!((1..=4).contains(&moved), "{moved}");
    assert_eq!(built(eye).0, 0, "they were forgotten");
}

#[test]
fn settings_that_do_not_go_together_are_refused() {
    use catoptric::methods::Settings;
    use catoptric::methods::projection::sample_based_camera::SampleBasedCameraSettings;
    let read = |text: &str| SampleBasedCameraSettings::from_table(&toml::from_str(text).expect("valid"));
    for wrong in [
        "grid = '17'",
        "grid = '1x1x1'",
        "node_size = 4096\ndownsampling = 1",
        "beyond_work = 'coarse'",
        "mode = 'walk'",
    ] {
        let given = if wrong.starts_with("mode") { wrong.into() } else { format!("mode = 'morph'\n{wrong}") };
        assert!(read(&given).is_err(), "{wrong}");
    }
    assert!(read("mode = 'morph'\ngrid = '5x5x3'").is_ok());
}
