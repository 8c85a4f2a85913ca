//! Common behaviour of the methods of virtual objects: polish makes them exact, pictures glide, lengths are
//! optical, nothing breaks them.

use catoptric::methods::projector::{Projection, Projections, VertexProjector};
use catoptric::methods::{self, Quality, Report};
use catoptric::progress::Silent;
use catoptric::scene::{Material, Role};
use catoptric_scenes::builtin;
use catoptric_testkit::drawing::{error, round_trips, scene, with_projector};
use catoptric_testkit::scenes::{SceneBuilder, sphere_in_room};
use glam::{Quat, Vec3};
use std::sync::Arc;

/// The goal of the methods on convex reflectors.
#[test]
fn two_steps_of_polish_make_every_kind_of_start_exact() {
    // With only two spheres the start may be so far off that the solver gets nowhere.
    let starts = [
        ("explosion_map", "preset = 'balanced'", 1e-3),
        ("explosion_map", "preset = 'fast'", 1e-3),
        ("explosion_map", "preset = 'faithful'", 5e-3),
        ("reflector_search", "", 5e-3),
        ("reflector_search", "images = 'cube'", 5e-3),
        ("reflector_search", "refine = 'texel'", 5e-3),
    ];
    // These views have the size of the project's goal.
    for spec in ["sphere_room?tess=48", "sphere_room?surface=analytic", "ellipsoid", "two_spheres?tess=48"] {
        let scene = scene(spec);
        for (id, start, missing) in starts {
            let trips = round_trips(id, &scene, &format!("{start}\npolish = 2"), 6);
            assert!(trips.all.p99.is_some_and(|p99| p99 <= 0.1), "{spec}, {id} {start}: {trips:?}");
            assert!(trips.all.missing <= missing, "{spec}, {id} {start}: {trips:?}");
        }
    }
}

/// Sheets that end show no points that none of their rays meets: appearances lie in the direction of their reflection
/// point, but for a few pixels beside silhouettes.
#[test]
fn nothing_appears_far_from_its_reflection_point() {
    let scene = scene("car");
    let view = scene.default_view(480, 360);
    let quality = Quality { samples: 1, order: 1 };
    let sky = scene.objects.iter().find(|object| object.name == "sky").expect("the car has a sky").bounds;
    for id in ["explosion_map", "reflector_search"] {
        // Points of the horizon, all around.
        let point = |step: u16| {
            let (turn, height) = (f32::from(step) * 0.01, f32::from(step % 7) * 0.02);
            sky.center() + Vec3::new(turn.cos(), height, turn.sin()) * sky.size() * 0.49
        };
        let points: Vec<Vec3> = (0..2000u16).map(point).collect();
        let all = with_projector(id, "", &scene, &view, quality, |projector| {
            let mut found = Projections::default();
            projector.project(&points, &mut found);
            found.all().to_vec()
        });
        for one in &all {
            let seen = view.pixel_of(one.reflection_point).expect("it is before the eye");
            let off = seen.distance(one.image_px);
            assert!(off < 5.0, "{id}: {off} pixels from its reflection point, {one:?}");
        }
        assert!(all.len() > 1000, "{id}: {} found", all.len());
    }
}

/// Path lengths are those of a method that follows rays: within glass, times its index of refraction.
#[test]
fn lengths_are_optical() {
    let scene = scene("lens?distance=0.8");
    let view = scene.default_view(320, 240);
    let quality = Quality { samples: 1, order: 2 };
    // The points lie beyond the lens, on its axis and beside it.
    let lens = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let away = (lens.center() - view.eye()).normalize();
    let points = [0.0, 0.02, 0.05].map(|aside| lens.center() + away * 0.5 + Vec3::Y * aside);
    let found = |projector: &dyn VertexProjector| -> Vec<(usize, Projection)> {
        let wanted = |path: &u32| projector.paths()[*path as usize].kinds() == "TT";
        let path = (0..projector.paths().len() as u32).find(wanted).expect("the lens is looked through");
        let mut found = Projections::default();
        projector.project_on(path, &points, &mut found);
        (0..points.len()).flat_map(|number| found.of(number).iter().map(move |one| (number, *one))).collect()
    };
    let expected = with_projector("path_perturbation", "polish = 20", &scene, &view, quality, found);
    assert!(expected.len() >= 3, "{expected:?}");
    for (id, settings) in [
        ("explosion_map", ""),
        ("explosion_map", "preset = 'exact'"),
        ("explosion_map", "virtual_vertex = 'mirrored'"),
        ("reflector_search", ""),
        ("reflector_search", "polish = 8"),
    ] {
        let found = with_projector(id, settings, &scene, &view, quality, found);
        let mut compared = 0;
        for (number, one) in &found {
            let near =
                |(other, two): &&(usize, Projection)| other == number && one.image_px.distance(two.image_px) < 1.0;
            let Some((_, exact)) = expected.iter().find(near) else { continue };
            let apart = (one.path_length - exact.path_length).abs();
            assert!(apart < 2e-3 * exact.path_length, "{id} {settings}: {one:?}, not {exact:?}");
            compared += 1;
        }
        assert!(compared >= 3, "{id} {settings}: {found:?}, not {expected:?}");
    }
}

/// The picture of a point moves as its own change predicts, frame by frame: nothing jumps, neither from cell to cell
/// nor where the map ends.
#[test]
fn reflections_of_moving_things_glide() {
    let scene = sphere_in_room(true);
    let center = Vec3::new(0.0, 1.0, -0.5);
    let view = scene.default_view(640, 480);
    let quality = Quality { samples: 1, order: 1 };
    let cases = [
        ("explosion_map", "", 0.25),
        ("explosion_map", "preset = 'fast'", 1.5),
        ("reflector_search", "", 0.25),
        ("reflector_search", "images = 'cube'", 0.25),
    ];
    for (id, settings, bound_px) in cases {
        let glide = |projector: &dyn VertexProjector| {
            let mut compared = 0;
            for start in [Vec3::new(1.2, 0.1, 0.3), Vec3::new(0.3, 0.9, -1.0), Vec3::new(-1.0, -0.4, -0.9)] {
                let mut before = None;
                for frame in 0..60 {
                    // The points go all the way around, behind the ball as well.
                    let turn = Quat::from_rotation_y(frame as f32 * std::f32::consts::TAU / 60.0);
                    let point = center + turn * start;
                    let mut found = Projections::default();
                    projector.project_on(0, &[point], &mut found);
                    let found = found.all();
                    assert!(found.len() <= 1, "a convex mirror shows a point once: {found:?}");
                    if let (Some((old_point, old)), Some(new)) = (before, found.first()) {
                        // The mean of both ends' predictions is exact to second order.
                        let old: Projection = old;
                        let step = point - old_point;
                        let ahead = old.predicted(step) - old.image_px;
                        let back = new.image_px - new.predicted(-step);
                        let expected = old.image_px + (ahead + back) * 0.5;
                        let miss = expected.distance(new.image_px);
                        // Above the tangent planes of both reflection points it is a reflection; elsewhere it
                        // appears beside the ball, and turns where it gets there.
                        let above = |point: Vec3, one: &Projection| {
                            (point - one.reflection_point).dot((one.reflection_point - center).normalize()) > 0.0
                        };
                        let seen = above(point, new) && above(old_point, &old);
                        let most = if seen { 0.1 * ahead.length() } else { ahead.length().max(back.length()) };
                        assert!(miss <= bound_px + most, "{id} {settings} frame {frame}: {miss} px, {ahead}, {back}");
                        compared += 1;
                    }
                    before = found.first().map(|one| (point, *one));
                }
            }
            compared
        };
        let compared = with_projector(id, settings, &scene, &view, quality, glide);
        assert!(compared > 90, "{id} {settings}: {compared}");
    }
}

/// Paths beyond the 256 that are built are counted: 18 balls have 18 + 18 * 17 of up to two bounces, for none shows
/// itself.
#[test]
fn paths_that_are_left_out_are_counted() {
    let mut builder = SceneBuilder::new();
    let chrome = builder.material(Material::mirror("chrome", Vec3::ONE));
    for ball in 0..18u8 {
        let center = Vec3::new(f32::from(ball % 6) - 2.5, f32::from(ball / 6) - 1.0, 0.0);
        builder.sphere_mesh(&format!("ball {ball}"), center, 0.3, 4, chrome);
    }
    builder.camera(Vec3::new(0.0, 0.0, 8.0), Vec3::ZERO, 50.0);
    let scene = Arc::new(builder.build());
    let view = scene.default_view(64, 48);
    let settings = "preset = 'fast'\nmap_size = 8\nlongest_edge = 10.0\nwork = 150\nbeyond_work = 'coarse'";
    let settings = settings.parse().expect("the test's input is valid");
    let method = methods::create("explosion_map", &settings).expect("the test's input is valid");
    for (order, left_out) in [(1, None), (2, Some(18 + 18 * 17 - 256))] {
        let quality = Quality { samples: 1, order };
        let mut prepared = method.prepare(&scene, quality, None, &Silent).expect("the test's input is valid");
        let frame = prepared.frame(&view, &Silent).expect("the test's input is valid");
        assert_eq!(frame.report().fallbacks.get("paths_left_out").copied(), left_out, "order {order}");
    }
}

/// Files are wound either way round, and mirrors show the same on both sides.
#[test]
fn meshes_turned_inside_out_show_the_same() {
    for spec in ["sphere_room?tess=24", "torus?surface=mesh&tess=24"] {
        let mut model = builtin::parse(spec).expect("it is built in");
        let mirrors: Vec<bool> = model.materials.iter().map(|material| material.role == Role::Reflector).collect();
        for primitive in model.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
            if mirrors[primitive.material] {
                primitive.triangles.iter_mut().for_each(|triangle| triangle.reverse());
                primitive.normals.iter_mut().for_each(|normal| *normal = -*normal);
            }
        }
        let turned = model.pose(&Default::default()).expect("it is as it was, but for the sides");
        for id in ["explosion_map", "reflector_search", "path_perturbation", "sample_based_camera"] {
            let [as_it_was, turned] = [&scene(spec), &turned].map(|scene| round_trips(id, scene, "", 16).all);
            // A ball that is not known to be convex may lack a point at its silhouette.
            assert!(turned.missing <= as_it_was.missing + 4e-3, "{spec}, {id}: {turned:?}, not {as_it_was:?}");
            let p99 = [&as_it_was, &turned].map(|trips| trips.p99.expect("something is seen"));
            assert!(p99[1] < p99[0] + 0.05, "{spec}, {id}: {turned:?}, not {as_it_was:?}");
        }
    }
}

/// A mirror ball is a wall to an eye in it: it shows the box beside the eye, and nothing of the room outside.
#[test]
fn an_eye_in_a_mirror_ball_sees_what_is_in_it() {
    for analytic in [true, false] {
        let mut builder = SceneBuilder::new();
        let chrome = builder.material(Material::mirror("chrome", Vec3::ONE));
        let red = builder.flat("red", Vec3::new(0.8, 0.1, 0.1));
        let white = builder.flat("white", Vec3::ONE);
        builder.cuboid("room", Vec3::splat(-4.0), Vec3::splat(4.0), true, white);
        builder.cuboid("box", Vec3::new(0.6, -0.3, -0.4), Vec3::new(1.0, 0.4, 0.2), false, red);
        if analytic {
            builder.sphere("ball", Vec3::ZERO, 2.0, chrome);
        } else {
            builder.sphere_mesh("ball", Vec3::ZERO, 2.0, 60, chrome);
        }
        builder.camera(Vec3::new(-0.5, 0.2, 0.9), Vec3::new(0.4, 0.0, -1.0), 60.0);
        let scene = builder.build();
        let view = scene.default_view(64, 48);
        let quality = Quality { samples: 4, order: 1 };
        for id in ["explosion_map", "reflector_search", "path_perturbation", "sample_based_camera"] {
            let error = error(id, "", &scene, &view, quality);
            assert!(error.over_0_1 < 0.03, "{id}, analytic: {analytic}: {error:?}");
        }
    }
}

/// All rays meet at the centre of a hollow ball that the eye is near to: more cells hold that place than are searched.
#[test]
fn cells_that_are_not_searched_are_counted() {
    let mut builder = SceneBuilder::new();
    let chrome = builder.material(Material::mirror("chrome", Vec3::ONE));
    builder.sphere_mesh("hollow", Vec3::ZERO, 2.0, 60, chrome);
    builder.camera(Vec3::new(0.0, 0.0, 0.001), Vec3::new(0.0, 0.0, -1.0), 100.0);
    let scene = builder.build();
    let view = scene.default_view(64, 48);
    let quality = Quality { samples: 1, order: 1 };
    with_projector("explosion_map", "", &scene, &view, quality, |projector| {
        let counted = |point: Vec3| {
            projector.project_on(0, &[point], &mut Projections::default());
            let mut report = Report::default();
            projector.add_fallbacks(&mut report);
            report.fallbacks.get("cells_not_searched").copied()
        };
        assert_eq!(counted(Vec3::new(1.0, 0.7, 0.3)), None);
        assert!(counted(Vec3::new(0.0, 0.0, -0.001)).is_some_and(|cells| cells > 100));
    });
}

/// Only methods that trace rays through the reflectors build the hierarchy over them.
#[test]
fn methods_that_trace_nothing_build_no_hierarchy() {
    let scene = Arc::new(scene("sphere_room?tess=8"));
    let quality = Quality { samples: 1, order: 1 };
    for (id, traces) in [
        ("explosion_map", false),
        ("reflector_search", false),
        ("path_perturbation", true),
        ("sample_based_camera", true),
    ] {
        let method = methods::create(id, &Default::default()).expect("the test's input is valid");
        let mut prepared = method.prepare(&scene, quality, None, &Silent).expect("the test's input is valid");
        let builds = |report: &Report| report.stages_ms.iter().any(|(stage, _)| *stage == "bvh");
        assert_eq!(builds(prepared.report()), traces, "{id}");
        prepared.update(&scene, quality, &Silent).expect("the test's input is valid");
        assert!(!builds(prepared.report()), "{id}: the reflectors are the same");
    }
}
