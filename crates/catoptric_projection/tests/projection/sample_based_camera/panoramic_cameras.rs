//! Sample-based cameras for all directions about a point, against closed forms and the exact search.

use catoptric::math::Aabb;
use catoptric::math::random::Stream;
use catoptric::methods::path_query::{FoundPath, PathSearch};
use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
use catoptric::methods::projection::sample_based_camera::{
    CameraKind, PanoramaSettings, PanoramicCameras, PanoramicMirrors, PanoramicProjection, PanoramicProjector,
};
use catoptric::progress::Silent;
use catoptric::scene::Scene;
use catoptric_testkit::drawing::scene;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{DMat3, DVec3, Vec3};

/// The ball of `sphere_room`.
const BALL: Ball = Ball { center: DVec3::new(0.0, 1.3, 0.0), radius: 0.8 };

/// An eye from which the ball covers parts of three faces and the corner between them.
const BESIDE_BALL: Vec3 = Vec3::new(-0.75, 1.9, 0.75);

/// Between the balls of `two_spheres`, so near that each covers most of a face and parts of others.
const BETWEEN_BALLS: Vec3 = Vec3::new(0.15, 1.3, 0.75);

struct Ball {
    center: DVec3,
    radius: f64,
}

impl Ball {
    /// The first point of a ray on it, from outside.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<DVec3> {
        let relative = self.center - origin;
        let along = relative.dot(direction);
        let half2 = self.radius * self.radius - (relative - direction * along).length_squared();
        (half2 > 0.0 && along > 0.0).then(|| origin + direction * (along - half2.sqrt()))
    }

    fn normal(&self, point: DVec3) -> DVec3 {
        (point - self.center).normalize()
    }
}

fn mirrored(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// The point at which a ray leaves a box.
fn exit(bounds: &Aabb, from: DVec3, direction: DVec3) -> f64 {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let walls =
        (0..3).map(|axis| ((if direction[axis] > 0.0 { max } else { min })[axis] - from[axis]) / direction[axis]);
    walls.filter(|distance| !distance.is_nan()).fold(f64::INFINITY, f64::min)
}

fn between(random: &mut Stream, low: DVec3, high: DVec3) -> DVec3 {
    low + (high - low) * DVec3::from([0; 3].map(|_| f64::from(random.next_unit())))
}

fn any_direction(random: &mut Stream) -> DVec3 {
    loop {
        let vector = between(random, -DVec3::ONE, DVec3::ONE);
        if (0.01..1.0).contains(&vector.length_squared()) {
            return vector.normalize();
        }
    }
}

fn settings(order: u32) -> PanoramaSettings {
    PanoramaSettings { size_px: 256, order, ..PanoramaSettings::default() }
}

fn cameras(mirrors: &PanoramicMirrors<'_>, eye: Vec3, settings: &PanoramaSettings) -> PanoramicCameras {
    PanoramicCameras::new(mirrors, eye, settings, &Silent).expect("the test's input is valid")
}

fn seen(projector: &PanoramicProjector<'_>, point: DVec3) -> Vec<PanoramicProjection> {
    let mut found = Vec::new();
    projector.project(point.as_vec3(), &mut found);
    found
}

/// The angle of `count` pixels in the middle of a face, in radians.
fn pixels(settings: &PanoramaSettings, count: f64) -> f64 {
    count * 2.0 / f64::from(settings.size_px)
}

/// A share of sorted numbers is below it.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

/// The appearances that the exact search finds for random points of a scene, against those of panoramic cameras: the
/// angles to the nearest, sorted; how many have none; how many have several.
fn against_search(scene: &Scene, eye: Vec3, settings: &PanoramaSettings, points: usize) -> (Vec<f64>, usize, usize) {
    let mirrors = PanoramicMirrors::new(scene);
    let cameras = cameras(&mirrors, eye, settings);
    let projector = cameras.projector(&mirrors).expect("it was built for the scene");
    let (objects, search) = (scene.specular_objects(), SearchSettings::default());
    let search = ExactSearch::new(scene, eye.as_dvec3(), settings.order, &objects, &search, &Silent);
    let search = search.expect("the test's input is valid");
    let mut random = Stream::new(41);
    let (mut angles, mut missing, mut twice) = (Vec::new(), 0, 0);
    // Nearer than this is an appearance, farther away is another.
    let near = pixels(settings, 2.0 * f64::from(settings.downsampling));
    let mut exact = Vec::new();
    for _ in 0..points {
        let point = between(&mut random, scene.bounds.min.as_dvec3(), scene.bounds.max.as_dvec3());
        let point = point.as_vec3().as_dvec3();
        let found = seen(&projector, point);
        exact.clear();
        search.search(point, &mut exact);
        for path in &exact {
            let direction = (path.bounce_points[0] - eye.as_dvec3()).normalize();
            let same =
                |one: &&PanoramicProjection| cameras.paths()[one.path as usize] == search.paths()[path.path as usize];
            let distance = |one: &PanoramicProjection| one.direction.as_dvec3().distance(direction);
            let distances = sorted(found.iter().filter(same).map(distance).collect());
            match distances.first() {
                Some(&nearest) if nearest < near => angles.push(nearest),
                _ => missing += 1,
            }
            let also_near = distances.iter().skip(1).filter(|&&distance| distance < near).count();
            let other_exact = |other: &&FoundPath| {
                let other_direction = (other.bounce_points[0] - eye.as_dvec3()).normalize();
                other.path == path.path && other_direction.distance(direction) < 2.0 * near
            };
            twice += usize::from(also_near + 1 > exact.iter().filter(other_exact).count());
        }
    }
    (sorted(angles), missing, twice)
}

#[test]
fn points_appear_where_the_exact_search_finds_them() {
    // Quantiles of the angle in pixels of a face, and shares of missing and doubled appearances: the picture of one
    // ball in the other is a few pixels wide, and most points crowd at its silhouette. There the solver may not get to
    // the end in its steps: its start is as near as the cameras are.
    let cases = [
        ("sphere_room", BESIDE_BALL, 1, 0, [0.02, 0.05, 0.1], [0.0, 0.0]),
        ("sphere_room", BESIDE_BALL, 1, 8, [1e-4, 1e-4, 1e-4], [0.0, 0.0]),
        ("two_spheres", BETWEEN_BALLS, 2, 0, [0.02, 0.1, 0.5], [4e-4, 4e-3]),
        ("two_spheres", BETWEEN_BALLS, 2, 8, [1e-4, 1e-4, 0.1], [4e-4, 1e-3]),
    ];
    for (name, eye, order, polish, most_px, most_shares) in cases {
        let scene = scene(&format!("{name}?surface=analytic&tess=8"));
        let settings = PanoramaSettings { polish, ..settings(order) };
        let (angles, missing, twice) = against_search(&scene, eye, &settings, 4000);
        let found = [0.5, 0.99, 1.0].map(|share| quantile(&angles, share));
        let ([p50, p99, max], count) = (found, angles.len());
        let summary = format!(
            "{name}, polish {polish}: {missing} missing, {twice} twice of {count}; {p50:.2e}, {p99:.2e}, {max:.2e} rad"
        );
        eprintln!("{summary}");
        assert!(count > 2000, "{summary}");
        assert!(found.iter().zip(most_px).all(|(&found, most)| found <= pixels(&settings, most)), "{summary}");
        let shares = [missing, twice].map(|number| number as f64 / count as f64);
        assert!(shares.iter().zip(most_shares).all(|(share, most)| *share <= most), "{summary}");
    }
}

#[test]
fn reflections_in_a_ball_are_where_rays_were_sent() {
    let scene = scene("sphere_room?surface=analytic&tess=8");
    let mirrors = PanoramicMirrors::new(&scene);
    let settings = settings(1);
    let cameras = cameras(&mirrors, BESIDE_BALL, &settings);
    let projector = cameras.projector(&mirrors).expect("it was built for the scene");
    let (eye, accuracy) = (BESIDE_BALL.as_dvec3(), pixels(&settings, 0.1));
    let mut random = Stream::new(42);
    let mut angles = Vec::new();
    while angles.len() < 4000 {
        let direction = any_direction(&mut random);
        let Some(hit) = BALL.hit(eye, direction) else { continue };
        let normal = BALL.normal(hit);
        let reflected = mirrored(direction, normal);
        let point =
            hit + reflected * (exit(&scene.bounds, hit, reflected) * f64::from(random.next_between(0.05, 0.98)));
        let found = seen(&projector, point);
        // A ball shows every point once.
        let [one] = found[..] else { panic!("{direction} shows {point}: {found:?}") };
        let angle = one.direction.as_dvec3().distance(direction);
        angles.push(angle);
        // The tolerance of the reflection point on the surface, and of all that turns with it.
        let (to_eye, to_point) = (hit.distance(eye), hit.distance(point));
        let off = accuracy * to_eye / -direction.dot(normal);
        let reflection = one.reflection_point.as_dvec3();
        assert!(reflection.distance(hit) < off, "{reflection}, not {hit}");
        let law = mirrored((reflection - eye).normalize(), BALL.normal(reflection));
        let residual = law.distance((point - reflection).normalize());
        let turned = accuracy + off * (2.0 / BALL.radius + 1.0 / to_point);
        assert!(residual < turned, "the mirror law fails by {residual}, not by {turned} at the most");
        assert!((f64::from(one.path_length) - to_eye - to_point).abs() < 2.0 * off);
        assert!((f64::from(one.last_segment) - to_point).abs() < off);
    }
    let angles = sorted(angles);
    let [p50, p99, max] = [0.5, 0.99, 1.0].map(|share| quantile(&angles, share));
    assert!(p99 <= 0.5 * accuracy && max <= accuracy, "{p50:.2e}, {p99:.2e}, {max:.2e}");
}

/// The ball's reflections beside and on the three seams, and in the corner, that it covers.
#[test]
fn across_the_cubes_edges_everything_appears_once() {
    let scene = scene("sphere_room?surface=analytic&tess=8");
    let mirrors = PanoramicMirrors::new(&scene);
    let eye = BESIDE_BALL.as_dvec3();
    let exact = PanoramaSettings { polish: 8, ..settings(1) };
    let coarse = PanoramaSettings { downsampling: 4, accuracy_px: 4.0, ..settings(1) };
    let pinholes = PanoramaSettings { camera: CameraKind::Pinhole, accuracy_px: 1.0, ..settings(1) };
    for (settings, most_px) in [(settings(1), 0.3), (exact, 0.001), (coarse, 8.0), (pinholes, 2.0)] {
        let cameras = cameras(&mirrors, BESIDE_BALL, &settings);
        let projector = cameras.projector(&mirrors).expect("it was built for the scene");
        let mut random = Stream::new(43);
        let mut count = 0;
        for seam in [[DVec3::X, DVec3::NEG_Z], [DVec3::X, DVec3::NEG_Y], [DVec3::NEG_Y, DVec3::NEG_Z]] {
            let across = DVec3::new(1.0, -1.0, -1.0) - seam[0] - seam[1];
            for _ in 0..300 {
                let middle = seam[0] + seam[1] + across * f64::from(random.next_between(-1.0, 1.0));
                let share = f64::from(random.next_between(0.05, 0.98));
                let mut before: Option<(DVec3, PanoramicProjection)> = None;
                // The first steps are between two neighbouring numbers of single precision, the last are longer than a
                // cell.
                for step in [-3e-2, -3e-3, -3e-4, -3e-5, -3e-6, -1e-7, 0.0, 1e-7, 3e-6, 3e-5, 3e-4, 3e-3, 3e-2] {
                    let direction = (middle + seam[0] * step).normalize();
                    let Some(hit) = BALL.hit(eye, direction) else { continue };
                    let normal = BALL.normal(hit);
                    // Beside silhouettes a step moves points far.
                    if direction.dot(normal) > -0.2 {
                        continue;
                    }
                    let reflected = mirrored(direction, normal);
                    let point = hit + reflected * (exit(&scene.bounds, hit, reflected) * share);
                    let found = seen(&projector, point);
                    let [one] = found[..] else { panic!("{settings:?}: {direction}: {found:?}") };
                    let angle = one.direction.as_dvec3().distance(direction);
                    assert!(angle <= pixels(&settings, most_px) + 3e-7, "{settings:?}: {angle} at {direction}");
                    // The appearance does not jump from one face to the next: the step is the predicted one.
                    if let Some((point_before, before)) = before.filter(|_| step.abs() <= 3e-4) {
                        let moved = one.direction - before.direction;
                        let expected = before.direction_change * (point - point_before).as_vec3();
                        let apart = f64::from((moved - expected).length());
                        assert!(apart <= 2.0 * pixels(&settings, most_px) + 1e-6, "{settings:?}: a jump of {apart}");
                    }
                    before = Some((point, one));
                    count += 1;
                }
            }
        }
        assert!(count > 5000, "{count}");
    }
}

/// Random points before a flat mirror. Directions are off by so many pixels at the most, their derivatives by such a
/// share of the greatest change for a point that near.
fn before_a_flat_mirror(polish: u32, most_px: f64, most_change: f64) {
    let scene = scene("planar_mirror?mirrors=1&surface=analytic&tess=8");
    let mirror = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let (low, high) = (mirror.min.as_dvec3(), mirror.max.as_dvec3());
    let plane = (low.z + high.z) / 2.0;
    // The mirror hangs at the back wall. From here it covers a face and reaches into four others.
    let eye = DVec3::new(0.25, 1.5, plane + 0.375).as_vec3().as_dvec3();
    let mirrors = PanoramicMirrors::new(&scene);
    let settings = PanoramaSettings { polish, ..settings(1) };
    let cameras = cameras(&mirrors, eye.as_vec3(), &settings);
    assert_eq!(cameras.report().counts["faces"], 5);
    let projector = cameras.projector(&mirrors).expect("it was built for the scene");
    let mut random = Stream::new(44);
    let (mut angles, mut changes) = (Vec::new(), Vec::new());
    for _ in 0..4000 {
        let room = (scene.bounds.min.as_dvec3().with_z(high.z + 1e-2), scene.bounds.max.as_dvec3());
        let point = between(&mut random, room.0, room.1).as_vec3().as_dvec3();
        let image = DVec3::new(point.x, point.y, 2.0 * plane - point.z);
        let way = image - eye;
        let hit = eye + way * ((plane - eye.z) / way.z);
        let beyond = (low - hit).max(hit - high).truncate().max_element();
        let found = seen(&projector, point);
        // Appearances go on a little beyond borders: three quarters of a cell of the ray map.
        // The angle to the plane through the eye and a border that it is beyond.
        let angle = |axis: usize| {
            let mut to_border = (hit.clamp(low, high) - eye).with_z(plane - eye.z);
            to_border[1 - axis] = 0.0;
            let across = to_border.cross(DVec3::AXES[1 - axis]).normalize();
            if hit[axis] < low[axis] || hit[axis] > high[axis] { across.dot(way.normalize()).abs() } else { 0.0 }
        };
        if angle(0).max(angle(1)) > pixels(&settings, 0.75 * f64::from(settings.downsampling)) {
            assert!(found.is_empty(), "{point} is beyond the mirror's border by {beyond}: {found:?}");
        } else if beyond < -1e-3 {
            let [one] = found[..] else { panic!("{point}: {found:?}") };
            let direction = way.normalize();
            angles.push(one.direction.as_dvec3().distance(direction));
            assert_eq!(one.focal_index, 0);
            let longer = (f64::from(one.path_length) - way.length()).abs();
            assert!(longer < 2e-3, "{} {}", one.path_length, way.length());
            let across = DMat3::IDENTITY
                - DMat3::from_cols_array(&std::array::from_fn(|index| direction[index % 3] * direction[index / 3]));
            let change = across * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)) * (1.0 / way.length());
            let off = (one.direction_change.as_dmat3() - change).to_cols_array();
            let off = off.iter().fold(0.0, |most: f64, off| most.max(off.abs()));
            changes.push(off * way.length());
        }
    }
    let angles = sorted(angles);
    let max = quantile(&angles, 1.0);
    let changes = sorted(changes);
    let [half, most] = [0.5, 1.0].map(|share| quantile(&changes, share));
    let summary = format!("polish {polish}: {max:.2e} rad at the most; changes {half:.2e}, {most:.2e}");
    eprintln!("flat mirror, {} points, {summary}", angles.len());
    assert!(angles.len() > 1000 && max <= pixels(&settings, most_px) && most <= most_change, "{summary}");
}

#[test]
fn a_flat_mirror_shows_mirrored_points() {
    // A single leaf fills the face. Its polynomials are held to the accuracy; their derivatives are not, and are worst
    // at its border.
    before_a_flat_mirror(0, 0.1, 0.05);
    before_a_flat_mirror(8, 1e-4, 1e-5);
}

/// The way back of paths with two bounces in closed form: the ray in the direction that is given passes the point as
/// near as the accuracy allows.
#[test]
fn rays_sent_in_the_directions_of_second_reflections_pass_through_their_points() {
    let scene = scene("two_spheres?surface=analytic&tess=8");
    let mirrors = PanoramicMirrors::new(&scene);
    let ball = |object: u32| {
        let bounds = scene.objects[object as usize].bounds;
        let radius = f64::from(bounds.max.y - bounds.min.y) / 2.0;
        Ball { center: bounds.center().as_dvec3(), radius }
    };
    for (polish, most_p50_px, most_p95_px) in [(0, 0.1, 1.0), (8, 1e-4, 1e-3)] {
        let settings = PanoramaSettings { polish, ..settings(2) };
        let cameras = cameras(&mirrors, BETWEEN_BALLS, &settings);
        let projector = cameras.projector(&mirrors).expect("it was built for the scene");
        let mut random = Stream::new(45);
        let mut errors = Vec::new();
        for _ in 0..2000 {
            let point = between(&mut random, scene.bounds.min.as_dvec3(), scene.bounds.max.as_dvec3());
            let point = point.as_vec3().as_dvec3();
            for one in seen(&projector, point) {
                let bounces = &cameras.paths()[one.path as usize].bounces;
                if bounces.len() < 2 {
                    continue;
                }
                let (mut at, mut direction) = (BETWEEN_BALLS.as_dvec3(), one.direction.as_dvec3());
                let hit = bounces.iter().try_for_each(|bounce| {
                    let ball = ball(bounce.object);
                    at = ball.hit(at, direction)?;
                    direction = mirrored(direction, ball.normal(at));
                    Some(())
                });
                // Beside the silhouette of one ball in the other the ray may just miss it.
                errors.push(hit.map_or(f64::INFINITY, |()| {
                    let relative = point - at;
                    let miss = relative - direction * relative.dot(direction);
                    (one.direction_change.as_dmat3() * miss).length()
                }));
            }
        }
        let errors = sorted(errors);
        let [p50, p95] = [0.5, 0.95].map(|share| quantile(&errors, share));
        assert!(errors.len() > 1000, "{}", errors.len());
        assert!(p50 <= pixels(&settings, most_p50_px) && p95 <= pixels(&settings, most_p95_px), "{p50} {p95}");
    }
}

#[test]
fn paths_begin_at_the_eye_and_end_at_their_points() {
    let scene = scene("two_spheres?surface=analytic&tess=8");
    let mirrors = PanoramicMirrors::new(&scene);
    let objects = scene.specular_objects();
    let all = cameras(&mirrors, BETWEEN_BALLS, &settings(2));
    let left = PanoramaSettings { first: Some(vec![objects[0]]), ..settings(2) };
    let left = cameras(&mirrors, BETWEEN_BALLS, &left);
    let begins = |cameras: &PanoramicCameras| {
        let paths = cameras.paths().iter().filter(|path| path.bounces[0].object == objects[0]);
        paths.cloned().collect::<Vec<_>>()
    };
    assert!(left.paths().len() < all.paths().len());
    assert_eq!((left.paths(), begins(&left)), (&begins(&all)[..], begins(&all)));
    let mapped = PanoramaSettings { environment_mapped: vec![objects[1]], ..settings(2) };
    let mapped = cameras(&mirrors, BETWEEN_BALLS, &mapped);
    assert!(mapped.paths().iter().all(|path| path.bounces.len() == 1 && path.bounces[0].object == objects[0]));
    // Paths that both have appear alike.
    let point = DVec3::new(0.0, 2.5, 2.0);
    let [all, left] = [&all, &left].map(|cameras| {
        let projector = cameras.projector(&mirrors).expect("it was built for the scene");
        let begins = |one: &PanoramicProjection| cameras.paths()[one.path as usize].bounces[0].object == objects[0];
        let found = seen(&projector, point).into_iter().filter(begins);
        found.map(|one| PanoramicProjection { path: 0, ..one }).collect::<Vec<_>>()
    });
    assert!(!left.is_empty());
    assert_eq!(all, left);
}

#[test]
fn faces_without_mirrors_are_not_sampled() {
    let scene = scene("sphere_room?surface=analytic&tess=8");
    let mirrors = PanoramicMirrors::new(&scene);
    let far = cameras(&mirrors, Vec3::new(0.1, 1.4, 3.5), &settings(1));
    assert_eq!(far.report().counts["faces"], 1);
    let within = cameras(&mirrors, BALL.center.as_vec3(), &settings(1));
    assert_eq!(within.report().counts["faces"], 6);
    assert!(far.report().counts["rays_traced"] < within.report().counts["rays_traced"] / 6);
}

#[test]
fn odd_places_and_settings_are_survived_or_refused() {
    let room = scene("sphere_room?surface=analytic&tess=8");
    let mirrors = PanoramicMirrors::new(&room);
    let small = PanoramaSettings { size_px: 24, order: 2, ..PanoramaSettings::default() };
    let top = BALL.center.as_vec3() + Vec3::Y * 0.8;
    let odd_eyes = [BALL.center.as_vec3(), top, top * 1.000_001, Vec3::splat(1e30), Vec3::splat(f32::MAX), Vec3::ZERO];
    let odd_points = [Vec3::NAN, Vec3::INFINITY, Vec3::ZERO, top, Vec3::splat(f32::MAX), Vec3::new(1.0, 2.0, -1.0)];
    for eye in odd_eyes {
        for (camera, polish) in [(CameraKind::RayBundle, 4), (CameraKind::Pinhole, 0)] {
            let cameras = cameras(&mirrors, eye, &PanoramaSettings { camera, polish, ..small.clone() });
            let projector = cameras.projector(&mirrors).expect("it was built for the scene");
            let mut found = Vec::new();
            odd_points.iter().chain([&eye]).for_each(|&point| projector.project(point, &mut found));
            projector.project_on(u32::MAX, top, &mut found);
            for one in found {
                assert!(one.direction.is_normalized() && one.direction_change.is_finite() && one.path_length > 0.0);
            }
        }
    }
    // A single ray for a whole face is few, but no reason to fail.
    let coarsest = PanoramaSettings { size_px: 1, downsampling: 1, order: 1, ..small.clone() };
    let ray = cameras(&mirrors, BESIDE_BALL, &coarsest);
    assert_eq!(ray.paths().len(), 1);
    seen(&ray.projector(&mirrors).expect("as above"), DVec3::new(1.0, 2.0, -1.0));
    // Scenes without a reflector, and order 0, have no paths.
    let empty = SceneBuilder::new().build();
    let nothing = PanoramicMirrors::new(&empty);
    let none = PanoramaSettings { order: 0, ..small.clone() };
    for (mirrors, settings) in [(&nothing, &small), (&mirrors, &none)] {
        let cameras = cameras(mirrors, Vec3::ONE, settings);
        assert!(cameras.paths().is_empty() && cameras.report().counts["faces"] == 0);
        assert!(seen(&cameras.projector(mirrors).expect("as above"), DVec3::ONE).is_empty());
    }
    let of_nothing = cameras(&nothing, Vec3::ONE, &small);
    let misfit = of_nothing.projector(&mirrors).expect_err("it has more objects").to_string();
    assert!(misfit.contains("objects"), "{misfit}");
    let refused = |eye: Vec3, settings: PanoramaSettings| {
        PanoramicCameras::new(&mirrors, eye, &settings, &Silent).expect_err("it is wrong").to_string()
    };
    for eye in [Vec3::NAN, Vec3::new(0.0, f32::INFINITY, 0.0)] {
        assert!(refused(eye, small.clone()).contains("finite"));
    }
    for (wrong, what) in [
        (PanoramaSettings { size_px: 0, ..small.clone() }, "size_px = 0"),
        (PanoramaSettings { size_px: u32::MAX, ..small.clone() }, "size_px"),
        (PanoramaSettings { downsampling: 0, ..small.clone() }, "downsampling = 0"),
        (PanoramaSettings { downsampling: u32::MAX, ..small.clone() }, "downsampling"),
        (PanoramaSettings { accuracy_px: 3.0, ..small.clone() }, "accuracy_px = 3"),
        (PanoramaSettings { accuracy_px: f32::NAN, ..small.clone() }, "accuracy_px"),
        (PanoramaSettings { order: 100, ..small.clone() }, "order = 100"),
        (PanoramaSettings { polish: 1000, ..small.clone() }, "polish = 1000"),
        (PanoramaSettings { environment_mapped: vec![9999], ..small.clone() }, "object 9999"),
        (PanoramaSettings { first: Some(vec![0]), ..small.clone() }, "object 0"),
        (PanoramaSettings { bounds: Some(Aabb::EMPTY), ..small.clone() }, "bounds"),
        (PanoramaSettings { bounds: Some(Aabb { min: Vec3::NAN, max: Vec3::ONE }), ..small.clone() }, "bounds"),
    ] {
        let message = refused(BESIDE_BALL, wrong);
        assert!(message.contains(what), "{message}");
    }
}
