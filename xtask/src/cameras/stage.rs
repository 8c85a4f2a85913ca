//! Scenes on which methods are set, drawn and measured.

use anyhow::{Context, Result, anyhow};
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::projection::{RoundTripError, RoundTripOptions, VertexProjector, round_trip};
use catoptric::methods::reference::specular_mask;
use catoptric::methods::{self, Job, Quality, ReflectionMethod, Report};
use catoptric::metrics::Comparison;
use catoptric::progress::Silent;
use catoptric::scene::{Model, PoseOptions, Scene, View, builtin};
use image::RgbImage;
use std::time::Instant;

/// The method of this page.
pub(crate) const CAMERAS: &str = "sample_based_camera";
/// The paper's cameras at the paper's accuracy.
pub(crate) const PINHOLE: &str = "preset = 'faithful'";
/// Ours, as they are without any setting.
pub(crate) const BUNDLE: &str = "";

/// A scene in a view.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) view: View,
    pub(crate) quality: Quality,
}

/// What a method drew.
pub(crate) struct Drawn {
    pub(crate) picture: Framebuffer,
    /// Of the first frame, the method's own preparation for the view included.
    pub(crate) report: Report,
    pub(crate) first_ms: f64,
    /// The shortest of the frames after the first; infinite where there are none.
    pub(crate) later_ms: f64,
}

impl Stage {
    /// A built-in scene in the view of its first camera.
    pub(crate) fn new(specification: &str, size: [u32; 2], order: u32) -> Result<Self> {
        let model = builtin::parse(specification).with_context(|| format!("builtin:{specification}"))?;
        Self::of_model(&model, size, order)
    }

    pub(crate) fn of_model(model: &Model, [width, height]: [u32; 2], order: u32) -> Result<Self> {
        let scene = model.pose(&PoseOptions::default()).with_context(|| model.name.clone())?;
        let view = scene.default_view(width, height);
        Ok(Self { scene, view, quality: Quality { samples: 4, order } })
    }

    pub(crate) fn with_samples(mut self, samples: u32) -> Self {
        self.quality.samples = samples;
        self
    }

    pub(crate) fn job(&self) -> Job<'_> {
        Job { scene: &self.scene, view: &self.view, quality: self.quality, progress: &Silent }
    }

    /// A method, ready for the scene; settings as in a TOML table, separated by commas.
    pub(crate) fn prepared(&self, method: &str, settings: &str) -> Result<Box<dyn ReflectionMethod>> {
        let mut method = create(method, settings)?;
        method.prepare(&self.scene, self.quality, &Silent)?;
        Ok(method)
    }

    /// Draws some frames of the same view with a method of its own.
    pub(crate) fn draw(&self, method: &str, settings: &str, frames: u32) -> Result<Drawn> {
        eprintln!("{}: {method} {settings}", self.scene.name);
        let mut method = self.prepared(method, settings)?;
        self.draw_with(method.as_mut(), frames)
    }

    /// Draws some frames of the same view with a method that is prepared for the scene.
    pub(crate) fn draw_with(&self, method: &mut dyn ReflectionMethod, frames: u32) -> Result<Drawn> {
        let mut picture = Framebuffer::new(self.view.width, self.view.height);
        let mut first: Option<(Report, f64)> = None;
        let mut later_ms = f64::INFINITY;
        for _ in 0..frames.max(1) {
            let start = Instant::now();
            let report = method.render(&self.job(), &mut picture)?;
            let frame_ms = start.elapsed().as_secs_f64() * 1e3;
            match first {
                None => first = Some((report, frame_ms)),
                Some(_) => later_ms = later_ms.min(frame_ms),
            }
        }
        let (report, first_ms) = first.unwrap_or_default();
        Ok(Drawn { picture, report, first_ms, later_ms })
    }

    /// The reference's picture with 16 samples a pixel, or as many as the stage has if those are more.
    pub(crate) fn truth(&self) -> Result<Framebuffer> {
        eprintln!("{}: reference", self.scene.name);
        let mut method = self.prepared("reference", "")?;
        let mut picture = Framebuffer::new(self.view.width, self.view.height);
        let quality = Quality { samples: self.quality.samples.max(16), ..self.quality };
        method.render(&Job { quality, ..self.job() }, &mut picture)?;
        Ok(picture)
    }

    /// What a method keeps for a view, made anew, and what it says about it.
    pub(crate) fn prepare_view(&self, method: &str, settings: &str) -> Result<Report> {
        Ok(self.prepared(method, settings)?.prepare_view(&self.job())?)
    }

    /// Asks `question` of the projector of a method.
    pub(crate) fn ask<R>(&self, settings: &str, question: impl FnOnce(&dyn VertexProjector) -> Result<R>) -> Result<R> {
        let mut method = self.prepared(CAMERAS, settings)?;
        let job = self.job();
        let projector = method.projector(&job)?.ok_or_else(|| anyhow!("{CAMERAS} has no projector"))?;
        question(projector.as_ref())
    }

    /// The projection error at every n-th pixel of every n-th row.
    pub(crate) fn projection_error(&self, settings: &str, every: u32) -> Result<RoundTripError> {
        eprintln!("{}: projection error, {settings}", self.scene.name);
        let options = RoundTripOptions { order: self.quality.order, every };
        self.ask(settings, |projector| Ok(round_trip(&self.scene, &self.view, projector, options, &Silent).all))
    }

    /// The pixels that show reflectors and lenses.
    pub(crate) fn mask(&self) -> Vec<bool> {
        specular_mask(&self.scene, &self.view)
    }
}

/// A method with settings as in a TOML table, separated by commas.
pub(crate) fn create(method: &str, settings: &str) -> Result<Box<dyn ReflectionMethod>> {
    let table: toml::Table = format!("settings = {{ {settings} }}").parse().with_context(|| settings.to_owned())?;
    let settings = table.get("settings").and_then(toml::Value::as_table).cloned().unwrap_or_default();
    Ok(methods::create(method, &settings)?)
}

/// Mean FLIP on the pixels of a mask.
pub(crate) fn flip(test: &Framebuffer, truth: &Framebuffer, mask: &[bool]) -> Result<f64> {
    let error = Comparison::new(test, truth)?.masked(mask)?;
    Ok(error.map_or(0.0, |error| error.flip_mean))
}

/// A picture for panels.
pub(crate) fn rgb(picture: &Framebuffer) -> Result<RgbImage> {
    RgbImage::from_raw(picture.width, picture.height, picture.to_srgb8()).context("a picture of the wrong size")
}

/// The middle of some times; 0 when there are none.
pub(crate) fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or_default()
}

/// The time of a stage in milliseconds.
pub(crate) fn stage_ms(report: &Report, stage: &str) -> f64 {
    report.stages_ms.iter().filter(|(name, _)| *name == stage).map(|(_, time)| time).sum()
}

/// A count of a report.
pub(crate) fn count(report: &Report, name: &str) -> u64 {
    report.counts.get(name).copied().unwrap_or_default()
}
