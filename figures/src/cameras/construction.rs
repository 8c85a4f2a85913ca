//! Figure 19: what building the cameras takes.

use crate::stage::{CAMERAS, Stage, count, median, print, stage_ms};
use anyhow::{Context, Result};
use catoptric::methods::Report;

/// The paper's scenes: what it calls them, the built-in scene that stands for each, the order that is drawn.
pub(crate) const SCENES: [(&str, &str, u32); 4] = [
    ("spherical cap", "sphere_room", 1),
    ("teapot body", "teapot", 1),
    ("two spheres", "two_spheres", 2),
    ("automobile", "car", 1),
];

/// The cameras that are built: their name in the table, and their settings.
const KINDS: [(&str, &str); 3] = [
    ("pinholes", "camera = 'pinhole'"),
    ("pinholes, split to the end", "camera = 'pinhole'\nmax_shared = 2"),
    ("ray bundles", "camera = 'ray_bundle'"),
];

/// The number of times that each tree is built.
const REPETITIONS: usize = 5;

/// The size of the picture whose rays are down-sampled.
const SIZE: [u32; 2] = [720, 480];

/// The times of building, repeatedly.
struct Builds {
    last: Report,
    ray_map_ms: f64,
    build_ms: f64,
}

/// The statistics of section VII.B for both kinds of cameras.
pub(crate) fn print_table() -> Result<()> {
    print(
        "| scene | cameras | resolution | rays, thousands | coverage % | leaves | ray lists | rays in lists | \
         unsplit lists | size KB | ray map ms | construction ms |",
    )?;
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")?;
    for (label, specification, order) in SCENES {
        let stage = Stage::new(specification, SIZE, order)?;
        let mask = stage.mask();
        let coverage = 100.0 * mask.iter().filter(|seen| **seen).count() as f64 / mask.len().max(1) as f64;
        for (camera, kind) in KINDS {
            for (resolution, spacing) in [("quarter", 4), ("half", 2)] {
                eprintln!("{label}: {camera}, {resolution}");
                let settings = format!("{kind}\naccuracy_px = 1.0\ndownsampling = {spacing}");
                let built = build(&stage, &settings)?;
                let report = &built.last;
                print(&format!(
                    "| {label} | {camera} | {resolution} | {:.1} | {coverage:.0} | {} | {} | {} | {} | {:.0} | {:.0} | \
                    {:.0} |",
                    count(report, "ray_map_rays") as f64 / 1000.0,
                    count(report, "leaves"),
                    count(report, "ray_lists"),
                    count(report, "rays_in_lists"),
                    report.fallbacks.get("unsplit_lists").copied().unwrap_or_default(),
                    report.bytes.get("cameras").copied().unwrap_or_default() as f64 / 1024.0,
                    built.ray_map_ms,
                    built.build_ms,
                ))?;
            }
        }
    }
    Ok(())
}

/// Builds cameras again and again on one thread, as the paper did; the medians of the times.
fn build(stage: &Stage, settings: &str) -> Result<Builds> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    let mut last = Report::default();
    let (mut ray_map, mut construction) = (Vec::new(), Vec::new());
    for _ in 0..REPETITIONS {
        last = pool.install(|| -> Result<_> { Ok(stage.session(CAMERAS, settings)?.prepare_view(&stage.view)?) })?;
        ray_map.push(stage_ms(&last, "ray_map"));
        construction.push(stage_ms(&last, "build"));
    }
    Ok(Builds { last, ray_map_ms: median(&mut ray_map), build_ms: median(&mut construction) })
}
