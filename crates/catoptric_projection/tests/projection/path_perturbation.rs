//! Path perturbation against the reference, by pictures and by round trips, and where there is little to draw.

use catoptric::methods::Quality;
use catoptric::methods::projection::measure::round_trip::{RoundTrip, RoundTripOptions};
use catoptric::methods::projector::Projections;
use catoptric::metrics::{Comparison, PictureError};
use catoptric_testkit::drawing::{measured, picture, round_trips_in, scene, with_projector};
use catoptric_testkit::scenes::{SceneBuilder, sphere_in_room};
use glam::Vec3;

/// Polished paths are exact but for the rounding of the traced points: 0.0004 pixels, and none is missing. Pictures are
/// off where an edge of colours lies within the edge error (0.25 pixels) of a pixel's centre.
fn check(what: &str, (picture, trips): &(PictureError, RoundTrip), over_0_1: f64) {
    assert!(trips.all.count > 300, "{what}: {trips:?}");
    assert!(trips.all.p99.is_some_and(|p99| p99 <= 4e-4) && trips.all.missing == 0.0, "{what}: {trips:?}");
    assert!(picture.over_0_1 <= over_0_1, "{what}: {picture:?}");
}

#[test]
fn a_ball_in_a_room_equals_the_reference() {
    let scene = scene("sphere_room?surface=analytic&tess=24");
    let found = measured("path_perturbation", &scene, "", 1, 1);
    check("sphere_room", &found, 0.014);
}

#[test]
fn the_vase_equals_the_reference() {
    let scene = scene("vase?tess=8");
    // 80 x 60 samples, as the method is judged at 640 x 480.
    let settings = "spacing_px = 1.5\nfinest_px = 0.375";
    check("vase", &measured("path_perturbation", &scene, settings, 1, 1), 0.01);
}

#[test]
fn without_polish_second_order_is_nearer_than_first_and_first_than_none() {
    let scene = scene("sphere_room?surface=analytic&tess=8");
    let view = scene.default_view(120, 90);
    let medians = ["nearest", "linear", "quadratic"].map(|expansion| {
        let settings = format!("polish = 0\nexpansion = '{expansion}'");
        let options = RoundTripOptions { order: 1, every: 3 };
        let trips = round_trips_in("path_perturbation", &scene, &settings, &view, options);
        trips.all.p50.expect("something is seen")
    });
    // Samples two pixels apart where the ball is, and each order gains.
    assert!(medians[0] < 1.0 && medians[1] < 0.04 * medians[0] && medians[2] < 0.15 * medians[1], "{medians:?}");
}

#[test]
fn without_reflectors_and_at_order_zero_pictures_are_those_of_the_reference() {
    let mut builder = SceneBuilder::new();
    let checker = builder.checker("checker", 4, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::splat(-3.0), Vec3::splat(3.0), true, checker);
    builder.camera(Vec3::new(0.0, 0.5, 2.0), Vec3::ZERO, 50.0);
    let bare = builder.build();
    for (scene, order) in [(&bare, 2), (&bare, 0), (&sphere_in_room(true), 0)] {
        let view = scene.default_view(48, 36);
        let quality = Quality { samples: 1, order };
        let [picture, truth] = ["path_perturbation", "reference"].map(|id| picture(id, "", scene, &view, quality));
        let comparison = Comparison::new(&picture, &truth).expect("the test's input is valid");
        let error = comparison.whole().expect("there are pixels");
        assert!(error.over_0_1 == 0.0 && error.flip_mean < 6e-5, "{error:?}");
    }
}

/// The terms that the automatic order leaves out are negligible: 0.02 pixels; on flat mirrors these are often all of
/// second order.
#[test]
fn the_automatic_order_is_as_near_as_the_second() {
    for (spec, least_share) in [("sphere_room?surface=analytic&tess=24", 0.0), ("planar_mirror", 0.4)] {
        let scene = scene(spec);
        let view = scene.default_view(640, 480);
        let quality = Quality { samples: 1, order: 1 };
        let [auto, linear, quadratic] = ["auto", "linear", "quadratic"].map(|order| {
            let settings = format!("polish = 0\nexpansion = '{order}'");
            with_projector("path_perturbation", &settings, &scene, &view, quality, |projector| {
                let mut found = Projections::default();
                projector.project(&scene.positions, &mut found);
                found
            })
        });
        let (mut compared, mut unequal, mut first_order, mut worst_px) = (0, 0, 0, 0.0f32);
        for number in 0..scene.positions.len() {
            let ([one], [other]) = (auto.of(number), quadratic.of(number)) else {
                // At the end of a reflector small differences decide.
                unequal += u32::from(auto.of(number).len() != quadratic.of(number).len());
                continue;
            };
            worst_px = worst_px.max(one.image_px.distance(other.image_px));
            first_order += u32::from(linear.of(number).iter().any(|linear| linear.image_px == one.image_px));
            compared += 1;
        }
        assert!(compared > 300 && worst_px < 0.02, "{spec}: {worst_px} of {compared}");
        assert!(unequal * 10_000 < compared, "{spec}: {unequal} of {compared}");
        assert!(f64::from(first_order) > least_share * f64::from(compared), "{spec}: {first_order} of {compared}");
    }
}
