//! Light-field slabs: capturing them, and looking rays up.

use catoptric::math::random::Stream;
use catoptric::methods::lookup::light_field::{Disparity, LightFieldSettings, Slabs};
use catoptric::progress::Silent;
use catoptric_testkit::drawing::scene;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use std::hint::black_box;

fn light_field(criterion: &mut Criterion) {
    let scene = scene("large_room");
    let region = scene.objects[scene.specular_objects()[0] as usize].bounds;
    let mut group = criterion.benchmark_group("light_field");
    group.sample_size(10);
    let small = LightFieldSettings { st: 8, uv: 64, ..LightFieldSettings::default() };
    group.throughput(Throughput::Elements(6 * 64 * 64 * 64));
    group.bench_function(format!("capture, {} triangles", scene.triangles.len()), |bencher| {
        bencher.iter(|| Slabs::capture(&small, black_box(&scene), region, 0, &Silent));
    });
    let mut random = Stream::new(6);
    let mut next = || Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)));
    let count = 1 << 20;
    let points: Vec<Vec3> = (0..count).map(|_| region.center() + region.size() * 0.5 * next()).collect();
    let anywhere: Vec<Vec3> = (0..count).map(|_| next().normalize()).collect();
    // Directions as from a distant ball: neighbours differ little.
    let angle = |k: usize, every: usize| (k % every) as f32 / every as f32 * 3.0 - 1.5;
    let near = |k: usize| Vec3::new(angle(k, 1024).sin(), angle(k / 1024, 1024).sin(), 1.0).normalize();
    let beside: Vec<Vec3> = (0..count).map(near).collect();
    let on_ball: Vec<Vec3> = beside.iter().map(|normal| region.center() + region.size() * 0.29 * *normal).collect();
    let mut radiance = vec![Vec3::ZERO; count];
    group.throughput(Throughput::Elements(count as u64));
    for disparity in [Disparity::Plane, Disparity::Depth] {
        let settings = LightFieldSettings { st: 16, uv: 128, disparity, ..LightFieldSettings::default() };
        let slabs = Slabs::capture(&settings, &scene, region, 0, &Silent).expect("the region has a size");
        for (label, points, directions) in
            [("rays side by side", &on_ball, &beside), ("rays anywhere", &points, &anywhere)]
        {
            group.bench_function(format!("{disparity:?}, {label}"), |bencher| {
                bencher.iter(|| slabs.radiance_batch(black_box(points), directions, &mut radiance));
            });
            // As pictures are drawn: each ray on its own, with how it changes from pixel to pixel.
            let pixel = 3.0 / 1024.0;
            let change = [Vec3::X * pixel, Vec3::Y * pixel];
            group.bench_function(
                format!("{disparity:?}, {label}, one by one with footprints, one thread"),
                |bencher| {
                    bencher.iter(|| {
                        for (radiance, (point, direction)) in radiance.iter_mut().zip(points.iter().zip(directions)) {
                            *radiance =
                                slabs.radiance(black_box(*point), *direction, change, change).unwrap_or_default();
                        }
                    });
                },
            );
        }
    }
    group.finish();
}

criterion_group!(benches, light_field);
criterion_main!(benches);
