//! Methods drawn, queried and compared with the reference.

use crate::session::{Drawn, Session};
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::math::random::Stream;
use catoptric::methods::Quality;
use catoptric::methods::projection::measure::round_trip::{RoundTrip, RoundTripOptions, round_trip};
use catoptric::methods::projector::VertexProjector;
use catoptric::metrics::{Comparison, PictureError};
use catoptric::progress::Silent;
use catoptric::scene::{Camera, Scene, View};
use catoptric_scenes::builtin;
use glam::Vec3;

const VALID: &str = "the test's input is valid";

/// A built-in scene.
pub fn scene(spec: &str) -> Scene {
    builtin::parse(spec).expect(VALID).pose(&Default::default()).expect(VALID)
}

/// Points anywhere in a scene's box, the same in every run.
pub fn points_in(scene: &Scene, count: usize) -> Vec<Vec3> {
    let mut random = Stream::new(3);
    let mut next = || Vec3::new(random.next_unit(), random.next_unit(), random.next_unit());
    (0..count).map(|_| scene.bounds.min + scene.bounds.size() * next()).collect()
}

/// A method with these settings (lines of TOML), ready for a scene.
pub fn session(id: &str, settings: &str, scene: &Scene, quality: Quality) -> Session {
    Session::new(id, settings, scene, quality).expect(VALID)
}

/// The message of a session that must not begin.
pub fn refusal(session: Result<Session, RenderError>) -> String {
    session.err().expect("it is refused").to_string()
}

/// A method's picture with its reports.
pub fn draw(id: &str, settings: &str, scene: &Scene, view: &View, quality: Quality) -> Drawn {
    session(id, settings, scene, quality).draw(view).expect(VALID)
}

/// A method's picture.
pub fn picture(id: &str, settings: &str, scene: &Scene, view: &View, quality: Quality) -> Framebuffer {
    draw(id, settings, scene, view, quality).picture
}

/// The result of `question` about a method's projector.
pub fn with_projector<R>(
    id: &str,
    settings: &str,
    scene: &Scene,
    view: &View,
    quality: Quality,
    question: impl FnOnce(&dyn VertexProjector) -> R,
) -> R {
    session(id, settings, scene, quality).with_projector(view, question).expect(VALID)
}

/// The error of a picture over the pixels that show reflectors and lenses.
pub fn reflector_error(picture: &Framebuffer, truth: &Framebuffer, scene: &Scene, view: &View) -> PictureError {
    let comparison = Comparison::new(picture, truth).expect(VALID);
    comparison.masked(&specular_mask(scene, view)).expect(VALID).expect("the reflector is seen")
}

/// The error of a method's picture against the reference, over the pixels that show reflectors and lenses.
pub fn error(id: &str, settings: &str, scene: &Scene, view: &View, quality: Quality) -> PictureError {
    let truth = picture("reference", "", scene, view, quality);
    reflector_error(&picture(id, settings, scene, view, quality), &truth, scene, view)
}

/// As [`error`], of a method that draws the scene without fall-backs.
pub fn error_without_fallbacks(id: &str, settings: &str, scene: &Scene, view: &View, quality: Quality) -> PictureError {
    let drawn = draw(id, settings, scene, view, quality);
    assert!(drawn.setup.fallbacks.is_empty() && drawn.report.fallbacks.is_empty(), "{:?}", drawn.report);
    reflector_error(&drawn.picture, &picture("reference", "", scene, view, quality), scene, view)
}

/// Settings with which a projection method draws all paths itself, however long that takes.
pub fn alone(settings: &str) -> String {
    format!("{settings}\nwork = 150.0\nbeyond_work = 'coarse'")
}

/// The error of a projection method's own small picture over reflector pixels, and the round trips of every `every`-th
/// pixel.
pub fn measured(id: &str, scene: &Scene, settings: &str, order: u32, every: u32) -> (PictureError, RoundTrip) {
    let view = scene.default_view(120, 90);
    let quality = Quality { samples: 1, order };
    let truth = picture("reference", "", scene, &view, quality);
    let mut session = session(id, &alone(settings), scene, quality);
    let error = reflector_error(&session.draw(&view).expect(VALID).picture, &truth, scene, &view);
    let options = RoundTripOptions { order, every };
    let trips = session.with_projector(&view, |projector| round_trip(scene, &view, projector, options, &Silent));
    (error, trips.expect(VALID).expect("nobody cancels"))
}

/// Checks that [`measured`] errors have no larger 99th percentile, no larger share of missing round trips, no larger
/// share of pixels that are off by more than 0.1 than this.
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
    let options = RoundTripOptions { order: 1, every };
    round_trips_in(id, scene, settings, &scene.default_view(640, 480), options)
}

/// The round trips of pixels of a view.
pub fn round_trips_in(id: &str, scene: &Scene, settings: &str, view: &View, options: RoundTripOptions) -> RoundTrip {
    let quality = Quality { samples: 1, order: options.order };
    with_projector(id, settings, scene, view, quality, |projector| {
        round_trip(scene, view, projector, options, &Silent).expect("nobody cancels")
    })
}

/// The pictures from several eyes are finite; nothing panics.
pub fn survives(id: &str, settings: &str, scene: &Scene, eyes: &[(Vec3, Vec3)], order: u32) {
    let mut session = session(id, settings, scene, Quality { samples: 1, order });
    for (eye, target) in eyes {
        let camera = Camera::look_at("", *eye, *target, Vec3::Y, 50.0);
        session.draw(&scene.view(&camera, 24, 18)).expect(VALID);
    }
}
