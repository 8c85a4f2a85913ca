//! Every method on built-in scenes at 1440 x 960: the time of a frame, and its error beside it.
//!
//! The error (mean FLIP and the share of pixels off by more than 0.1, over reflector pixels, 4 samples) is printed once
//! before the times: speed without its error means nothing. Run with `RAYON_NUM_THREADS=1` for one thread.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::Quality;
use catoptric_testkit::drawing::{error, scene, session};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const WIDTH: u32 = 1440;
const HEIGHT: u32 = 960;

/// Scene, method and settings.
const CASES: &[(&str, &str, &str)] = &[
    ("sphere_room", "reference", ""),
    ("sphere_room", "environment_map", ""),
    ("sphere_room", "environment_map", "parallax = 'box'"),
    ("vase", "reference", ""),
    ("glass_sphere", "reference", ""),
    ("planar_mirror?mirrors=2", "reference", ""),
    ("planar_mirror?mirrors=2", "planar_mirror", ""),
];

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("frame 1440x960");
    group.sample_size(10);
    for &(name, id, settings) in CASES {
        let scene = scene(name);
        let view = scene.default_view(WIDTH, HEIGHT);
        let mut picture = Framebuffer::new(WIDTH, HEIGHT);
        if id != "reference" {
            let quality = Quality { samples: 4, order: 2 };
            let error = error(id, settings, &scene, &view, quality);
            eprintln!("{name} {id} {settings}: FLIP {:.4}, off by over 0.1: {:.5}", error.flip_mean, error.over_0_1);
        }
        for samples in [1, 16] {
            let quality = Quality { samples, order: 2 };
            let mut session = session(id, settings, &scene, quality);
            let mut draw = || session.draw_into(&view, &mut picture).expect("built-in scenes can be drawn");
            let report = draw();
            assert!(report.fallbacks.is_empty(), "{name} {id}: times of fallbacks: {:?}", report.fallbacks);
            let work = report.counts.get("rays_traced").or(report.counts.get("fragments")).copied().unwrap_or(1);
            group.throughput(Throughput::Elements(work));
            group.bench_function(format!("{name}/{id}/{settings}/{samples} samples"), |bencher| {
                bencher.iter(|| black_box(draw()));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
