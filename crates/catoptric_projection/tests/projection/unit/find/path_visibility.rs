//! Paths that reflectors hide.

use catoptric_core::math::random::Stream;
use catoptric_core::scene::model::*;
use catoptric_core::scene::{Material, Ray, Scene};
use catoptric_core::surface::AnalyticSurface;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_projection::find::path_visibility::PathVisibility;
use glam::{DVec3, Vec3};

/// Mirror spheres with their centres and radii.
fn spheres(places: &[(Vec3, f32)], material: Material) -> Scene {
    let mut model = Model { materials: vec![material], ..Model::default() };
    for (center, radius) in places {
        let surface = AnalyticSurface::Sphere { radius: f64::from(*radius) };
        let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
        model.nodes.push(Node { analytic, local: LocalTransform::at(*center), ..Node::default() });
    }
    model.pose(&Default::default()).expect("a scene")
}

fn mirror() -> Material {
    Material::mirror("", Vec3::ONE)
}

fn reflection() -> SpecularPath {
    SpecularPath { bounces: vec![Bounce { object: 0, kind: BounceKind::Reflect }] }
}

fn between(random: &mut Stream, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(random.next_unit())
}

fn direction(random: &mut Stream) -> DVec3 {
    loop {
        let point = DVec3::from([0; 3].map(|_| between(random, -1.0, 1.0)));
        if (0.01..1.0).contains(&point.length_squared()) {
            return point.normalize();
        }
    }
}

fn mirrored(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

#[test]
fn a_sphere_hides_what_is_reflected_on_its_far_side_and_nothing_else() {
    let mut random = Stream::new(11);
    let mut counts = [0; 2];
    for case in 0..8 {
        let center = DVec3::from([0; 3].map(|_| between(&mut random, -20.0, 20.0))).as_vec3();
        let radius = between(&mut random, 0.05, 3.0) as f32;
        let scene = spheres(&[(center, radius)], mirror());
        let visibility = PathVisibility::of_scene(&scene);
        let (center, radius) = (center.as_dvec3(), f64::from(radius));
        for _ in 0..1000 {
            let normal = direction(&mut random);
            let bounce = center + normal * radius;
            // A view ray of a given cosine, grazing ones more often than by chance; eyes on both sides.
            let tangent = normal.cross(direction(&mut random)).normalize();
            let cosine = between(&mut random, 0.0, 1.0).powi(4).max(1e-3);
            let cosine = if random.next_unit() < 0.5 { -cosine } else { cosine };
            let back = normal * cosine + tangent * (1.0 - cosine * cosine).sqrt();
            let eye = bounce + back * (radius * between(&mut random, 0.02, 10.0));
            let on = -mirrored(back, normal);
            let point = bounce + on * (radius * between(&mut random, 0.02, 10.0));
            // Outside all points are seen; inside only points nearer than the sphere's other wall.
            let chord = 2.0 * radius * cosine.abs();
            let inside = |end: DVec3| end.distance(bounce) < chord;
            if cosine < 0.0 && [eye, point].iter().any(|end| (end.distance(bounce) / chord - 1.0).abs() < 1e-3) {
                continue; // on the wall
            }
            let expected = cosine > 0.0 || (inside(eye) && inside(point));
            let found = visibility.is_visible(eye, point, &reflection(), &[bounce]);
            assert_eq!(found, expected, "case {case}: cosine {cosine}, radius {radius}, centre {center}");
            counts[usize::from(expected)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 2000), "{counts:?}");
}

#[test]
fn other_reflectors_block_exactly_where_a_segment_meets_them() {
    let mut random = Stream::new(12);
    let mut counts = [0; 2];
    for _ in 0..10 {
        let blocker = (direction(&mut random) * between(&mut random, 2.0, 4.0)).as_vec3();
        let scene = spheres(&[(Vec3::ZERO, 1.0), (blocker, 0.8)], mirror());
        let visibility = PathVisibility::of_scene(&scene);
        for _ in 0..300 {
            // Bounces on the side of the blocker.
            let normal = (blocker.as_dvec3().normalize() + direction(&mut random) * 0.8).normalize();
            let back = (normal + direction(&mut random) * 0.9).normalize();
            let (eye, point) = (normal + back * 5.0, normal + -mirrored(back, normal) * 4.0);
            let distance = |end: DVec3| {
                let (along, relative) = (end - normal, blocker.as_dvec3() - normal);
                let share = (along.dot(relative) / along.length_squared()).clamp(0.0, 1.0);
                (relative - along * share).length()
            };
            let nearest = distance(eye).min(distance(point)) - f64::from(0.8f32);
            if nearest.abs() < 1e-5 {
                continue;
            }
            let found = visibility.is_visible(eye, point, &reflection(), &[normal]);
            assert_eq!(found, nearest > 0.0, "{nearest}");
            counts[usize::from(found)] += 1;
        }
    }
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
}

#[test]
fn a_ray_through_a_ball_of_glass_is_free_and_without_its_bounces_is_not() {
    let scene = spheres(&[(Vec3::ZERO, 1.0)], Material::glass("", 1.5));
    let visibility = PathVisibility::of_scene(&scene);
    let mut random = Stream::new(13);
    for _ in 0..1000 {
        // Snell at entry and exit of a chord; both bends are equal.
        let normal = direction(&mut random);
        let tangent = normal.cross(direction(&mut random)).normalize();
        let sine = between(&mut random, 0.0, 0.999);
        let back = normal * (1.0 - sine * sine).sqrt() + tangent * sine;
        let inner = -normal * (1.0 - sine * sine / 2.25).sqrt() - tangent * (sine / 1.5);
        let exit = normal + inner * (-2.0 * inner.dot(normal));
        let outer = exit * (1.0 - sine * sine).sqrt() + (inner - exit * inner.dot(exit)).normalize_or_zero() * sine;
        let (eye, point) = (normal + back * 3.0, exit + outer * 2.0);
        let through = Bounce { object: 0, kind: BounceKind::Transmit };
        let path = SpecularPath { bounces: vec![through, through] };
        assert!(visibility.is_visible(eye, point, &path, &[normal, exit]), "sine {sine}");
        assert!(!visibility.is_visible(normal * 3.0, -normal * 2.0, &SpecularPath::default(), &[]));
    }
}

#[test]
fn eye_and_point_may_lie_on_surfaces() {
    let scene = spheres(&[(Vec3::ZERO, 1.0), (Vec3::new(4.0, 0.0, 0.0), 1.0)], mirror());
    let visibility = PathVisibility::of_scene(&scene);
    let on_other = DVec3::new(3.0, 0.0, 0.0);
    assert!(visibility.is_visible(on_other, on_other, &reflection(), &[DVec3::X]));
    assert!(!visibility.is_visible(DVec3::new(5.0, 0.0, 0.0), on_other, &reflection(), &[DVec3::X]));
    for broken in [DVec3::NAN, DVec3::INFINITY, DVec3::splat(1e300)] {
        visibility.is_visible(broken, on_other, &reflection(), &[DVec3::X]);
        visibility.is_visible(on_other, broken, &reflection(), &[broken]);
    }
}

#[test]
fn meshes_do_not_block_themselves_where_they_are_flat_or_convex() {
    // A sphere of triangles: the bounce of a view ray where the tracer meets it, on with the flat normal.
    let mesh = catoptric_core::surface::sphere_mesh(1.0, 12, 24);
    let primitive = Primitive {
        positions: mesh.positions,
        normals: mesh.normals,
        triangles: mesh.triangles,
        ..Primitive::default()
    };
    let mut model = Model { materials: vec![mirror()], ..Model::default() };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    model.nodes.push(Node { mesh: Some(0), ..Node::default() });
    let scene = model.pose(&Default::default()).unwrap();
    let visibility = PathVisibility::of_scene(&scene);
    let tracer = Tracer::build(&scene, |object| scene.role_of(object).is_specular());
    let mut random = Stream::new(14);
    let mut hits = 0;
    for _ in 0..3000 {
        let eye = direction(&mut random) * between(&mut random, 1.2, 6.0);
        let target = direction(&mut random);
        let ray = Ray { origin: eye.as_vec3(), direction: (target - eye).normalize().as_vec3() };
        let Some(hit) = tracer.first_hit(&scene, &ray, 0.0) else { continue };
        let at = tracer.encounter(&scene, &ray, &hit, None).point;
        let (bounce, normal) = (at.position.as_dvec3(), at.geometric_normal.as_dvec3());
        let back = (eye - bounce).normalize();
        let point = bounce - mirrored(back, normal) * between(&mut random, 0.1, 5.0);
        assert!(visibility.is_visible(eye, point, &reflection(), &[bounce]));
        assert!(!visibility.is_visible(-eye, point, &reflection(), &[bounce]), "seen through the mesh");
        hits += 1;
    }
    assert!(hits > 1000);
}
