//! Tracers: edges, split triangles, moved scenes, lights and what is behind surfaces.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::{Light, Ray, Scene};
use catoptric_engine::light::tracer::{Tracer, TriangleTest};
use catoptric_engine::light::wide_hierarchy::{Treelet, meet};
use glam::{Vec2, Vec3};

#[test]
fn no_ray_slips_through_shared_edges() {
    // Rays aimed exactly at points of shared edges of a fan must meet at least one of its triangles.
    let mut random = Stream::new(7);
    for _ in 0..2000 {
        let mut point = || Vec3::new(random.next_between(-1.0, 1.0), random.next_between(-1.0, 1.0), 0.0);
        let (hub, rim) = (point() * 0.1, [Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::NEG_X * 2.0, Vec3::NEG_Y * 2.0]);
        let triangles = [0, 1, 2, 3].map(|i| [hub, rim[i], rim[(i + 1) % 4]]);
        let share = random.next_unit();
        let target = hub.lerp(rim[(random.next_unit() * 4.0) as usize], share);
        let origin = Vec3::new(random.next_between(-3.0, 3.0), random.next_between(-3.0, 3.0), 2.0);
        let ray = Ray { origin, direction: (target - origin).normalize() };
        assert!(triangles.iter().any(|triangle| {
            meet(triangle.map(|corner| corner.to_array()), [ray.origin.to_array(), ray.direction.to_array()]).inside
        }));
    }
}

#[test]
fn split_triangles_and_analytic_surfaces_keep_their_numbers() {
    use catoptric_core::scene::{Material, model::*};
    // A long thin diagonal triangle among small ones is split into several boxes.
    let mut primitive = Primitive {
        positions: vec![Vec3::splat(-9.0), Vec3::splat(9.0), Vec3::new(9.0, 9.0, 8.9)],
        triangles: vec![[0, 1, 2]],
        ..Primitive::default()
    };
    for k in 0..40u32 {
        let at = Vec3::new(20.0 + k as f32 * 0.1, 0.0, 0.0);
        primitive.positions.extend([at, at + Vec3::Y * 0.1, at + Vec3::Z * 0.1]);
        primitive.triangles.push([3 * k + 3, 3 * k + 4, 3 * k + 5]);
    }
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    model.nodes.push(Node { mesh: Some(0), ..Node::default() });
    for x in [-3.0, 3.0] {
        let surface = catoptric_core::surface::AnalyticSurface::Sphere { radius: 0.5 };
        let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
        model.nodes.push(Node { analytic, local: LocalTransform::at(Vec3::new(x, -2.0, 5.0)), ..Node::default() });
    }
    let scene = model.pose(&Default::default()).unwrap();
    let tracer = Tracer::build(&scene, |_| true);
    let places = tracer.place_count();
    assert!(places > 43, "nothing was split: {places}");
    for (x, object) in [(-3.0, 1), (3.0, 2)] {
        let ray = Ray { origin: Vec3::new(x, -2.0, 20.0), direction: Vec3::NEG_Z };
        match tracer.first_hit(&scene, &ray, 0.0) {
            Some(Hit::Surface { object: found, hit }) => assert!(found == object && hit.distance == 14.5),
            other => panic!("{other:?}"),
        }
    }
    for k in 0..40 {
        let origin = Vec3::new(20.0 + k as f32 * 0.1 - 0.05, 0.02, 0.02);
        match tracer.first_hit(&scene, &Ray { origin, direction: Vec3::X }, 0.0) {
            Some(Hit::Triangle { triangle, .. }) => assert_eq!(triangle, k + 1),
            other => panic!("{other:?}"),
        }
    }
}

/// A narrow floor, which is split into several boxes, and balls, exact ones and meshes, that are moved.
fn balls(shift: Vec3) -> Scene {
    use catoptric_core::scene::{Material, model::*};
    use catoptric_core::surface::{AnalyticSurface, sphere_mesh};
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    let floor = Primitive {
        positions: vec![Vec3::new(-9.0, -3.0, -9.0), Vec3::new(9.0, -1.0, 9.0), Vec3::new(9.0, -1.0, 6.0)],
        triangles: vec![[0, 2, 1]],
        ..Primitive::default()
    };
    let ball = sphere_mesh(0.7, 12, 24);
    let ball = Primitive {
        positions: ball.positions,
        normals: ball.normals,
        triangles: ball.triangles,
        ..Primitive::default()
    };
    for (mesh, primitive) in [floor, ball].into_iter().enumerate() {
        model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
        let local = LocalTransform::at(shift * mesh as f32);
        model.nodes.push(Node { mesh: Some(mesh), local, ..Node::default() });
    }
    for x in [-2.0, 2.0] {
        let surface = AnalyticSurface::Sphere { radius: 0.6 };
        let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
        let local = LocalTransform::at(Vec3::new(x, 0.0, 0.5) + shift * x);
        model.nodes.push(Node { analytic, local, ..Node::default() });
    }
    model.pose(&Default::default()).expect("the model is valid")
}

#[test]
fn refitted_and_filtered_tracers_meet_what_new_ones_meet() {
    let (before, after) = (balls(Vec3::ZERO), balls(Vec3::new(0.3, 0.4, -0.5)));
    let new = Tracer::build(&after, |_| true);
    let refitted = Tracer::build(&before, |_| true).refitted(&after).expect("no triangle was flat");
    let places = new.place_count();
    assert!(places > after.objects[1].triangles.len() + 3, "the floor was not split: {places}");
    let listed = [false, true, false, true];
    let of_listed = Tracer::build(&after, |object| listed[object as usize]);
    let mut random = Stream::new(5);
    let mut met = [0; 4];
    for _ in 0..3000 {
        let mut point = |size: f32| Vec3::from_array([0, 1, 2].map(|_| random.next_between(-size, size)));
        let origin = point(4.0) + Vec3::Y * 4.0;
        let ray = Ray { origin, direction: (point(2.0) - origin).normalize() };
        let place = |hit: Option<Hit>| hit.map(|hit| (hit.object(&after), hit.distance()));
        let found = place(new.first_hit(&after, &ray, 0.0));
        assert_eq!(found, place(refitted.first_hit(&after, &ray, 0.0)), "{ray:?}");
        let among = place(new.first_hit_of(&after, &ray, 0.0, &listed));
        assert_eq!(among, place(of_listed.first_hit(&after, &ray, 0.0)), "{ray:?}");
        if let Some((object, _)) = found {
            met[object as usize] += 1;
        }
    }
    assert!(met.iter().all(|count| *count > 30), "{met:?}");
}

#[test]
fn barycentrics_and_distance_give_the_same_point() {
    let corners = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(3.0, 0.5, 0.0), Vec3::new(-0.5, 2.0, 0.2)];
    let inside = corners[0] * 0.5 + corners[1] * 0.2 + corners[2] * 0.3;
    let origin = Vec3::new(1.0, 1.0, 5.0);
    let ray = Ray { origin, direction: (inside - origin).normalize() };
    let met = meet(corners.map(|corner| corner.to_array()), [ray.origin.to_array(), ray.direction.to_array()]);
    assert!(met.inside && (Vec2::from_array(met.weights) - Vec2::new(0.2, 0.3)).length() < 1e-5);
    assert!((origin + ray.direction * met.distance - inside).length() < 1e-5);
}

#[test]
fn points_near_each_other_see_the_lights_that_each_sees_alone() {
    use catoptric_core::scene::LightKind;
    use catoptric_scenes::builtin;
    let scene = builtin::parse("workshop?tess=16").unwrap().pose(&Default::default()).unwrap();
    let tracer = Tracer::build(&scene, |_| true);
    let mut random = Stream::new(17);
    let (mut treelet, mut counts) = (Treelet::default(), [0, 0]);
    let range = f32::INFINITY;
    for cluster in 0..400 {
        let mut point = |size: f32| {
            let step = Vec3::new(random.next_unit(), random.next_unit(), random.next_unit()) - 0.5;
            scene.bounds.size() * step * size
        };
        let middle = scene.bounds.center() + point(0.8);
        // Some lie among the points.
        let size = [0.01, 0.05, 0.5][cluster % 3];
        let position = middle + point([size, 0.5, 1.0][cluster / 3 % 3]);
        let direction = (middle - position).normalize();
        let kind = if cluster % 2 == 0 { LightKind::Directional } else { LightKind::Point { range } };
        let light = Light { kind, intensity: Vec3::ONE, position, direction };
        let points: Vec<Vec3> = (0..24).map(|_| middle + point(size)).collect();
        let mut found = [Vec3::ONE; 24];
        tracer.find_passing(&scene, (&light, &points), &[], &mut treelet, &mut found);
        for (point, found) in points.iter().zip(found) {
            let (ray, distance) = light.way_from(*point).unwrap();
            let is_hidden = tracer.is_blocked(&scene, &ray, distance);
            assert_eq!(found, if is_hidden { Vec3::ZERO } else { Vec3::ONE }, "{light:?} from {point}");
            counts[usize::from(is_hidden)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
}

#[test]
fn surfaces_one_behind_the_other_are_those_of_all_triangles() {
    use catoptric_scenes::builtin;
    let scene = builtin::parse("teapot").unwrap().pose(&Default::default()).unwrap();
    let tracer = Tracer::build(&scene, |_| true);
    let mut random = Stream::new(31);
    let size = scene.bounds.diagonal();
    let mut hits = 0;
    for _ in 0..150 {
        let mut point = || Vec3::new(random.next_unit(), random.next_unit(), random.next_unit()) - 0.5;
        let target = scene.bounds.center() + point() * size * 0.2;
        let origin = scene.bounds.center() + point() * size;
        let ray = Ray { origin, direction: (target - origin).normalize() };
        let mut near = 0.0;
        for _ in 0..12 {
            let found = tracer.first_hit(&scene, &ray, near);
            let all = (0..scene.triangles.len() as u32).filter_map(|triangle| {
                TriangleTest::new(&scene, triangle, false).distance(&scene, &ray, near, f32::INFINITY)
            });
            let nearest = all.reduce(f32::min);
            assert_eq!(found.as_ref().map(Hit::distance), nearest, "{ray:?} beyond {near}");
            let Some(distance) = nearest else { break };
            near = distance * 1.0001 + 1e-5;
            hits += 1;
        }
    }
    assert!(hits > 300, "{hits}");
}
