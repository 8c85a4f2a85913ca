//! Errors of projections, measured by round trips.

use catoptric_core::progress::Silent;
use catoptric_engine::method::Quality;
use catoptric_engine::method::projector::{PathBeginnings, Projection, Projections, SpecularPath, VertexProjector};
use catoptric_projection::measure::round_trip::{
    RoundTrip, RoundTripError, RoundTripOptions, round_trip, round_trip_without,
};
use catoptric_projection::parts::Answers;
use catoptric_projection::planar_mirror;
use catoptric_scenes::builtin;
use glam::{Vec2, Vec3};
use std::sync::Arc;

fn measured(spec: &str, order: u32, every: u32) -> RoundTrip {
    let scene = Arc::new(builtin::parse(spec).expect("a built-in scene").pose(&Default::default()).expect("a scene"));
    let view = scene.default_view(160, 120);
    let method = (planar_mirror::INFO.create)(&Default::default()).expect("default settings");
    let mut prepared = method.prepare(&scene, Quality { samples: 1, order }, None, &Silent).expect("made ready");
    let frame = prepared.frame(&view, &Silent).expect("a frame");
    let projector = frame.projector().expect("the method projects");
    round_trip(&scene, &view, projector.as_ref(), RoundTripOptions { order, every }, &Silent)
        .expect("nothing is cancelled")
}

#[test]
fn flat_mirrors_bring_every_pixel_back_to_where_it_came_from() {
    let found = measured("planar_mirror?mirrors=3", 3, 1);
    assert!(found.all.count > 5000 && found.orders.len() == 3 && found.orders[1].count > 100, "{found:?}");
    assert_eq!(found.all.count, found.orders.iter().map(|order| order.count).sum::<u64>());
    assert!(found.all.p99.unwrap() < 5e-3 && found.all.max.unwrap() < 0.05, "{found:?}");
    assert!(found.all.missing < 1e-3, "{found:?}");
    assert!(found.all.answers >= found.all.count && found.all.invented == 0.0 && found.all.doubled == 0.0, "{found:?}");
}

/// Answers every question with the truth, once more, and with a place far from it.
struct Liar<'a>(Box<dyn VertexProjector + 'a>);

impl VertexProjector for Liar<'_> {
    fn paths(&self) -> &[SpecularPath] {
        self.0.paths()
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        let mut true_ones = Projections::default();
        self.0.project_on(path, points, &mut true_ones);
        found.extend(points, |point, answers| {
            let index = points.iter().position(|other| *other == point).expect("one of them");
            for one in true_ones.of(index) {
                let far = one.image_px + Vec2::new(0.0, if one.image_px.y < 60.0 { 15.0 } else { -15.0 });
                answers.extend([*one, *one, Projection { image_px: far, ..*one }]);
            }
        });
    }
}

#[test]
fn answers_that_are_invented_or_given_twice_are_counted() {
    let scene = Arc::new(builtin::parse("planar_mirror").unwrap().pose(&Default::default()).unwrap());
    let view = scene.default_view(160, 120);
    let method = (planar_mirror::INFO.create)(&Default::default()).unwrap();
    let mut prepared = method.prepare(&scene, Quality { samples: 1, order: 1 }, None, &Silent).unwrap();
    let frame = prepared.frame(&view, &Silent).unwrap();
    let liar = Liar(frame.projector().unwrap());
    let found = round_trip(&scene, &view, &liar, RoundTripOptions { order: 1, every: 3 }, &Silent).unwrap().all;
    // A part of the far ones is beside the mirrors.
    assert!((0.28..0.334).contains(&found.invented) && (0.333..0.36).contains(&found.doubled), "{found:?}");
    assert!(found.missing < 1e-3 && found.p99.unwrap() < 5e-3, "{found:?}");
}

#[test]
fn paths_that_a_method_cannot_project_are_missing() {
    let found = measured("sphere_room", 2, 5);
    assert!(found.all.count > 10 && found.all.missing == 1.0 && found.all.p50.is_none(), "{found:?}");
    let nothing = measured("planar_mirror", 0, 5);
    assert_eq!(nothing, RoundTrip::default());
}

/// Paths that go on from a mirror belong to it at any order: each of two mirrors has those that the other one has not.
#[test]
fn paths_that_are_left_to_others_are_not_asked_for() {
    let scene = Arc::new(builtin::parse("planar_mirror?mirrors=2").unwrap().pose(&Default::default()).unwrap());
    let view = scene.default_view(160, 120);
    let method = (planar_mirror::INFO.create)(&Default::default()).unwrap();
    let mut prepared = method.prepare(&scene, Quality { samples: 1, order: 2 }, None, &Silent).unwrap();
    let frame = prepared.frame(&view, &Silent).unwrap();
    let projector = frame.projector().unwrap();
    let mirrors = scene.specular_objects();
    let counts = |left: &[u32]| {
        let mut paths = PathBeginnings::default();
        paths.extend(left.iter().map(|object| (Vec::new(), *object)));
        let options = RoundTripOptions { order: 2, every: 2 };
        let found = round_trip_without(&scene, &view, (projector.as_ref(), &paths), options, &Silent).unwrap();
        [found.orders[0].count, found.orders[1].count]
    };
    let ([all, one, other], none) = ([&[][..], &mirrors[..1], &mirrors[1..]].map(counts), counts(&mirrors));
    assert_eq!((mirrors.len(), none), (2, [0, 0]));
    assert!(one[0] > 100 && other[0] > 100 && all[1] > 100, "{all:?} {one:?} {other:?}");
    assert_eq!(all, [one[0] + other[0], one[1] + other[1]]);
}

#[test]
fn percentiles_are_values_that_were_measured() {
    let of = |errors: Vec<f32>| RoundTripError::of(Answers { errors, ..Answers::default() });
    let error = of((1..=200).rev().map(|value| value as f32).collect());
    assert_eq!((error.p50, error.p95), (Some(100.0), Some(190.0)));
    assert_eq!((error.p99, error.max, error.missing, error.count), (Some(198.0), Some(200.0), 0.0, 200));
    let half = of(vec![f32::INFINITY, 2.0]);
    assert_eq!((half.p50, half.missing), (Some(2.0), 0.5));
}
