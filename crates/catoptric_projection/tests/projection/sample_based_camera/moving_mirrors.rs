//! Nodes of reflection morphing move with their reflectors.

use catoptric::math::Aabb;
use catoptric::methods::Quality;
use catoptric::methods::projection::measure::round_trip::{RoundTripOptions, round_trip};
use catoptric::progress::Silent;
use catoptric::scene::{Scene, View};
use catoptric_testkit::Session;
use catoptric_testkit::drawing::{picture, reflector_error, scene, session as prepared};
use glam::{DAffine3, DQuat, DVec3, Vec3};

const ID: &str = "sample_based_camera";
const MORPH: &str = "mode = 'morph'\nnode_size = 128\nwork = 1000";

/// The scene with its first mirrors (in their order) moved, each about its own middle.
fn moved(still: &Scene, motions: &[(DVec3, f64)]) -> Scene {
    let mut scene = still.clone();
    for (object, (step, turn)) in still.specular_objects().into_iter().zip(motions) {
        let object = &mut scene.objects[object as usize];
        let center = object.bounds.center().as_dvec3();
        let axis = DVec3::new(0.2, 1.0, -0.1).normalize();
        let motion = DAffine3::from_translation(center + *step)
            * DAffine3::from_quat(DQuat::from_axis_angle(axis, *turn))
            * DAffine3::from_translation(-center);
        if let Some(surface) = &mut object.surface {
            surface.world_from_surface = motion * surface.world_from_surface;
        }
        for vertex in object.vertices.clone() {
            let (position, normal) = (&mut scene.positions[vertex as usize], &mut scene.normals[vertex as usize]);
            *position = motion.transform_point3(position.as_dvec3()).as_vec3();
            *normal = motion.transform_vector3(normal.as_dvec3()).as_vec3();
        }
        object.bounds = match &object.surface {
            Some(surface) => surface.bounds(),
            None => Aabb::around(object.vertices.clone().map(|vertex| scene.positions[vertex as usize])),
        };
    }
    scene
}

/// Nodes that were built for a picture.
fn built(session: &mut Session, view: &View) -> u64 {
    session.draw(view).expect("the input is valid").report.counts["nodes_built"]
}

/// The share of a picture's reflector pixels that are off by more than 0.1.
fn wrong(session: &mut Session, scene: &Scene, view: &View, quality: Quality) -> f64 {
    let truth = picture("reference", "", scene, view, quality);
    let drawn = session.draw(view).expect("the input is valid");
    reflector_error(&drawn.picture, &truth, scene, view).over_0_1
}

#[test]
fn nodes_go_with_a_mirror_that_moves() {
    let quality = Quality { samples: 4, order: 2 };
    for name in ["vase?tess=24", "ellipsoid?surface=analytic&tess=16", "glass_sphere?tess=24"] {
        let still = scene(name);
        let view = still.default_view(120, 90);
        let mut session = prepared(ID, MORPH, &still, quality);
        assert!(built(&mut session, &view) > 0);
        let step = DVec3::new(0.01, 0.004, -0.006);
        let frames = (1..=3).map(|frame| moved(&still, &[(step * f64::from(frame), 0.01 * f64::from(frame))]));
        let (mut last, mut later) = (still.clone(), 0);
        for (number, scene) in frames.enumerate() {
            session.update(&scene).expect("it is the same scene");
            let count = built(&mut session, &view);
            // First they are built again, with room to move. Later the eye may pass into another tetrahedron.
            later += if number == 0 { 0 } else { count };
            last = scene;
        }
        assert!(later <= 3, "{name}: {later} nodes built");
        let options = RoundTripOptions { order: 2, every: 1 };
        let found = session
            .with_projector(&view, |projector| round_trip(&last, &view, projector, options, &Silent))
            .expect("the input is valid")
            .expect("nobody cancels");
        assert!(found.all.count > 300 && found.all.missing <= 0.01, "{name}: {found:?}");
        assert!(found.all.p99.is_some_and(|p99| p99 <= 0.5), "{name}: {found:?}");
        // Moved nodes are as right as cameras that are built at the eye.
        let kept = wrong(&mut session, &last, &view, quality);
        let at_eye = wrong(&mut prepared(ID, "work = 1000", &last, quality), &last, &view, quality);
        assert!(
            kept <= 1.2 * at_eye + 3e-3,
            "{name}: {kept} of the pixels are wrong, with cameras at the eye {at_eye}"
        );
    }
}

#[test]
fn what_moves_against_a_mirror_matters_to_longer_paths() {
    let still = scene("two_spheres?tess=16");
    let view = still.default_view(120, 90);
    let one = |frame: u32| moved(&still, &[(DVec3::new(0.0, 0.004, 0.0) * f64::from(frame), 0.0)]);
    let both = |frame: u32| {
        let step = DVec3::new(0.0, 0.004, 0.0) * f64::from(frame);
        moved(&still, &[(step, 0.0), (step, 0.0)])
    };
    let counts = |order: u32, pose: &dyn Fn(u32) -> Scene| -> Vec<u64> {
        let mut session = prepared(ID, MORPH, &still, Quality { samples: 1, order });
        let mut counts = vec![built(&mut session, &view)];
        for frame in 1..=3 {
            session.update(&pose(frame)).expect("it is the same scene");
            counts.push(built(&mut session, &view));
        }
        counts
    };
    for (order, pose, is_kept) in [(1, &one as &dyn Fn(u32) -> Scene, true), (2, &both, true), (2, &one, false)] {
        let counts = counts(order, pose);
        assert_eq!(counts[0], 8, "{counts:?}");
        let later: u64 = counts[2..].iter().sum();
        assert!(if is_kept { later <= 2 } else { later == 16 }, "order {order}: {counts:?}");
    }
}

/// Something leaves the scene's box a little further in every frame, and so may not be where cameras are accurate.
#[test]
fn nodes_have_room_for_what_leaves_the_scenes_box() {
    let still = scene("ellipsoid?tess=16");
    let mut session = prepared(ID, MORPH, &still, Quality { samples: 1, order: 1 });
    let counts: Vec<u64> = (0..6)
        .map(|frame| {
            let mut scene = still.clone();
            scene.bounds.max.y += 0.02 * frame as f32 * scene.bounds.size().y;
            session.update(&scene).expect("it is the same scene");
            // Each view is another one: the data of one view is kept.
            built(&mut session, &still.default_view(120 + frame % 2, 90))
        })
        .collect();
    assert!(counts[0] > 0 && counts[1] == counts[0] && counts[2..].iter().all(|count| *count == 0), "{counts:?}");
}

/// A mirror that changes its shape is another one.
#[test]
fn nodes_of_a_mirror_that_bends_are_built_again() {
    let still = scene("ellipsoid?surface=mesh&tess=16");
    let view = still.default_view(120, 90);
    let quality = Quality { samples: 4, order: 1 };
    let mut session = prepared(ID, MORPH, &still, quality);
    let first = built(&mut session, &view);
    let mut bent = still.clone();
    let object = &mut bent.objects[still.specular_objects()[0] as usize];
    let center = object.bounds.center();
    for vertex in object.vertices.clone() {
        let place = &mut bent.positions[vertex as usize];
        *place = center + (*place - center) * Vec3::new(1.0, 0.9, 1.0);
        let normal = &mut bent.normals[vertex as usize];
        *normal = (*normal / Vec3::new(1.0, 0.9, 1.0)).normalize();
    }
    object.bounds = Aabb::around(object.vertices.clone().map(|vertex| bent.positions[vertex as usize]));
    session.update(&bent).expect("it is the same scene");
    assert_eq!(built(&mut session, &view), first);
    assert!(wrong(&mut session, &bent, &view, quality) <= 0.03);
}
