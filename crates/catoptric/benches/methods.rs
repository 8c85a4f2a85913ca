//! Every method on built-in scenes at 1440 x 960: the time of a frame, and its error beside it.
//!
//! The error (mean FLIP and the share of pixels off by more than 0.1, over reflector pixels, 4 samples) is printed once
//! before the times: speed without its error means nothing. Run with `RAYON_NUM_THREADS=1` for one thread.

use catoptric::framebuffer::Framebuffer;
use catoptric::methods::reference::specular_mask;
use catoptric::methods::{self, Job, Quality, ReflectionMethod, Report};
use catoptric::metrics::Comparison;
use catoptric::progress::Silent;
use catoptric::scene::{PoseOptions, Scene, View, builtin};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const WIDTH: u32 = 1440;
const HEIGHT: u32 = 960;

/// Scene, method and settings.
const CASES: [(&str, &str, &str); 7] = [
    ("sphere_room", "reference", ""),
    ("sphere_room", "environment_map", ""),
    ("sphere_room", "environment_map", "parallax = 'box'"),
    ("vase", "reference", ""),
    ("glass_sphere", "reference", ""),
    ("planar_mirror?mirrors=2", "reference", ""),
    ("planar_mirror?mirrors=2", "planar_mirror", ""),
];

fn prepared(id: &str, settings: &str, scene: &Scene, quality: Quality) -> Box<dyn ReflectionMethod> {
    let settings = toml::from_str(settings).expect("the bench's settings are valid");
    let mut method = methods::create(id, &settings).expect("the bench's methods exist");
    method.prepare(scene, quality, &Silent).expect("built-in scenes can be drawn");
    method
}

fn draw(
    method: &mut dyn ReflectionMethod,
    scene: &Scene,
    view: &View,
    quality: Quality,
    to: &mut Framebuffer,
) -> Report {
    let job = Job { scene, view, quality, progress: &Silent };
    method.render(&job, to).expect("built-in scenes can be drawn")
}

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("frame 1440x960");
    group.sample_size(10);
    for (name, id, settings) in CASES {
        let scene = builtin::parse(name).and_then(|model| model.pose(&PoseOptions::default()));
        let scene = scene.expect("built-in scenes are valid");
        let view = scene.default_view(WIDTH, HEIGHT);
        let mut picture = Framebuffer::new(WIDTH, HEIGHT);
        if id != "reference" {
            let quality = Quality { samples: 4, order: 2 };
            draw(&mut *prepared(id, settings, &scene, quality), &scene, &view, quality, &mut picture);
            let mut truth = Framebuffer::new(WIDTH, HEIGHT);
            draw(&mut *prepared("reference", "", &scene, quality), &scene, &view, quality, &mut truth);
            let comparison = Comparison::new(&picture, &truth).expect("the sizes are equal");
            let error = comparison.masked(&specular_mask(&scene, &view)).ok().flatten();
            if let Some(error) = error {
                eprintln!(
                    "{name} {id} {settings}: FLIP {:.4}, off by over 0.1: {:.5}",
                    error.flip_mean, error.over_0_1
                );
            }
        }
        for samples in [1, 16] {
            let quality = Quality { samples, order: 2 };
            let mut method = prepared(id, settings, &scene, quality);
            let report = draw(&mut *method, &scene, &view, quality, &mut picture);
            let work = report.counts.get("rays_traced").or(report.counts.get("fragments")).copied().unwrap_or(1);
            group.throughput(Throughput::Elements(work));
            group.bench_function(format!("{name}/{id}/{settings}/{samples} samples"), |bencher| {
                bencher.iter(|| black_box(draw(&mut *method, &scene, &view, quality, &mut picture)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
