//! Reflection points and images that are found in pictures of reflectors.

use catoptric_core::math::random::Stream;
use catoptric_core::progress::Silent;
use catoptric_core::scene::{Scene, View};
use catoptric_engine::method::projector::PathBeginnings;
use catoptric_projection::parts::{
    Locator, PathLimits, PathTree, ReflectionPoint, ReflectionPoints, Reflector, ReflectorImage, ReflectorMesh,
    ReflectorSearch,
};
use catoptric_projection::reflector_search::Search;
use catoptric_scenes::builtin;
use glam::Vec3;
use std::sync::Arc;

/// A scene with its reflectors and the search in them.
struct Set {
    scene: Scene,
    view: View,
    meshes: Vec<ReflectorMesh>,
    levels: PathTree<ReflectorSearch>,
}

impl Set {
    fn new(name: &str, order: u32, size: u32, from_eye: bool) -> Self {
        let scene = builtin::parse(name).expect("a built-in scene").pose(&Default::default()).expect("a scene");
        let view = scene.default_view(640, 480);
        let meshes: Vec<_> =
            scene.specular_objects().iter().map(|object| ReflectorMesh::new(&scene, *object, 0.125)).collect();
        let make = |reflector: &Reflector<'_>| {
            let image = match reflector.view {
                Some(view) if from_eye => ReflectorImage::from_eye(reflector.mesh, view, size)?,
                _ => ReflectorImage::around(reflector.mesh, size / 2),
            };
            ReflectorSearch::new(reflector, Arc::new(image), Search::Cells)
        };
        let limits = PathLimits { order, work: u64::MAX, without: &PathBeginnings::default() };
        let levels = PathTree::build(&scene, &meshes, &view, limits, 64, make, &Silent).expect("nothing is cancelled");
        Self { scene, view, meshes, levels }
    }

    /// The reflection points of a point, with the number of their path, and the side of their ray set.
    fn reflection_points(&self, point: Vec3) -> Vec<(usize, f32, ReflectionPoint)> {
        let mut reflection_points = Vec::new();
        for (path, level) in self.levels.levels.iter().enumerate() {
            for ray_set in &level.ray_sets {
                let view = (self.levels.paths[path].bounces.len() == 1).then_some(&self.view);
                let reflector = Reflector {
                    index: Some(level.mesh),
                    mesh: &self.meshes[level.mesh as usize],
                    rays: &ray_set.rays,
                    view,
                };
                let mut found = ReflectionPoints::default();
                ray_set.locator.locate(&reflector, &[point], &mut found);
                reflection_points
                    .extend(found.all().iter().map(|reflection_point| (path, ray_set.rays.side, *reflection_point)));
            }
        }
        reflection_points
    }

    /// The first reflector and its first ray set.
    fn first(&self) -> (&ReflectorSearch, Reflector<'_>) {
        let (mesh, ray_set) = (&self.meshes[0], &self.levels.levels[0].ray_sets[0]);
        (&ray_set.locator, Reflector { index: Some(0), mesh, rays: &ray_set.rays, view: Some(&self.view) })
    }

    fn random_points(&self, count: usize) -> Vec<Vec3> {
        let (mut random, bounds) = (Stream::new(7), self.scene.bounds);
        let mut within = || Vec3::from([0, 1, 2].map(|k| random.next_between(bounds.min[k], bounds.max[k])));
        (0..count).map(|_| within()).collect()
    }
}

/// The distance of the half vector from a normal.
fn miss(reflection_point: &ReflectionPoint, normal: Vec3, point: Vec3) -> f32 {
    let [eye, to_point] = [reflection_point.origin, point].map(|end| (end - reflection_point.position).normalize());
    (eye + to_point).normalize().distance(normal)
}

fn assert_reflection_points_on_a_sphere_obey_the_mirror_law(from_eye: bool) {
    let set = Set::new("sphere_room", 1, 200, from_eye);
    let (center, radius) = (set.meshes[0].center, set.meshes[0].radius);
    let mut tested = 0;
    for point in set.random_points(2000) {
        if point.distance(center) < 1.1 * radius {
            continue;
        }
        let reflection_points: Vec<_> = set
            .reflection_points(point)
            .into_iter()
            .filter(|(.., reflection_point)| !reflection_point.beyond)
            .collect();
        assert!(reflection_points.len() <= 1, "a convex mirror shows {point} {} times", reflection_points.len());
        for (_, _, reflection_point) in reflection_points {
            let normal = (reflection_point.position - center).normalize();
            // A texel at the middle turns the normal by a hundredth; at the rim by more.
            let slant = normal.dot((reflection_point.origin - reflection_point.position).normalize());
            assert!(
                reflection_point.position.distance(center) / radius > 0.995,
                "{reflection_point:?} is off the sphere"
            );
            let miss = miss(&reflection_point, normal, point);
            assert!(miss < 0.002 / slant.max(0.05), "{miss} for {point}, {reflection_point:?}");
            tested += 1;
        }
    }
    assert!(tested > 500, "{tested}");
}

#[test]
fn feet_on_a_sphere_seen_from_the_eye_obey_the_mirror_law() {
    assert_reflection_points_on_a_sphere_obey_the_mirror_law(true);
}

#[test]
fn feet_on_a_sphere_in_cube_maps_obey_the_mirror_law() {
    assert_reflection_points_on_a_sphere_obey_the_mirror_law(false);
}

#[test]
fn changes_of_reflection_points_are_those_of_differences() {
    let set = Set::new("sphere_room", 1, 400, true);
    let (center, radius) = (set.meshes[0].center, set.meshes[0].radius);
    let mut tested = 0;
    for point in set.random_points(500) {
        let [(_, _, reflection_point)] = set.reflection_points(point)[..] else { continue };
        let slant = reflection_point.normal.dot((reflection_point.origin - reflection_point.position).normalize());
        if reflection_point.beyond || slant < 0.4 || point.distance(center) < 1.5 * radius {
            continue;
        }
        // Over many texels, so that their unevenness averages out.
        let step = 0.05 * point.distance(center);
        for axis in Vec3::AXES {
            let ends = [point + axis * step, point - axis * step].map(|point| set.reflection_points(point));
            let ([(_, _, after)], [(_, _, before)]) = (&ends[0][..], &ends[1][..]) else { continue };
            let difference = (after.position - before.position) / (2.0 * step);
            let turned = (after.normal - before.normal) / (2.0 * step);
            let (change, turn) = (reflection_point.position_change * axis, reflection_point.normal_change * axis);
            let scale = radius / point.distance(center);
            assert!(difference.distance(change) < 0.05 * scale, "{difference}, not {change}");
            assert!(turned.distance(turn) < 0.05 * scale / radius, "{turned}, not {turn}");
            tested += 1;
        }
    }
    assert!(tested > 100, "{tested}");
}

#[test]
fn a_vase_shows_points_several_times() {
    for from_eye in [true, false] {
        let set = Set::new("vase", 1, 400, from_eye);
        let (mut several, mut tested, mut rough) = (0, 0, 0);
        for point in set.random_points(2000) {
            let reflection_points: Vec<_> = set
                .reflection_points(point)
                .into_iter()
                .filter(|(.., reflection_point)| !reflection_point.beyond)
                .collect();
            for (_, _, reflection_point) in &reflection_points {
                let miss = miss(reflection_point, reflection_point.normal, point);
                // Cells across an edge of the vase may be this wrong, but are few.
                let most = if from_eye { 0.0014 } else { 0.023 };
                assert!(miss < most, "{miss} for {point}");
                let slant =
                    reflection_point.normal.dot((reflection_point.origin - reflection_point.position).normalize());
                rough += usize::from(miss > 0.005 / slant.clamp(0.05, 1.0));
                tested += 1;
            }
            several += usize::from(reflection_points.len() > 1);
        }
        assert!(several > 20, "{several}");
        assert!(rough * 100 < tested, "{rough} of {tested}");
    }
}

#[test]
fn second_bounces_obey_the_mirror_law() {
    let set = Set::new("two_spheres", 2, 200, true);
    let mut tested = 0;
    for point in set.random_points(500) {
        for (path, _, reflection_point) in set.reflection_points(point) {
            if set.levels.paths[path].bounces.len() == 2 && !reflection_point.beyond {
                let miss = miss(&reflection_point, reflection_point.normal, point);
                assert!(miss < 0.0025, "{miss} for {point}, {reflection_point:?}");
                tested += 1;
            }
        }
    }
    assert!(tested > 50, "{tested}");
}

#[test]
fn rays_through_glass_obey_snells_law() {
    let set = Set::new("glass_sphere", 1, 200, true);
    let refracts = |path: usize| set.levels.paths[path].transmits();
    let (center, radius) = (set.meshes[0].center, set.meshes[0].radius);
    let (mut random, mut tested) = (Stream::new(9), 0);
    for _ in 0..500 {
        let point = center + Vec3::from([0; 3].map(|_| random.next_between(-0.5, 0.5))) * radius;
        for (path, _, reflection_point) in set.reflection_points(point) {
            if !refracts(path) || reflection_point.beyond {
                continue;
            }
            let incoming = (reflection_point.position - reflection_point.origin).normalize();
            let expected = catoptric_engine::optics::refract(incoming, reflection_point.normal, 1.0 / 1.5).unwrap();
            let outgoing = (point - reflection_point.position).normalize();
            assert!(outgoing.distance(expected) < 0.02, "{outgoing}, not {expected}");
            tested += 1;
        }
    }
    assert!(tested > 200, "{tested}");
}

#[test]
fn what_is_not_finite_appears_nowhere() {
    let set = Set::new("sphere_room", 1, 50, true);
    let on = set.meshes[0].positions[0];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(set.reflection_points(Vec3::new(bad, 0.0, 0.0)).is_empty());
        assert!(set.reflection_points(Vec3::splat(bad)).is_empty());
    }
    // Points on the reflector, in its middle, at the eye, and further than squares of distances can hold.
    for point in [on, set.meshes[0].center, set.view.eye(), Vec3::splat(1e30), Vec3::splat(f32::MAX)] {
        for (_, _, reflection_point) in set.reflection_points(point) {
            assert!(
                reflection_point.position.is_finite() && reflection_point.normal.is_finite(),
                "{point}: {reflection_point:?}"
            );
        }
    }
}

/// Images and reflection points of random points in a scene's first ray set, with the settings of [`Set::new`].
fn assert_images_are_those_of_reflection_points(name: &str, from_eye: bool) {
    let set = Set::new(name, 1, 200, from_eye);
    let (points, mesh) = (set.random_points(3000), &set.meshes[0]);
    let (search, reflector) = set.first();
    let mut images = vec![Vec3::ZERO; points.len()];
    search.mirror_images(&reflector, &points, &mut images);
    let mut tested = 0;
    for (point, image) in points.iter().zip(&images) {
        let mut found = ReflectionPoints::default();
        search.locate(&reflector, &[*point], &mut found);
        let reflection_point = found.all().first().copied();
        assert_eq!(reflection_point.is_some(), image.is_finite(), "{point}: {reflection_point:?}, but {image}");
        let Some(reflection_point) = reflection_point else { continue };
        let expected =
            *point - reflection_point.normal * (2.0 * reflection_point.normal.dot(*point - reflection_point.position));
        // Both sides' bilinear forms answer where cells meet.
        let size = mesh.radius + point.distance(reflection_point.position);
        let slant =
            reflection_point.normal.dot((reflection_point.origin - reflection_point.position).normalize()).max(0.02);
        assert!(
            image.distance(expected) < 2e-3 / slant * size,
            "{point}: {image}, not {expected}, {reflection_point:?}"
        );
        tested += 1;
    }
    assert!(tested > 1000, "{tested}");
}

#[test]
fn images_of_many_points_are_those_of_their_reflection_points() {
    for (name, from_eye) in [("sphere_room", true), ("sphere_room", false), ("ellipsoid", true), ("vase", true)] {
        assert_images_are_those_of_reflection_points(name, from_eye);
    }
}

#[test]
fn an_image_depends_on_its_own_point_alone() {
    for name in ["sphere_room", "vase"] {
        let set = Set::new(name, 1, 100, true);
        let points = set.random_points(500);
        let (search, reflector) = set.first();
        let bits = |images: &[Vec3]| images.iter().map(|image| image.to_array().map(f32::to_bits)).collect::<Vec<_>>();
        let mut all = vec![Vec3::ZERO; points.len()];
        search.mirror_images(&reflector, &points, &mut all);
        for size in [1, 3, 17] {
            let mut parts = vec![Vec3::ZERO; points.len()];
            for (points, images) in points.chunks(size).zip(parts.chunks_mut(size)) {
                search.mirror_images(&reflector, points, images);
            }
            assert_eq!(bits(&parts), bits(&all), "{name}, {size} at once");
        }
    }
}

/// Prints its measurements and asserts nothing.
#[test]
#[ignore = "a measurement: run it with --release -- --ignored --nocapture"]
#[allow(clippy::print_stdout, reason = "a measurement is there to be read")]
fn search_time() {
    for (name, from_eye) in [("sphere_room", true), ("sphere_room", false), ("vase", true), ("torus", true)] {
        let set = Set::new(name, 1, 400, from_eye);
        let points = set.random_points(200_000);
        let (search, reflector) = set.first();
        let mut found = ReflectionPoints::default();
        let start = std::time::Instant::now();
        search.locate(&reflector, &points, &mut found);
        let each = start.elapsed().as_secs_f64() * 1e9 / points.len() as f64;
        let mut images = vec![Vec3::ZERO; points.len()];
        let start = std::time::Instant::now();
        search.mirror_images(&reflector, &points, &mut images);
        let image = start.elapsed().as_secs_f64() * 1e9 / points.len() as f64;
        println!(
            "{name}, from the eye: {from_eye}: {each:.0} ns a point and core, {} reflection points; \
                {image:.0} ns an image",
            found.all().len()
        );
    }
}
