//! Virtual objects without a picture: how long their maps take to make, and how many vertices they mirror a second.

use catoptric::methods::projection::explosion_map::{ExplosionMapSettings, Preset, ReflectorMap};
use catoptric::methods::projection::reflector_search::{Images, ReflectorPictures, ReflectorSearchSettings};
use catoptric_testkit::drawing::{points_in, scene};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use std::hint::black_box;

const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;

/// Explosion maps as the paper uses them: building the map of a ball of 20,000 triangles, and mirroring vertices.
fn explosion_maps(criterion: &mut Criterion) {
    let scene = scene("sphere_room?tess=71");
    let view = scene.default_view(WIDTH, HEIGHT);
    let points = points_in(&scene, 1 << 20);
    let mut images = vec![Vec3::NAN; points.len()];
    for preset in [Preset::Faithful, Preset::Fast] {
        let mut map = ReflectorMap::new(&scene, scene.specular_objects()[0], &ExplosionMapSettings::preset(preset));
        // Also if only some of the benches run.
        map.look(&view);
        let mut group = criterion.benchmark_group(format!("explosion_map/{preset:?}"));
        group.sample_size(20);
        group.bench_function(format!("build, {} triangles", map.triangle_count()), |bencher| {
            bencher.iter(|| map.look(black_box(&view)));
        });
        group.throughput(Throughput::Elements(points.len() as u64));
        group.bench_function("virtual vertices", |bencher| {
            bencher.iter(|| map.virtual_vertices(black_box(&points), &mut images));
        });
        group.finish();
    }
}

/// The search as the library uses it: pictures of a ball, vertices of a scene one after the other, and points anywhere.
fn reflector_search(criterion: &mut Criterion) {
    let scene = scene("sphere_room");
    let view = scene.default_view(WIDTH, HEIGHT);
    let mirror = scene.specular_objects()[0];
    let own = &scene.objects[mirror as usize].vertices;
    let others = (0..scene.positions.len() as u32).filter(|vertex| !own.contains(vertex));
    let vertices: Vec<Vec3> = others.map(|vertex| scene.positions[vertex as usize]).cycle().take(1 << 20).collect();
    let anywhere = points_in(&scene, 1 << 20);
    let mut found = vec![Vec3::NAN; vertices.len()];
    for images in [Images::Eye, Images::Cube] {
        let settings = ReflectorSearchSettings { images, ..ReflectorSearchSettings::default() };
        let mut pictures = ReflectorPictures::new(&scene, mirror, &settings);
        // Also if only some of the benches run.
        pictures.look(&view);
        let mut group = criterion.benchmark_group(format!("reflector_search/{images:?}"));
        group.sample_size(20);
        group.bench_function(format!("build, {} triangles", pictures.triangle_count()), |bencher| {
            bencher.iter(|| pictures.look(black_box(&view)));
        });
        group.throughput(Throughput::Elements(vertices.len() as u64));
        for (label, points) in [("vertices", &vertices), ("points anywhere", &anywhere)] {
            group.bench_function(label, |bencher| {
                bencher.iter(|| pictures.virtual_vertices(black_box(points), &mut found));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, explosion_maps, reflector_search);
criterion_main!(benches);
