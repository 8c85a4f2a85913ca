//! Methods prepared, asked and compared with the reference.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::projection::{RoundTrip, RoundTripOptions, round_trip};
use catoptric::methods::reference::specular_mask;
use catoptric::methods::{self, Job, Quality, ReflectionMethod};
use catoptric::metrics::{Comparison, PictureError};
use catoptric::progress::Silent;
use catoptric::scene::{Camera, Scene, View, builtin};
use glam::Vec3;

/// A built-in scene.
pub fn scene(spec: &str) -> Scene {
    let model = builtin::parse(spec).expect("the test's input is valid");
    model.pose(&Default::default()).expect("the test's input is valid")
}

/// A method with these settings, prepared for a scene.
pub fn prepared(id: &str, settings: &str, scene: &Scene, quality: Quality) -> Box<dyn ReflectionMethod> {
    let settings = toml::from_str(settings).expect("the test's input is valid");
    let mut method = methods::create(id, &settings).expect("the test's input is valid");
    method.prepare(scene, quality, &Silent).expect("the test's input is valid");
    method
}

/// Its picture, all of whose values are numbers.
pub fn drawn(method: &mut dyn ReflectionMethod, scene: &Scene, view: &View, quality: Quality) -> Framebuffer {
    let mut target = Framebuffer::new(view.width, view.height);
    let job = Job { scene, view, quality, progress: &Silent };
    method.render(&job, &mut target).expect("the test's input is valid");
    assert!(target.pixels.iter().flatten().all(|value| value.is_finite()));
    target
}

/// The error of a method's small picture over reflector pixels, and the round trips of every `every`-th pixel.
pub fn measured(id: &str, scene: &Scene, settings: &str, order: u32, every: u32) -> (PictureError, RoundTrip) {
    let view = scene.default_view(120, 90);
    let quality = Quality { samples: 1, order };
    let mut method = prepared(id, settings, scene, quality);
    let picture = drawn(method.as_mut(), scene, &view, quality);
    let truth = drawn(prepared("reference", "", scene, quality).as_mut(), scene, &view, quality);
    let comparison = Comparison::new(&picture, &truth).expect("the test's input is valid");
    let mask = specular_mask(scene, &view);
    let comparison = comparison.masked(&mask).expect("the test's input is valid");
    let job = Job { scene, view: &view, quality, progress: &Silent };
    let projector = method.projector(&job).expect("it was prepared").expect("it projects");
    let options = RoundTripOptions { order, every };
    (comparison.expect("the reflector is seen"), round_trip(scene, &view, projector.as_ref(), options, &Silent))
}

/// What was [`measured`] has no larger error, no larger share of round trips without an answer, and no larger share of
/// pixels that are off by more than 0.1 than this.
pub fn assert_measured(
    what: &str,
    (picture, trips): &(PictureError, RoundTrip),
    p99: f64,
    missing: f64,
    over_0_1: f64,
) {
    assert!(trips.all.count > 300, "{what}: {trips:?}");
    assert!(trips.all.p99.is_some_and(|found| found <= p99), "{what}: {trips:?}");
    assert!(trips.all.missing <= missing, "{what}: {trips:?}");
    assert!(picture.over_0_1 <= over_0_1, "{what}: {picture:?}");
}

/// The round trips of every `every`-th pixel of a picture of 640 x 480, at order 1.
pub fn round_trips(id: &str, scene: &Scene, settings: &str, every: u32) -> RoundTrip {
    let view = scene.default_view(640, 480);
    let quality = Quality { samples: 1, order: 1 };
    let mut method = prepared(id, settings, scene, quality);
    let job = Job { scene, view: &view, quality, progress: &Silent };
    let projector = method.projector(&job).expect("it was prepared").expect("it projects");
    round_trip(scene, &view, projector.as_ref(), RoundTripOptions { order: 1, every }, &Silent)
}

/// The pictures from several eyes are finite; nothing panics.
pub fn survives(id: &str, scene: &Scene, eyes: &[(Vec3, Vec3)], order: u32) {
    survives_with(id, "", scene, eyes, order);
}

/// The same with settings.
pub fn survives_with(id: &str, settings: &str, scene: &Scene, eyes: &[(Vec3, Vec3)], order: u32) {
    let quality = Quality { samples: 1, order };
    let mut method = prepared(id, settings, scene, quality);
    for (eye, target) in eyes {
        let camera = Camera::look_at("", *eye, *target, Vec3::Y, 50.0);
        let view = scene.view(&camera, 24, 18);
        drawn(method.as_mut(), scene, &view, quality);
    }
}
