//! The exact search against searches for all roots, closed forms and forward traces.

mod round_trips;

use catoptric::math::random::Stream;
use catoptric::methods::path_query::{FoundPath, PathSearch};
use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
use catoptric::methods::projection::find::path_visibility::PathVisibility;
use catoptric::methods::projector::SpecularPath;
use catoptric::optics::path::all_roots::{RootCount, RootFinder};
use catoptric::optics::path::bundle::{Bounce, BounceKind, Eye};
use catoptric::progress::Silent;
use catoptric::scene::model::{AnalyticAsset, LocalTransform, Model, Node};
use catoptric::scene::{Material, Scene};
use catoptric::surface::{AnalyticSurface, Torus};
use catoptric_scenes::builtin;
use glam::{DMat3, DQuat, DVec3, Vec3};

/// A scene of spheres of one material.
fn spheres(places: &[(Vec3, f64)], material: Material) -> Scene {
    let mut model = Model { materials: vec![material], ..Model::default() };
    for (number, &(center, radius)) in places.iter().enumerate() {
        let analytic = Some(AnalyticAsset { surface: AnalyticSurface::Sphere { radius }, material: 0, inside: false });
        let name = format!("ball {number}");
        model.nodes.push(Node { name, analytic, local: LocalTransform::at(center), ..Node::default() });
    }
    model.pose(&Default::default()).expect("the test's input is valid")
}

fn mirror() -> Material {
    Material::mirror("chrome", Vec3::ONE)
}

fn built_in(name: &str) -> Scene {
    let model = builtin::load(name, &[]).expect("the test's input is valid");
    model.pose(&Default::default()).expect("the test's input is valid")
}

fn search<'a>(scene: &'a Scene, eye: DVec3, order: u32) -> ExactSearch<'a> {
    let objects = scene.specular_objects();
    ExactSearch::new(scene, eye, order, &objects, &SearchSettings::default(), &Silent)
        .expect("the test's input is valid")
}

fn between(random: &mut Stream, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(random.next_unit())
}

fn unit_vector(random: &mut Stream) -> DVec3 {
    loop {
        let vector = DVec3::from([0; 3].map(|_| between(random, -1.0, 1.0)));
        if (0.1..1.0).contains(&vector.length()) {
            return vector.normalize();
        }
    }
}

/// The counts of a comparison with all roots.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    cases: usize,
    paths: usize,
    missed: usize,
    invented: usize,
    infinite: usize,
}

/// Compares the one-bounce paths at the scene's only reflector, from `eyes` random eyes to `points` random points each,
/// with the visible ones of all roots.
fn compare(
    scene: &Scene,
    [eyes, points]: [usize; 2],
    seed: u64,
    mut eye_at: impl FnMut(&mut Stream) -> DVec3,
    mut point_at: impl FnMut(&mut Stream, DVec3) -> DVec3,
) -> Tally {
    let object = scene.specular_objects()[0];
    let surface = scene.objects[object as usize].surface.as_ref().expect("the reflector is a formula");
    let finder = RootFinder::new(surface);
    let visibility = PathVisibility::of_scene(scene);
    let path = SpecularPath { bounces: vec![Bounce { object, kind: BounceKind::Reflect }] };
    let same = 1e-6 * f64::from(surface.bounds().diagonal());
    let mut random = Stream::new(seed);
    let mut tally = Tally::default();
    let (mut roots, mut found) = (Vec::new(), Vec::new());
    for _ in 0..eyes {
        let eye = eye_at(&mut random);
        let search = search(scene, eye, 1);
        for _ in 0..points {
            let point = point_at(&mut random, eye);
            roots.clear();
            found.clear();
            if finder.roots(&Eye::Point(eye), point, BounceKind::Reflect, 1.0, &mut roots) != RootCount::Finite {
                continue;
            }
            let outcome = search.search(point, &mut found);
            assert_eq!(outcome.found, found.len());
            tally.cases += 1;
            tally.infinite += usize::from(outcome.infinite);
            let is_found = |root: &DVec3| found.iter().any(|path| path.bounce_points[0].distance(*root) < same);
            for root in roots.iter().filter(|&&root| visibility.is_visible(eye, point, &path, &[root])) {
                tally.paths += 1;
                if !is_found(root) {
                    tally.missed += 1;
                    eprintln!(
                        "missed {root} of {} roots, {} found: eye {eye}, point {point}",
                        roots.len(),
                        found.len()
                    );
                }
            }
            for path in &found {
                assert!(path.residual < 1e-10 && path.optical_length.is_finite() && path.jacobian.is_finite());
                let straight = eye.distance(path.bounce_points[0]) + point.distance(path.bounce_points[0]);
                assert!((path.optical_length - straight).abs() < 1e-12 * straight);
                if !roots.iter().any(|root| path.bounce_points[0].distance(*root) < same) {
                    tally.invented += 1;
                    eprintln!("invented {}: eye {eye}, point {point}", path.bounce_points[0]);
                }
            }
        }
    }
    tally
}

const RADIUS: f64 = 1.25;
const CENTER: Vec3 = Vec3::new(0.5, -0.25, 1.0);

/// A point at a random distance from the test sphere's centre.
fn about_sphere(random: &mut Stream, low: f64, high: f64) -> DVec3 {
    CENTER.as_dvec3() + unit_vector(random) * between(random, low, high) * RADIUS
}

fn sphere_from_outside(cases: [usize; 2]) -> Tally {
    let scene = spheres(&[(CENTER, RADIUS)], mirror());
    let outside = |random: &mut Stream| about_sphere(random, 1.001, 4.0);
    compare(&scene, cases, 11, outside, |random, _| outside(random))
}

fn sphere_from_inside(cases: [usize; 2]) -> Tally {
    let scene = spheres(&[(CENTER, RADIUS)], mirror());
    let inside = |random: &mut Stream| about_sphere(random, 0.0, 0.999);
    compare(&scene, cases, 12, inside, |random, _| inside(random))
}

/// Eyes and points around a built-in scene's reflector, in a box three times as large.
fn around_built_in(name: &str, cases: [usize; 2]) -> Tally {
    let scene = built_in(name);
    let bounds = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let (center, half) = (bounds.center().as_dvec3(), (bounds.max - bounds.min).as_dvec3() * 1.5);
    let around = |random: &mut Stream| {
        center
            + DVec3::from([0; 3].map(|_| between(random, -1.0, 1.0))) * half.max(DVec3::splat(half.max_element() * 0.5))
    };
    compare(&scene, cases, 13, around, |random, _| around(random))
}

/// Counts for all kinds of surface; misses a thousand paths stay below the limit, and nothing is invented.
/// Counts so many cases: eyes, and points for each.
type Counting<'a> = &'a dyn Fn([usize; 2]) -> Tally;

fn count_all(cases: [usize; 2], limit: usize) {
    let counted: [(&str, Counting<'_>); 4] = [
        ("sphere from outside", &sphere_from_outside),
        ("sphere from inside", &sphere_from_inside),
        ("vase", &|cases| around_built_in("vase", cases)),
        ("dish", &|cases| around_built_in("dish", cases)),
    ];
    for (name, count) in counted {
        let tally = count(cases);
        eprintln!("{name}: {tally:?}");
        assert!(tally.cases * 10 > cases[0] * cases[1] * 9 && tally.paths * 20 > tally.cases, "{name}: {tally:?}");
        assert!(tally.missed * 1000 <= limit * tally.paths, "{name}: {tally:?}");
        assert_eq!((tally.invented, tally.infinite), (0, 0), "{name}: {tally:?}");
    }
}

#[test]
fn visible_roots_are_found_and_none_invented() {
    count_all([5, 8], 0);
}

/// The points of a turned torus lie on it, and the law holds there, by formulas in its own coordinates: all steps
/// between keep double precision.
#[test]
fn turned_surfaces_are_as_exact_as_others() {
    let [x, y, z] = [33.3, -71.7, 12.9].map(f64::to_radians);
    let rotation = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
    let (turn, center) = (DMat3::from_quat(rotation), DVec3::new(0.1, 0.2, 0.3));
    let surface = AnalyticSurface::Torus(Torus::new(0.7, 0.23).expect("the test's input is valid"));
    let mut model = Model { materials: vec![mirror()], ..Model::default() };
    let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
    let local = LocalTransform::Rigid { translation: center, rotation };
    model.nodes.push(Node { name: "ring".into(), analytic, local, ..Node::default() });
    let scene = model.pose(&Default::default()).expect("the test's input is valid");
    let mut random = Stream::new(17);
    let (mut tested, mut worst) = (0, [0.0f64; 2]);
    for _ in 0..6 {
        let eye = center + unit_vector(&mut random) * 3.0;
        let search = search(&scene, eye, 1);
        for _ in 0..20 {
            let point = center + unit_vector(&mut random) * between(&mut random, 1.2, 4.0);
            let mut found = Vec::new();
            search.search(point, &mut found);
            for path in &found {
                let local = turn.transpose() * (path.bounce_points[0] - center);
                let ring = DVec3::new(local.x, 0.0, local.z).normalize() * 0.7;
                let normal = turn * (local - ring).normalize();
                let half = (eye - path.bounce_points[0]).normalize() + (point - path.bounce_points[0]).normalize();
                worst[0] = worst[0].max(((local - ring).length() - 0.23).abs());
                worst[1] = worst[1].max((half - normal * half.dot(normal)).length());
                tested += 1;
            }
        }
    }
    assert!(tested > 30 && worst[0] < 1e-14 && worst[1] < 1e-11, "{worst:?} of {tested}");
}

/// Very near to the centre of a hollow ball, where there would be infinitely many paths, the search gives up and says
/// so; elsewhere it does not.
#[test]
fn searches_that_are_cut_short_say_so() {
    let scene = spheres(&[(Vec3::ZERO, 1.0)], mirror());
    let settings = SearchSettings { visible_only: false, ..SearchSettings::default() };
    let eye = DVec3::new(1e-5, 2e-5, 1e-5);
    let search = ExactSearch::new(&scene, eye, 1, &[0], &settings, &Silent).expect("the test's input is valid");
    let mut found = Vec::new();
    let mut outcome = |point: DVec3| search.search(point, &mut found);
    assert!(!outcome(DVec3::new(0.4, -0.2, 0.3)).cut_short);
    let near: Vec<bool> = (4..12).map(|digits| outcome(eye * (1.0 + 0.1f64.powi(digits))).cut_short).collect();
    assert!(near.contains(&true), "{near:?}");
}

#[test]
#[ignore = "10,000 cases of each kind: run it with --release"]
fn visible_roots_are_found_and_none_invented_in_many_cases() {
    count_all([100, 100], 1);
}

fn mirrored(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// Snell's law; `ratio` is the index before over that behind, `normal` on the side where light comes from.
fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let cosine = -direction.dot(normal);
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    direction * ratio + normal * (ratio * cosine - behind.sqrt())
}

fn assert_passes(origin: DVec3, direction: DVec3, point: DVec3) {
    let relative = point - origin;
    let miss = relative.cross(direction.normalize()).length();
    assert!(miss < 1e-9 && relative.dot(direction) > 0.0, "passes {point} by {miss:e}");
}

#[test]
fn light_through_a_glass_ball_arrives() {
    let index = 1.5;
    let scene = spheres(&[(CENTER, RADIUS)], Material::glass("glass", index as f32));
    let center = CENTER.as_dvec3();
    let eye = center + DVec3::new(0.4, 0.8, 3.5);
    let search = search(&scene, eye, 2);
    let mut random = Stream::new(3);
    let (mut found, mut passed) = (Vec::new(), 0);
    for _ in 0..200 {
        let point = about_sphere(&mut random, 1.2, 4.0);
        found.clear();
        search.search(point, &mut found);
        for path in found.iter().filter(|path| search.paths()[path.path as usize].kinds() == "TT") {
            let [first, second] = [path.bounce_points[0], path.bounce_points[1]];
            let normals = [first, second].map(|at| (at - center) / RADIUS);
            let into = refracted((first - eye).normalize(), normals[0], 1.0 / index);
            assert_passes(first, into, second);
            assert_passes(second, refracted(into, -normals[1], index), point);
            let length = eye.distance(first) + index * first.distance(second) + second.distance(point);
            assert!((path.optical_length - length).abs() < 1e-7);
            passed += 1;
        }
    }
    assert!(passed > 20, "{passed}");
}

#[test]
fn light_between_two_balls_arrives() {
    let places = [(Vec3::new(-1.2, 0.0, 0.0), 0.8), (Vec3::new(1.3, 0.2, 0.3), 1.0)];
    let scene = spheres(&places, mirror());
    let eye = DVec3::new(0.1, 0.6, 4.0);
    let search = search(&scene, eye, 2);
    let mut random = Stream::new(4);
    let (mut found, mut passed) = (Vec::new(), 0);
    for _ in 0..200 {
        let point = unit_vector(&mut random) * between(&mut random, 2.6, 5.0);
        found.clear();
        search.search(point, &mut found);
        for path in found.iter().filter(|path| path.bounce_count == 2) {
            let [first, second] = [path.bounce_points[0], path.bounce_points[1]];
            let bounces = &search.paths()[path.path as usize].bounces;
            let normal = |at: DVec3, bounce: Bounce| (at - places[bounce.object as usize].0.as_dvec3()).normalize();
            let between = mirrored((first - eye).normalize(), normal(first, bounces[0]));
            assert_passes(first, between, second);
            assert_passes(second, mirrored(between, normal(second, bounces[1])), point);
            passed += 1;
        }
    }
    assert!(passed > 100, "{passed}");
}

#[test]
fn infinitely_many_paths_are_reported_and_left_out() {
    let scene = spheres(&[(CENTER, RADIUS)], mirror());
    let center = CENTER.as_dvec3();
    // Eye and point lie on a line through the centre, on both sides of it: a circle of paths at the cosine R (b - a) /
    // (2 a b).
    for axis in [DVec3::X, DVec3::Z, DVec3::new(1.0, 2.0, -0.5).normalize()] {
        let eye = center + axis * (0.4 * RADIUS);
        let point = center - axis * (0.5 * RADIUS);
        let mut found = Vec::new();
        let outcome = search(&scene, eye, 1).search(point, &mut found);
        assert!(outcome.infinite && found.is_empty(), "{axis}: {outcome:?} {found:?}");
    }
    let mut found = Vec::new();
    let outcome = search(&scene, center, 1).search(center, &mut found);
    assert!(outcome.infinite && found.is_empty(), "{outcome:?} {found:?}");
}

#[test]
fn a_point_on_a_caustic_has_no_infinitely_many_paths() {
    let scene = spheres(&[(CENTER, RADIUS)], mirror());
    let center = CENTER.as_dvec3();
    for angle in [0.2f64, 0.5, 0.8] {
        // A bounce with this angle of incidence, and its tangential focus by Coddington's equation.
        let bounce = center + DVec3::X * RADIUS;
        let back = DVec3::new(-angle.cos(), angle.sin(), 0.0);
        let distance = 1.1 * RADIUS * angle.cos();
        let focus = 1.0 / (2.0 / (RADIUS * angle.cos()) - 1.0 / distance);
        let eye = bounce + back * distance;
        let point = bounce + DVec3::new(-angle.cos(), -angle.sin(), 0.0) * focus;
        let mut found = Vec::new();
        let outcome = search(&scene, eye, 1).search(point, &mut found);
        let nearest = found.iter().map(|path| path.bounce_points[0].distance(bounce)).fold(f64::INFINITY, f64::min);
        assert!(!outcome.infinite && nearest < 1e-4, "{angle}: {outcome:?} {nearest:e}");
    }
}

#[test]
fn odd_points_have_paths_or_none_and_no_numbers_that_are_not() {
    let scene = spheres(&[(CENTER, RADIUS)], mirror());
    let center = CENTER.as_dvec3();
    let eye = center + DVec3::new(0.0, 0.0, 3.0) * RADIUS;
    let search = search(&scene, eye, 2);
    let on_surface = center + DVec3::new(0.6, 0.0, 0.8) * RADIUS;
    let far = DVec3::new(1e12, 1e13, 1e14);
    let mut found = Vec::new();
    for (point, expected) in [
        (DVec3::NAN, 0),
        (DVec3::new(0.0, f64::INFINITY, 0.0), 0),
        (on_surface, 0),
        (eye, 1),
        (far, 1),
        (DVec3::splat(1e300), 1),
        (center, 0),
    ] {
        found.clear();
        let outcome = search.search(point, &mut found);
        assert!(!outcome.infinite && found.iter().all(|path| path.jacobian.is_finite()), "{point}");
        if point.length() < 1e20 || !point.is_finite() {
            assert_eq!(found.len(), expected, "{point}: {found:?}");
        }
    }
    found.clear();
    search.search(eye, &mut found);
    assert!(found[0].bounce_points[0].distance(center + DVec3::Z * RADIUS) < 1e-12);
}

#[test]
fn jacobians_are_those_of_central_differences() {
    let scene = built_in("vase");
    let bounds = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let (center, size) = (bounds.center().as_dvec3(), f64::from(bounds.diagonal()));
    let search = search(&scene, center + DVec3::new(0.3, 0.5, 1.2) * size, 1);
    let mut random = Stream::new(8);
    let (mut found, mut moved) = (Vec::new(), Vec::new());
    let mut compared = 0;
    for _ in 0..100 {
        let point = center + unit_vector(&mut random) * size * between(&mut random, 0.7, 2.0);
        found.clear();
        search.search(point, &mut found);
        // Away from caustics, where the Jacobian grows without bounds.
        for path in found.iter().filter(|path| path.jacobian.to_cols_array().iter().all(|entry| entry.abs() < 3.0)) {
            let step = 1e-6 * size;
            for axis in 0..3 {
                let ends = [step, -step].map(|step| {
                    moved.clear();
                    search.search(point + DVec3::AXES[axis] * step, &mut moved);
                    let distance = |end: &&FoundPath| end.bounce_points[0].distance(path.bounce_points[0]);
                    let nearest = moved.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
                    nearest.map(|end| end.bounce_points[0])
                });
                let [Some(plus), Some(minus)] = ends else { continue };
                let error = (plus - minus) / (2.0 * step) - path.jacobian.col(axis);
                assert!(error.length() < 1e-4, "{point}: {error}");
                compared += 1;
            }
        }
    }
    assert!(compared > 60, "{compared}");
}

#[test]
#[ignore = "a measurement: run it with --release -- --ignored --nocapture"]
fn points_a_second() {
    let ball = spheres(&[(CENTER, RADIUS)], mirror());
    let vase = built_in("vase");
    for (name, scene) in [("sphere", &ball), ("vase", &vase)] {
        let bounds = scene.objects[scene.specular_objects()[0] as usize].bounds;
        let (center, size) = (bounds.center().as_dvec3(), f64::from(bounds.diagonal()));
        let eye = center + DVec3::new(0.3, 0.5, 1.2) * size;
        {
            let settings = SearchSettings::default();
            let objects = scene.specular_objects();
            let built = std::time::Instant::now();
            let search =
                ExactSearch::new(scene, eye, 1, &objects, &settings, &Silent).expect("the test's input is valid");
            let built = built.elapsed();
            let mut random = Stream::new(5);
            let points: Vec<DVec3> =
                (0..2_000).map(|_| center + unit_vector(&mut random) * size * between(&mut random, 0.6, 2.0)).collect();
            let mut found: Vec<FoundPath> = Vec::new();
            let mut rates = [0.0; 2];
            let mut sum = 0;
            for rate in &mut rates {
                let started = std::time::Instant::now();
                sum = 0;
                for point in &points {
                    found.clear();
                    sum += search.search(*point, &mut found).found;
                }
                *rate = points.len() as f64 / started.elapsed().as_secs_f64();
            }
            eprintln!("{name}: {rates:.0?} points/s, {sum} paths, built in {built:?}");
        }
    }
}
