//! Exact specular projection: time a Newton step and a solved vertex, on exact surfaces and on a mesh.

use catoptric::math::random::Stream;
use catoptric::optics::path::bundle::{Bounce, BounceKind, Eye};
use catoptric::optics::path::manifold::{ManifoldVertex, SpecularSurfaces};
use catoptric::optics::path::specular_solver::{PathSites, solve};
use catoptric::scene::model::{AnalyticAsset, LocalTransform, MeshAsset, Node, Primitive};
use catoptric::scene::{Material, Model, PoseOptions, Scene};
use catoptric::surface::AnalyticSurface;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use std::hint::black_box;

const RADIUS: f32 = 1.0;

/// An exact mirror ball (object 0), an exact glass ball (1) and a mirror ball of triangles (2), side by side.
fn scene() -> Scene {
    let materials = vec![Material::mirror("mirror", Vec3::ONE), Material::glass("glass", 1.5)];
    let mut model = Model { materials, ..Model::default() };
    let surface = AnalyticSurface::Sphere { radius: RADIUS.into() };
    for (material, x) in [(0, 0.0), (1, 4.0)] {
        let analytic = Some(AnalyticAsset { surface: surface.clone(), material, inside: false });
        model.nodes.push(Node { analytic, local: LocalTransform::at(Vec3::X * x), ..Node::default() });
    }
    let mesh = surface.tessellate();
    let primitive = Primitive {
        positions: mesh.positions,
        normals: mesh.normals,
        triangles: mesh.triangles,
        ..Primitive::default()
    };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    model.nodes.push(Node { mesh: Some(0), local: LocalTransform::at(Vec3::X * 8.0), ..Node::default() });
    model.pose(&PoseOptions::default()).expect("a valid scene")
}

/// `count` paths with starts beside them, `error` radii off.
fn problems(
    surfaces: &SpecularSurfaces<'_>,
    scene: &Scene,
    object: u32,
    count: usize,
    error: f64,
) -> Vec<(DVec3, PathSites)> {
    let mut random = Stream::new(5);
    let center = DVec3::X * (4.0 * object as f64);
    let mut next = move || {
        let mut part = || random.next_between(-1.0, 1.0) as f64;
        DVec3::new(part(), part(), part())
    };
    let kind = if object == 1 { BounceKind::Transmit } else { BounceKind::Reflect };
    let mut found = Vec::new();
    while found.len() < count {
        let normal = (DVec3::Z * 1.5 + next()).normalize();
        let to_eye = (eye_of(object) - center - normal).normalize();
        let out = match kind {
            BounceKind::Reflect => normal * (2.0 * to_eye.dot(normal)) - to_eye,
            BounceKind::Transmit => {
                let cosine = to_eye.dot(normal);
                let bent = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
                normal * (cosine / 1.5 - bent) - to_eye / 1.5
            }
        };
        if to_eye.dot(normal) < 0.2 {
            continue;
        }
        let point = center + normal + out * 1.2;
        let beside = (normal + next() * error).normalize();
        let site = match scene.objects[object as usize].surface {
            Some(_) => ManifoldVertex::on_surface(center + beside),
            None => {
                let near = |triangle: &u32| {
                    let [a, b, c] = scene.triangles[*triangle as usize].map(|v| scene.positions[v as usize].as_dvec3());
                    ((a + b + c) / 3.0 - center).distance_squared(beside)
                };
                let triangles = scene.objects[object as usize].triangles.clone();
                let nearest = triangles.min_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(0);
                ManifoldVertex { position: DVec3::ZERO, triangle: nearest, barycentrics: [0.3, 0.3] }
            }
        };
        let bounce = Bounce { object, kind };
        let Some(path) = PathSites::new(&[(bounce, site)]) else { continue };
        if solve(surfaces, &Eye::Point(eye_of(object)), point, &path, 30, 1e-10).is_some_and(|s| s.converged) {
            found.push((point, path));
        }
    }
    found
}

fn eye_of(object: u32) -> DVec3 {
    DVec3::new(4.0 * object as f64 + 0.3, 0.5, 4.0)
}

fn solver(criterion: &mut Criterion) {
    let scene = scene();
    let surfaces = SpecularSurfaces::new(&scene);
    let mut group = criterion.benchmark_group("specular_solver");
    for (object, name) in [(0, "mirror_sphere"), (1, "into_glass_sphere"), (2, "mirror_mesh")] {
        for (error, far) in [(0.02, "near"), (0.2, "far")] {
            let problems = problems(&surfaces, &scene, object, 256, error);
            let eye = Eye::Point(eye_of(object));
            let run = |most: u32| {
                let mut steps = 0;
                for (point, path) in black_box(&problems) {
                    if let Some(found) = solve(&surfaces, &eye, *point, path, most, 1e-10) {
                        steps += u64::from(found.steps);
                    }
                }
                steps
            };
            group.throughput(Throughput::Elements(problems.len() as u64));
            group.bench_function(format!("{name}/{far}/vertices"), |bencher| bencher.iter(|| black_box(run(30))));
            group.throughput(Throughput::Elements(run(30)));
            group.bench_function(format!("{name}/{far}/steps"), |bencher| bencher.iter(|| black_box(run(30))));
        }
    }
    group.finish();
}

criterion_group!(benches, solver);
criterion_main!(benches);
