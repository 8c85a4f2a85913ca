//! How fluid the picture is while the eye moves, and how soon what moves is seen while something else is at work.
//!
//! ```sh
//! cargo bench -p catoptric_viewer --bench fluid -- builtin:vase scene.glb
//! ```
//!
//! 1280 x 720 pixels, 4 samples, order 2, on the CPU; on the adapter whose name has `CATOPTRIC_ADAPTER` as a part, if
//! that is set, from which pictures are read back. The eye moves 60 times a second for some seconds. Printed are
//! pictures a second, the share of their width that drafts have in the middle, and the times from a new wish to its
//! picture: the middle one and the longest.

#![expect(clippy::print_stdout, reason = "a bench prints")]

use catoptric::methods::Quality;
use catoptric::scene::Camera;
use catoptric_gpu::Context;
use catoptric_viewer::app::{Link, StudioThread};
use catoptric_viewer::studio::Gpu;
use catoptric_viewer::studio::news::{News, SceneSummary};
use catoptric_viewer::studio::order::{Changes, Drawn, Order, Source, Wish};
use glam::{Affine3A, Quat, Vec3};
use std::sync::Arc;
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [1280, 720];
const STEP: Duration = Duration::from_micros(16_667);
const SECONDS: f32 = 6.0;

fn main() {
    // Options that cargo adds are no scenes.
    let scenes: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let usual = ["builtin:sphere_room", "builtin:vase", "builtin:dish", "builtin:glass_sphere"].map(String::from);
    let adapter = std::env::var("CATOPTRIC_ADAPTER").ok();
    let context = adapter.map(|name| Context::new(Some(&name)));
    let gpu = match context.transpose() {
        Ok(context) => context.map(Gpu::apart),
        Err(problem) => return println!("{problem}"),
    };
    if let Some(gpu) = &gpu {
        println!("on {}", gpu.name());
    }
    for scene in if scenes.is_empty() { usual.to_vec() } else { scenes } {
        println!("{scene}");
        for (name, methods) in [
            ("auto", &["auto"][..]),
            ("auto beside the reference, which sharpens", &["auto", "reference"]),
            ("light_field, which is captured first", &["light_field"]),
        ] {
            measure(gpu.clone(), &scene, name, methods);
        }
    }
}

/// The times of a run.
#[derive(Default)]
struct Times {
    /// From a wish to its picture.
    waits_ms: Vec<f64>,
    scales: Vec<f64>,
}

fn measure(gpu: Option<Gpu>, scene: &str, name: &str, methods: &[&str]) {
    let gpu_name = gpu.as_ref().map(Gpu::name);
    let studio = StudioThread::start(gpu, Box::new(|| ()));
    studio.send(Order::Load { number: 1, source: Source::of_word(scene), opening: Default::default() });
    let Some(summary) = loaded(&studio) else { return println!("  it cannot be loaded") };
    let mut wishes: Vec<(Arc<Wish>, Instant)> = Vec::new();
    let mut times = Times::default();
    let wish = |camera: Camera| Wish {
        scene: 1,
        time: 0.0,
        clip: None,
        changes: Changes::default(),
        camera,
        size: SIZE,
        sides: methods.iter().map(|method| drawn(method)).collect(),
        has_automatic_order: false,
        display: Default::default(),
        compares: false,
        overlays: Vec::new(),
    };
    // Once at rest: what is prepared is there, and sharpening has begun.
    let first = Arc::new(wish(summary.cameras[0].clone()));
    let start = Instant::now();
    studio.wish(first.clone());
    let mut first_ms = None;
    loop {
        match studio.news() {
            Some(News::Drawn(picture)) => {
                first_ms.get_or_insert(start.elapsed().as_secs_f64() * 1e3);
                // A device makes programs of its shaders before its first picture.
                if gpu_name.as_ref().is_none_or(|name| *name == picture.processor) {
                    break;
                }
            }
            Some(News::NotDrawn { problem, .. }) => return println!("  {name}: {problem}"),
            _ => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    let first_ms = first_ms.unwrap_or(f64::NAN);
    std::thread::sleep(Duration::from_millis(200));
    let start = Instant::now();
    let mut step = 0;
    while start.elapsed().as_secs_f32() < SECONDS {
        let due = start + STEP * step;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        let next = Arc::new(wish(turned(&summary, step as f32 * 0.5)));
        wishes.push((next.clone(), Instant::now()));
        studio.wish(next);
        step += 1;
        while let Some(news) = studio.news() {
            take(news, &wishes, &mut times);
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let Times { mut waits_ms, mut scales } = times;
    waits_ms.sort_by(f64::total_cmp);
    scales.sort_by(f64::total_cmp);
    let middle = |sorted: &[f64]| sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN);
    println!(
        "  {name}: first picture {first_ms:.0} ms; {:.1} pictures a second, {:.2} of the width, {:.0} ms from wish to \
         picture, at most {:.0}",
        waits_ms.len() as f64 / seconds,
        middle(&scales),
        middle(&waits_ms),
        waits_ms.last().copied().unwrap_or(f64::NAN),
    );
}

fn drawn(method: &str) -> Drawn {
    Drawn { method: method.into(), settings: toml::Table::new(), quality: Quality { samples: 4, order: 2 } }
}

fn loaded(studio: &StudioThread) -> Option<SceneSummary> {
    loop {
        match studio.news() {
            Some(News::Loaded(summary)) => return Some(*summary),
            Some(News::NotLoaded { problem, .. }) => {
                println!("  {problem}");
                return None;
            }
            _ => std::thread::sleep(Duration::from_millis(1)),
        }
    }
}

/// Notes a picture of the left side.
fn take(news: News, wishes: &[(Arc<Wish>, Instant)], times: &mut Times) {
    let News::Drawn(picture) = news else { return };
    let sent = wishes.iter().rfind(|(wish, _)| Arc::ptr_eq(wish, &picture.wish));
    if let (0, Some((_, sent))) = (picture.side, sent) {
        times.waits_ms.push(sent.elapsed().as_secs_f64() * 1e3);
        times.scales.push(f64::from(picture.size[0]) / f64::from(SIZE[0]));
    }
}

/// The scene's camera, turned about what it looks at.
fn turned(summary: &SceneSummary, degrees: f32) -> Camera {
    let mut camera = summary.cameras[0].clone();
    let pivot = camera.point_looked_at(&summary.bounds);
    let turn = Affine3A::from_translation(pivot)
        * Affine3A::from_quat(Quat::from_axis_angle(Vec3::Y, degrees.to_radians()))
        * Affine3A::from_translation(-pivot);
    camera.world_from_camera = turn * camera.world_from_camera;
    camera
}
