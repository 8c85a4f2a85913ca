//! The papers' own settings: the methods draw everything themselves, and about where it is.

use catoptric::methods::Quality;
use catoptric::methods::projection::measure::round_trip::RoundTripOptions;
use catoptric_testkit::drawing::{draw, picture, reflector_error, round_trips_in, scene};
use catoptric_testkit::scenes::sphere_in_room;

/// The methods with their settings, and the greatest error of their appearances in half of the pixels of a ball in a
/// room, 120 x 90 pixels: blends of two spheres bend the room (ten pixels of 640 x 480). There are 40 x 30 samples, as
/// in the paper.
const FAITHFUL: [(&str, &str, f64); 5] = [
    ("path_perturbation", "preset = 'faithful'\nspacing_px = 3\nfinest_px = 3", 0.2),
    ("sample_based_camera", "preset = 'faithful'", 0.3),
    ("sample_based_camera", "preset = 'faithful'\nmode = 'morph'", 1.0),
    ("explosion_map", "preset = 'faithful'", 4.0),
    ("reflector_search", "preset = 'faithful'", 0.3),
];

const EVERY_THIRD: RoundTripOptions = RoundTripOptions { order: 1, every: 3 };

#[test]
fn no_tiles_are_drawn_and_appearances_are_about_where_they_are() {
    let scene = scene("sphere_room?tess=24");
    let view = scene.default_view(120, 90);
    let quality = Quality { samples: 1, order: 1 };
    let truth = picture("reference", "", &scene, &view, quality);
    for (method, settings, median_px) in FAITHFUL {
        let drawn = draw(method, settings, &scene, &view, quality);
        let counts = &drawn.report.counts;
        assert!(!counts.contains_key("tiles") && counts["paths"] == 1, "{method}, {settings}: {:?}", drawn.report);
        // Parts that are not drawn are black.
        let error = reflector_error(&drawn.picture, &truth, &scene, &view);
        assert!(error.over_0_1 < 0.7, "{method}, {settings}: {error:?}");
        let trips = round_trips_in(method, &scene, settings, &view, EVERY_THIRD).all;
        let is_near = trips.p50.is_some_and(|median| median < median_px);
        assert!(is_near && trips.missing < 0.1, "{method}, {settings}: {trips:?}");
    }
}

/// Hard cases, meshes that are not convex, several bounces, and work that runs out, are drawn coarser, but by the
/// method alone.
#[test]
fn no_tiles_are_drawn_of_what_is_hard() {
    for (name, order) in [("vase?tess=8", 1), ("two_spheres?tess=12", 2)] {
        let scene = scene(name);
        let view = scene.default_view(48, 36);
        for (method, settings, _) in FAITHFUL {
            let settings = format!("{settings}\nwork = 1");
            let drawn = draw(method, &settings, &scene, &view, Quality { samples: 1, order });
            assert!(!drawn.report.counts.contains_key("tiles"), "{name}: {method}, {settings}: {:?}", drawn.report);
        }
    }
}

/// The method's own cameras see a ball to a hundredth of a pixel; the mean of four views of it, from cells a third of
/// the ball's size away, does not, and the solved one does.
#[test]
fn the_mean_of_nodes_is_nothing_but_that() {
    let scene = sphere_in_room(true);
    let view = scene.default_view(120, 90);
    let median = |blend: &str| {
        let settings = format!("mode = 'morph'\nnode_size = 128\ngrid = '7x7x5'\nblend = '{blend}'");
        round_trips_in("sample_based_camera", &scene, &settings, &view, EVERY_THIRD).all.p50
    };
    let [solved, mean] = ["solved", "mean"].map(|blend| median(blend).expect("something is seen"));
    assert!(mean > 4.0 * solved && mean < 5.0, "{solved} {mean}");
}
