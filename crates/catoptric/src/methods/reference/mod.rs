//! The ray-traced truth that every method is measured against: a plain Whitted ray tracer.
//!
//! See this folder's `README.md`.

mod settings;

pub use settings::{Paths, ReferenceSettings, SamplePlacement};

use super::bake::Baked;
use super::{About, Family, Frame, Job, Method, MethodInfo, Prepared, Quality, Report, Settings};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::{EdgeSamples, Framebuffer};
use catoptric_core::math::random;
use catoptric_core::parallel;
use catoptric_core::progress::{Progress, Stage};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::path_tracer::{NearPlane, PathTracer};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::limits::ErrorLimits;
use catoptric_engine::method::overlay::{self, Overlay, OverlayKind};
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::raster::sample_positions;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The reference's entry in the registry.
pub static INFO: MethodInfo = MethodInfo {
    id: "reference",
    family: Family::Reference,
    summary: "ray-traced truth: every specular path up to the order, traced exactly",
    paper: "Whitted 1980, An improved illumination model for shaded display; \
            two-path model: Hakura, Snyder 2001, section 3",
    assumptions: "none; surfaces are shaded as every method shades them",
    about: About {
        readme: include_str!("README.md"),
        draws: "every pixel by rays: mirrors, glass and rough surfaces, all paths up to the order, analytic surfaces \
            exactly",
        costs: "every sample follows its paths through the whole scene, so it is the slowest with many samples; it \
            takes any number of them",
        cannot: "caustics are left out: light that mirrors and glass throw onto other surfaces",
        useful: &["paths", "rough_rays", "seed"],
    },
    cpu: true,
    gpu: false,
    bake: None,
    settings: ReferenceSettings::describe,
    effective: ReferenceSettings::effective,
    limits: &ErrorLimits { settings: "", scenes: &[] },
    create: |table| Ok(Box::new(Reference { settings: ReferenceSettings::from_table(table)? })),
};

/// Pixels a side of the squares that threads take one by one. A size for threads; chosen, not measured.
const TILE: u32 = 16;

/// First rays that are traced together, about.
const RAYS_AT_ONCE: f32 = 256.0;

/// The ray tracer as a method.
struct Reference {
    settings: ReferenceSettings,
}

/// The hierarchy over a scene.
struct PreparedReference {
    settings: ReferenceSettings,
    scene: Arc<Scene>,
    quality: Quality,
    tracer: Tracer,
    report: Report,
}

/// One view.
struct ReferenceFrame<'a> {
    prepared: &'a PreparedReference,
    view: View,
}

impl Method for Reference {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn overlays(&self) -> &'static [OverlayKind] {
        &[OverlayKind::Paths]
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        INFO.refuse_bake(bake)?;
        Ok(Box::new(PreparedReference::new(&self.settings, scene, quality, progress)?))
    }
}

impl PreparedReference {
    fn new(
        settings: &ReferenceSettings,
        scene: &Arc<Scene>,
        quality: Quality,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let stage = Stage::begin(progress, "building the hierarchy", 1)?;
        let mut watch = Stopwatch::new();
        let tracer = Tracer::build(scene, |_| true);
        let tracer = if settings.count_tests { tracer.counting_tests() } else { tracer };
        let mut report = Report { stages_ms: vec![("bvh", watch.lap_ms())], ..Report::default() };
        report.bytes.insert("bvh", tracer.byte_count());
        stage.advance(1)?;
        Ok(Self { settings: settings.clone(), scene: scene.clone(), quality, tracer, report })
    }
}

impl Prepared for PreparedReference {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        if Arc::ptr_eq(&self.scene, scene) {
            // The hierarchy holds for any number of samples.
            (self.quality, self.report.stages_ms) = (quality, Vec::new());
            return Ok(());
        }
        *self = Self::new(&self.settings, scene, quality, progress)?;
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(ReferenceFrame { prepared: self, view: view.clone() }))
    }
}

impl Frame for ReferenceFrame<'_> {
    fn report(&self) -> &Report {
        Report::none()
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let PreparedReference { settings, scene, quality, tracer, .. } = self.prepared;
        let mut watch = Stopwatch::new();
        let tests_before = tracer.test_count();
        let job = Job { scene, view: &self.view, quality: *quality, progress };
        let ([rays, ended], noise) = draw(settings, tracer, &job, target)?;
        let mut report = Report { stages_ms: vec![("trace", watch.lap_ms())], ..Report::default() };
        report.counts.extend([("rays_traced", rays), ("paths_ended", ended)]);
        report.noise = noise;
        if let (Some(before), Some(after)) = (tests_before, tracer.test_count()) {
            report.counts.insert("triangle_tests", after - before);
        }
        Ok(report)
    }

    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        if kind != OverlayKind::Paths {
            return Ok(None);
        }
        let PreparedReference { settings, scene, quality, tracer, .. } = self.prepared;
        let (view, rays, near) = (&self.view, self.view.rays(), NearPlane::new(&self.view));
        let init = || PathTracer::new(scene, tracer, settings.paths.into(), quality.order);
        let rows = parallel::map_init_stage(progress, "tracing", view.height as usize, init, |paths, row| {
            let pixel = |column: u32| SpecularPath {
                bounces: paths.bounces(&rays, &near, column as f32 + 0.5, row as f32 + 0.5),
            };
            (0..view.width).map(pixel).collect::<Vec<_>>()
        })?;
        let pixels: Vec<&SpecularPath> = rows.iter().flatten().collect();
        Ok(Some(overlay::paths::of_pixels(scene, [view.width, view.height], &pixels)))
    }
}

/// Samples that tell how much of a pixel each object covers, at most.
const EDGE_SAMPLES: usize = 16;

/// A tile's pixels, and the sum of the squares of their standard errors.
#[derive(Default)]
struct DrawnTile {
    pixels: Vec<[f32; 4]>,
    edges: EdgeSamples,
    squares: f64,
}

/// Draws the view: the numbers of rays traced and of paths that ended at the highest order, and the noise
/// ([`Report::noise`]) if there are samples to tell it.
fn draw(
    settings: &ReferenceSettings,
    tracer: &Tracer,
    job: &Job<'_>,
    target: &mut Framebuffer,
) -> Result<([u64; 2], Option<f64>), RenderError> {
    let (width, height) = (job.view.width, job.view.height);
    let columns = width.div_ceil(TILE);
    let tiles = columns as usize * height.div_ceil(TILE) as usize;
    let [rays, ended] = [0, 0].map(AtomicU64::new);
    // A sample stands for its share of the pixel.
    let footprint_scale = 1.0 / (job.quality.samples.max(1) as f32).sqrt();
    let init = || {
        PathTracer::new(job.scene, tracer, settings.paths.into(), job.quality.order)
            .with_rough_rays(settings.rough_rays, settings.seed, footprint_scale)
            .with_parts(job.quality.samples)
    };
    let pictures = parallel::map_init_stage(job.progress, "tracing", tiles, init, |paths, tile| {
        let (x0, y0) = (tile as u32 % columns * TILE, tile as u32 / columns * TILE);
        let tile = draw_tile(settings, paths, job, [x0, y0], [(x0 + TILE).min(width), (y0 + TILE).min(height)]);
        rays.fetch_add(paths.take_ray_count(), Ordering::Relaxed);
        ended.fetch_add(paths.take_ended_count(), Ordering::Relaxed);
        tile
    })?;
    let mut squares = 0.0;
    target.edges = EdgeSamples::default();
    for (tile, DrawnTile { pixels, edges, squares: of_tile }) in pictures.into_iter().enumerate() {
        squares += of_tile;
        target.edges.append(edges);
        let (x0, y0) = (tile as u32 % columns * TILE, tile as u32 / columns * TILE);
        let tile_width = TILE.min(width - x0) as usize;
        for (row, pixels) in pixels.chunks(tile_width).enumerate() {
            let start = (y0 as usize + row) * width as usize + x0 as usize;
            target.pixels[start..start + tile_width].copy_from_slice(pixels);
        }
    }
    let count = 3.0 * f64::from(width) * f64::from(height);
    let noise = (job.quality.samples > 1 && count > 0.0).then(|| (squares / count).sqrt());
    Ok(([rays, ended].map(AtomicU64::into_inner), noise))
}

/// Compiled with most of the shading for the instructions that the machine has.
#[cfg_attr(not(debug_assertions), multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt")))]
fn draw_tile(
    settings: &ReferenceSettings,
    paths: &mut PathTracer<'_>,
    job: &Job<'_>,
    [x0, y0]: [u32; 2],
    [x1, y1]: [u32; 2],
) -> DrawnTile {
    let samples = job.quality.samples.max(1);
    let pattern = match settings.samples {
        SamplePlacement::Pattern => sample_positions(samples).ok(),
        SamplePlacement::Random => None,
    };
    // A sample stands for its share of the pixel, and so do its texture footprints.
    let footprint_scale = 1.0 / (samples as f32).sqrt();
    let (rays, near) = (job.view.rays(), NearPlane::new(job.view));
    let (columns, rows) = (x1 - x0, y1 - y0);
    let mut drawn = DrawnTile::default();
    drawn.pixels.resize((columns * rows) as usize, [0.0; 4]);
    // Rays side by side share the first steps of their ways.
    let side = ((RAYS_AT_ONCE / samples as f32).sqrt() as u32).clamp(1, TILE);
    let mut positions = Vec::with_capacity((side * side * samples) as usize);
    let mut sums = vec![Vec3::ZERO; positions.capacity()];
    let mut objects = vec![None; positions.capacity()];
    for top in (0..rows).step_by(side as usize) {
        for left in (0..columns).step_by(side as usize) {
            let (right, bottom) = ((left + side).min(columns), (top + side).min(rows));
            let places = || (top..bottom).flat_map(|row| (left..right).map(move |column| (column, row)));
            positions.clear();
            for (column, row) in places() {
                let (x, y) = (x0 + column, y0 + row);
                for sample in 0..samples {
                    let offset = match pattern {
                        Some(pattern) => pattern[sample as usize],
                        None => stratified(settings.seed, [x, y], sample, samples),
                    };
                    positions.push(Vec2::new(x as f32, y as f32) + offset);
                }
            }
            let sums = &mut sums[..positions.len()];
            paths.radiances(&rays, &near, &positions, footprint_scale, sums, |index, hit| {
                objects[index] = hit.map(|hit| hit.object(job.scene));
            });
            if let Some(backdrop) = job.scene.backdrop {
                let behind = sums.iter_mut().zip(&objects).filter(|(_, object)| object.is_none());
                behind.for_each(|(sum, _)| *sum = backdrop);
            }
            let of_pixels = sums.chunks_exact(samples as usize).zip(objects.chunks_exact(samples as usize));
            for ((column, row), (sums, objects)) in places().zip(of_pixels) {
                let mean = sums.iter().sum::<Vec3>() / samples as f32;
                drawn.squares += f64::from(between_halves(sums).length_squared());
                drawn.pixels[(row * columns + column) as usize] = mean.max(Vec3::ZERO).extend(1.0).to_array();
                if objects.iter().any(|object| *object != objects[0]) {
                    let pixel = (y0 + row) * job.view.width + x0 + column;
                    drawn.edges.add(pixel, &means_by_object(sums, objects));
                }
            }
        }
    }
    drawn
}

/// The samples of a pixel, at most [`EDGE_SAMPLES`] of them, each the mean of those that show its object: what differs
/// among these is noise, and none of an edge.
fn means_by_object(samples: &[Vec3], objects: &[Option<u32>]) -> Vec<Vec3> {
    let mean = |wanted: Option<u32>| {
        let of_object = || samples.iter().zip(objects).filter(|(_, object)| **object == wanted);
        let sum: Vec3 = of_object().map(|(sample, _)| *sample).sum();
        (sum / of_object().count() as f32).max(Vec3::ZERO)
    };
    let count = samples.len().min(EDGE_SAMPLES);
    let mut shown: Vec<Option<u32>> = objects.to_vec();
    // Objects in their order, so that a few of them at equal distances stand for their shares.
    shown.sort_unstable();
    (0..count).map(|index| mean(shown[(2 * index + 1) * samples.len() / (2 * count)])).collect()
}

/// Half the difference of the means of two halves of a pixel's samples, up to 1 each: its standard error, about.
///
/// The halves are those of the Thue-Morse sequence, which no pattern of positions or directions knows.
fn between_halves(samples: &[Vec3]) -> Vec3 {
    let mut halves = [(Vec3::ZERO, 0u32); 2];
    for (index, sample) in samples.iter().enumerate() {
        let (sum, count) = &mut halves[(index.count_ones() % 2) as usize];
        *sum += *sample;
        *count += 1;
    }
    let [a, b] = halves.map(|(sum, count)| (sum / count.max(1) as f32).min(Vec3::ONE));
    if samples.len() > 1 { (a - b) * 0.5 } else { Vec3::ZERO }
}

/// The position in the picture, in pixels, of a sample of a pixel of so many.
pub fn sample_place(settings: &ReferenceSettings, pixel: [u32; 2], sample: u32, samples: u32) -> Vec2 {
    let pattern = match settings.samples {
        SamplePlacement::Pattern => sample_positions(samples).ok().and_then(|pattern| pattern.get(sample as usize)),
        SamplePlacement::Random => None,
    };
    let offset = pattern.copied().unwrap_or_else(|| stratified(settings.seed, pixel, sample, samples.max(1)));
    Vec2::new(pixel[0] as f32, pixel[1] as f32) + offset
}

/// A jittered position in the pixel: one sample in each cell of a grid with as many cells as samples, or a few more.
fn stratified(seed: u64, [x, y]: [u32; 2], sample: u32, samples: u32) -> Vec2 {
    if samples == 1 {
        return Vec2::splat(0.5);
    }
    let columns = (samples as f32).sqrt().ceil() as u32;
    let rows = samples.div_ceil(columns);
    let (column, row) = (sample % columns, sample / columns);
    // The last row may have fewer cells; they are wider, so that the pixel is covered evenly.
    let in_row = columns.min(samples - row * columns);
    let pixel = (x as u64) << 32 | y as u64;
    let jitter = |axis: u64| random::unit(seed, pixel, (sample as u64) << 1 | axis);
    Vec2::new((column as f32 + jitter(0)) / in_row as f32, (row as f32 + jitter(1)) / rows as f32)
}
