//! Objects far from reflectors that path perturbation shows by maps: their places, occlusion, and maps that are kept.

#![allow(clippy::print_stdout)] // the README's numbers

use catoptric::methods::Quality;
use catoptric::methods::projector::{Projections, VertexProjector};
use catoptric::metrics::PictureError;
use catoptric::scene::{Environment, Material, Scene, View};
use catoptric_testkit::Drawn;
use catoptric_testkit::drawing::{draw, picture, reflector_error, session, with_projector};
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Quat, Vec3};
use std::sync::Arc;

const ID: &str = "path_perturbation";
const QUALITY: Quality = Quality { samples: 4, order: 2 };
const BALL: Vec3 = Vec3::new(0.0, 0.4, 0.0);
const RADIUS: f32 = 0.5;
const FAR: usize = 36;

/// A mirror ball with three boxes near it, and a ring of others at 40 to 200 times its radius. Each face of a box is an
/// object.
fn surroundings() -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let near = builder.checker("near", 4, [200, 30, 20], [240, 190, 60]);
    for (number, corner) in
        [Vec3::new(0.7, 0.0, 0.5), Vec3::new(-1.2, 0.1, 0.4), Vec3::new(-0.2, -0.4, 0.9)].into_iter().enumerate()
    {
        builder.cuboid(&format!("near {number}"), corner, corner + Vec3::splat(0.35), false, near);
    }
    let far = builder.checker("far", 3, [20, 40, 140], [220, 230, 240]);
    for number in 0..FAR {
        let share = number as f32 / FAR as f32;
        let distance = RADIUS * (40.0 + 160.0 * (share * 7.0).fract());
        let center = BALL + Quat::from_rotation_y(share * std::f32::consts::TAU) * Vec3::X * distance;
        let half = distance * Vec3::new(0.06, 0.12, 0.06);
        builder.cuboid(&format!("far {number}"), center - half, center + half, false, far);
    }
    let mirror = builder.material(Material::mirror("mirror", Vec3::splat(0.95)));
    builder.sphere("ball", BALL, RADIUS, mirror);
    builder.camera(Vec3::new(0.3, 0.8, 2.6), BALL, 30.0);
    builder
}

/// A sky that changes from direction to direction.
fn with_sky(mut scene: Scene) -> Scene {
    let texel = |i: u32| {
        let stripe = (i % 64 / 4 + i / 64 / 4) % 2;
        [0.2 + 0.3 * stripe as f32, 0.5, 0.9 - 0.5 * stripe as f32]
    };
    scene.environment = Some(Arc::new(Environment::new("sky", 64, 32, (0..64 * 32).map(texel).collect())));
    scene
}

fn drawn(scene: &Scene, view: &View, far_px: f32) -> Drawn {
    draw(ID, &format!("far_px = {far_px}"), scene, view, QUALITY)
}

fn place_of(projector: &dyn VertexProjector, point: Vec3) -> Option<glam::Vec2> {
    let mut found = Projections::default();
    projector.project(&[point], &mut found);
    found.of(0).first().map(|one| one.image_px)
}

/// The largest distance in the picture between the places of an object's corners and those of points in the same
/// directions from the ball's centre, but a million times its radius away; `None` if none is seen.
fn misplacement_px(projector: &dyn VertexProjector, scene: &Scene, object: usize) -> Option<f32> {
    let vertices = scene.objects[object].vertices.start as usize..scene.objects[object].vertices.end as usize;
    let misplaced = scene.positions[vertices].iter().filter_map(|&corner| {
        let at_infinity = BALL + (corner - BALL).normalize() * RADIUS * 1e6;
        Some(place_of(projector, corner)?.distance(place_of(projector, at_infinity)?))
    });
    misplaced.reduce(f32::max)
}

/// At most the objects that are misplaced by no more than the bound go to the map, and at least a third of those that
/// are misplaced by less than half of it: bins of directions and boxes count for the worst in them.
#[test]
fn far_objects_are_those_that_look_ups_by_direction_show_in_their_places() {
    let scene = surroundings().build();
    let view = scene.default_view(640, 480);
    let quality = Quality { samples: 1, order: 1 };
    let misplaced: Vec<f32> = with_projector(ID, "", &scene, &view, quality, |projector| {
        (0..scene.objects.len()).filter_map(|object| misplacement_px(projector, &scene, object)).collect()
    });
    let mut report = Vec::new();
    for far_px in [0.25, 0.5, 1.0, 2.0] {
        let frame = session(ID, &format!("far_px = {far_px}"), &scene, quality).prepare_view(&view).expect("valid");
        let within = |px: f32| misplaced.iter().filter(|&&found| found <= px).count() as u64;
        report.push((far_px, within(0.5 * far_px), frame.counts["far_objects"], within(far_px)));
    }
    println!("{report:?}");
    assert!(report.iter().all(|(_, surely, far, at_most)| far <= at_most && 3 * far >= *surely), "{report:?}");
    assert!(report[3].2 > report[0].2, "{report:?}");
}

/// Pictures without maps and with them, and the errors of each against the reference, then of one against the other.
fn compared(scene: &Scene, view: &View, far_px: f32) -> ([Drawn; 2], [PictureError; 3]) {
    let truth = picture("reference", "", scene, view, QUALITY);
    let [plain, mapped] = [0.0, far_px].map(|far_px| drawn(scene, view, far_px));
    let pairs = [(&plain.picture, &truth), (&mapped.picture, &truth), (&mapped.picture, &plain.picture)];
    let errors = pairs.map(|(one, other)| reflector_error(one, other, scene, view));
    ([plain, mapped], errors)
}

/// Far boxes stand behind near ones and before a sky that is seen between them.
#[test]
fn maps_of_far_objects_are_behind_near_ones_and_before_the_sky() {
    for scene in [surroundings().build(), with_sky(surroundings().build())] {
        let view = scene.default_view(320, 240);
        let ([plain, mapped], errors) = compared(&scene, &view, 0.5);
        let counts = &mapped.report.counts;
        assert!(!plain.report.counts.contains_key("far_objects"));
        assert!(counts["far_objects"] as usize > 2 * FAR && counts["far_maps"] == 1, "{counts:?}");
        assert_eq!(counts["captured_faces"], 6);
        let [_, against_truth, against_plain] = errors;
        assert!(against_truth.flip_mean < 0.025 && against_truth.over_0_1 < 0.032, "{errors:?}");
        assert!(against_plain.flip_mean < 0.008 && against_plain.over_0_1 < 0.013, "{errors:?}");
        // The near ones are projected, and not much else.
        let projected = [&plain, &mapped].map(|drawn| drawn.report.counts["vertices_projected"]);
        assert!(projected[1] > 0 && projected[1] < projected[0], "{projected:?}");
    }
}

/// Far objects that hide parts of projected ones are projected as well: the map is behind everything.
#[test]
fn far_objects_that_hide_projected_ones_are_projected() {
    let mut builder = surroundings();
    let ground = builder.checker("ground", 64, [60, 120, 60], [150, 200, 150]);
    builder.quad("ground", Vec3::new(-200.0, -15.0, 200.0), Vec3::X * 400.0, Vec3::Z * -400.0, ground);
    let scene = builder.build();
    let view = scene.default_view(320, 240);
    let [plain, mapped] = [0.0, 0.5].map(|far_px| drawn(&scene, &view, far_px));
    // A few far objects stand beyond the ground's corners.
    let counts = &mapped.report.counts;
    assert!(counts["far_objects_projected"] > 10 * counts["far_objects"], "{counts:?}");
    let error = reflector_error(&mapped.picture, &plain.picture, &scene, &view);
    assert!(error.over_0_1 < 2e-3, "{error:?}");
}

/// A near object that moves, and an eye that moves by less than would change the set of far objects, leave the map as
/// it is; far ones that move do not.
#[test]
fn maps_are_kept_for_as_long_as_the_far_objects_stay() {
    let scene = with_sky(surroundings().build());
    let moved = |name: &str, step: Vec3| {
        let mut moved = scene.clone();
        for object in moved.objects.iter_mut().filter(|object| object.name.starts_with(name)) {
            let vertices = object.vertices.start as usize..object.vertices.end as usize;
            (object.bounds.min, object.bounds.max) = (object.bounds.min + step, object.bounds.max + step);
            moved.positions[vertices].iter_mut().for_each(|position| *position += step);
        }
        moved
    };
    let view = scene.default_view(320, 240);
    let mut aside = view.clone();
    aside.world_from_view.translation += glam::Vec3A::X * 1e-6;
    let mut session = session(ID, "far_px = 1\nfar_size = 128", &scene, QUALITY);
    let mut faces = Vec::new();
    faces.push(session.draw(&view).expect("valid").report.counts["captured_faces"]);
    faces.push(session.draw(&aside).expect("valid").report.counts["captured_faces"]);
    let changed = moved("near 0", Vec3::Y * 0.1);
    session.update(&changed).expect("valid");
    let kept = session.draw(&aside).expect("valid");
    faces.push(kept.report.counts["captured_faces"]);
    let afresh = draw(ID, "far_px = 1\nfar_size = 128", &changed, &aside, QUALITY);
    assert!(kept.picture == afresh.picture);
    session.update(&moved("far", Vec3::Y * 0.1)).expect("valid");
    faces.push(session.draw(&aside).expect("valid").report.counts["captured_faces"]);
    assert_eq!(faces, [6, 0, 0, 6]);
}

/// Virtual meshes of detailed objects take work, maps of them none. The reports, with the times of stages, are printed.
#[test]
fn maps_save_the_work_of_detailed_far_objects() {
    let mut builder = surroundings();
    let detailed = builder.checker("detailed", 8, [20, 120, 40], [240, 230, 220]);
    for number in 0..12 {
        let direction = Quat::from_rotation_y(0.26 * number as f32 + 3.3) * Vec3::X;
        let center = BALL + direction * RADIUS * 200.0 + Vec3::Y * 40.0;
        builder.sphere_mesh(&format!("detailed {number}"), center, 12.0, 48, detailed);
    }
    let scene = builder.build();
    let view = scene.default_view(320, 240);
    let (drawn, errors) = compared(&scene, &view, 0.5);
    for Drawn { report, .. } in &drawn {
        println!("{report:?}");
    }
    println!("{errors:?}");
    assert!(errors[2].flip_mean < 0.014 && errors[2].over_0_1 < 0.022, "{errors:?}");
    let work = drawn.each_ref().map(|drawn| drawn.report.counts["work"]);
    assert!(4 * work[1] < work[0], "{work:?}");
}
