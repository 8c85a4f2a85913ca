//! Scene points to their appearances: points a second, by how they are found.
//!
//! Points lie anywhere in the scene's box. `second order` is the cached expansion of the nearest sample rays,
//! `polished` the solver's exact answer from there, `ray bundles` and `pinholes` the cameras of sample-based cameras,
//! `exact search` needs no view and no samples of it. Errors are those of `catoptric compare`; here the mean number of
//! appearances a point is printed beside the times. Run with `RAYON_NUM_THREADS=1` for one thread. `panorama`: cameras
//! for all directions about a place, building them and asking them.

use catoptric::methods::Quality;
use catoptric::methods::path_query::{FoundPath, PathSearch};
use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
use catoptric::methods::projection::sample_based_camera::{PanoramaSettings, PanoramicCameras, PanoramicMirrors};
use catoptric::methods::projector::Projections;
use catoptric::parallel;
use catoptric::progress::Silent;
use catoptric::scene::{Scene, View};
use catoptric_testkit::drawing::{points_in, scene, with_projector};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use std::hint::black_box;

const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;
const POINTS: usize = 65_536;
/// Points that a thread takes at once.
const AT_ONCE: usize = 1024;

/// Scene and highest order.
const SCENES: [(&str, u32); 4] = [("sphere_room", 1), ("vase", 1), ("dish", 1), ("two_spheres", 2)];

/// The measured cases: a label, the method, its settings.
const METHODS: [(&str, &str, &str); 7] = [
    (
        "second order, regular samples",
        "path_perturbation",
        "polish = 0\nexpansion = 'quadratic'\nspacing_px = 8\nfinest_px = 8",
    ),
    ("second order, adaptive samples", "path_perturbation", "polish = 0\nexpansion = 'quadratic'"),
    ("polished", "path_perturbation", ""),
    ("ray bundles, 1 px", "sample_based_camera", "accuracy_px = 1"),
    ("ray bundles, 0.1 px", "sample_based_camera", ""),
    ("pinholes, 1 px", "sample_based_camera", "preset = 'faithful'"),
    ("ray bundles, polished", "sample_based_camera", "preset = 'exact'"),
];

/// Calls `project` for every point on all threads; the sum of what it returns.
fn for_all(points: &[Vec3], project: impl Fn(&[Vec3]) -> usize + Sync) -> usize {
    let chunks: Vec<&[Vec3]> = points.chunks(AT_ONCE).collect();
    parallel::map_collect(chunks.len(), |index| project(chunks[index])).into_iter().sum()
}

fn projectors(criterion: &mut Criterion, name: &str, scene: &Scene, view: &View, order: u32) {
    let points = points_in(scene, POINTS);
    let mut group = criterion.benchmark_group(format!("points/{name}"));
    group.sample_size(10).throughput(Throughput::Elements(POINTS as u64));
    let quality = Quality { samples: 1, order };
    for (label, id, settings) in METHODS {
        with_projector(id, settings, scene, view, quality, |projector| {
            let run = || {
                for_all(&points, |points| {
                    let mut found = Projections::default();
                    projector.project(points, &mut found);
                    found.all().len()
                })
            };
            eprintln!("{name}, {label}: {:.3} appearances a point", run() as f64 / POINTS as f64);
            group.bench_function(label, |bencher| bencher.iter(|| black_box(run())));
        });
    }
    let settings = SearchSettings::default();
    let search = ExactSearch::new(scene, view.eye().as_dvec3(), order, &scene.specular_objects(), &settings, &Silent);
    let search = search.expect("built-in scenes can be searched");
    group.throughput(Throughput::Elements(POINTS as u64 / 16));
    group.bench_function("exact search", |bencher| {
        bencher.iter(|| {
            for_all(&points[..POINTS / 16], |points| {
                let mut found: Vec<FoundPath> = Vec::new();
                let mut count = 0;
                for &point in points {
                    found.clear();
                    count += search.search(point.as_dvec3(), &mut found).found;
                }
                count
            })
        });
    });
    group.finish();
}

/// Cameras for all directions about a place beside the mirrors: what building them costs, and points a second.
fn panoramas(criterion: &mut Criterion) {
    let places = [("sphere_room", 1, Vec3::new(-0.75, 1.9, 0.75)), ("two_spheres", 2, Vec3::new(0.15, 1.3, 0.75))];
    for (name, order, eye) in places {
        let scene = scene(&format!("{name}?surface=analytic"));
        let points = points_in(&scene, POINTS);
        let mirrors = PanoramicMirrors::new(&scene);
        for size_px in [128, 512] {
            let settings = PanoramaSettings { size_px, order, ..PanoramaSettings::default() };
            let build =
                || PanoramicCameras::new(&mirrors, eye, &settings, &Silent).expect("the bench's settings are valid");
            let mut group = criterion.benchmark_group(format!("panorama/{name}/build"));
            group
                .sample_size(10)
                .bench_function(format!("{size_px} px"), |bencher| bencher.iter(|| black_box(build())));
            group.finish();
            let cameras = build();
            eprintln!("{name}, {size_px} px: {:?}", cameras.report().counts);
            let projector = cameras.projector(&mirrors).expect("they were built for the scene");
            let mut group = criterion.benchmark_group(format!("panorama/{name}/points"));
            group.sample_size(10).throughput(Throughput::Elements(POINTS as u64));
            group.bench_function(format!("{size_px} px"), |bencher| {
                bencher.iter(|| {
                    for_all(&points, |points| {
                        let mut found = Vec::new();
                        points.iter().for_each(|&point| projector.project(point, &mut found));
                        found.len()
                    })
                });
            });
            group.finish();
        }
    }
}

fn all_scenes(criterion: &mut Criterion) {
    for (name, order) in SCENES {
        let scene = scene(name);
        let view = scene.default_view(WIDTH, HEIGHT);
        projectors(criterion, name, &scene, &view, order);
    }
}

criterion_group!(benches, all_scenes, panoramas);
criterion_main!(benches);
