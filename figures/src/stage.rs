//! Scenes on which methods are set, drawn and measured.

use anyhow::{Context, Result};
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::methods::projection::measure::round_trip::{RoundTripError, RoundTripOptions, round_trip};
use catoptric::methods::projector::VertexProjector;
use catoptric::methods::{Quality, Report};
use catoptric::metrics::Comparison;
use catoptric::progress::Silent;
use catoptric::scene::{Model, PoseOptions, Scene, View};
use catoptric_scenes::builtin;
use catoptric_testkit::Session;
use catoptric_testkit::drawing::alone;
use image::RgbImage;
use std::io::Write;
use std::time::Instant;

/// The method of sample-based cameras.
pub(crate) const CAMERAS: &str = "sample_based_camera";
/// Settings of the cameras of Popescu, Sacks, Mei 2006, at their accuracy.
pub(crate) const PINHOLE: &str = "preset = 'faithful'";
/// Settings of the cameras that the method has of itself.
pub(crate) const BUNDLE: &str = "";

/// A scene in a view.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) view: View,
    pub(crate) quality: Quality,
}

/// The last of some frames, and their times.
pub(crate) struct Frames {
    pub(crate) picture: Framebuffer,
    /// The time of the first frame, the method's own preparation for the view included.
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

    /// A method that is ready for the scene; settings are lines of TOML. Sample-based cameras draw all paths, however
    /// long that takes.
    pub(crate) fn session(&self, method: &str, settings: &str) -> Result<Session> {
        let settings = &alone_if_cameras(method, settings);
        eprintln!("{}: {method} {}", self.scene.name, settings.replace('\n', ", "));
        Ok(Session::new(method, settings, &self.scene, self.quality)?)
    }

    /// Draws some frames of the same view with a method of its own.
    pub(crate) fn draw(&self, method: &str, settings: &str, frames: u32) -> Result<Frames> {
        draw(&mut self.session(method, settings)?, &self.view, frames)
    }

    /// A method's picture for panels.
    pub(crate) fn panel(&self, method: &str, settings: &str) -> Result<RgbImage> {
        rgb(&self.draw(method, settings, 1)?.picture)
    }

    /// The reference's picture with 16 samples a pixel, or as many as the stage has if those are more.
    pub(crate) fn truth(&self) -> Result<Framebuffer> {
        let quality = Quality { samples: self.quality.samples.max(16), ..self.quality };
        Ok(Session::new("reference", "", &self.scene, quality)?.draw(&self.view)?.picture)
    }

    /// The projection error at every n-th pixel of every n-th row.
    pub(crate) fn projection_error(&self, method: &str, settings: &str, every: u32) -> Result<RoundTripError> {
        let options = RoundTripOptions { order: self.quality.order, every };
        let trips = |projector: &dyn VertexProjector| round_trip(&self.scene, &self.view, projector, options, &Silent);
        Ok(self.session(method, settings)?.with_projector(&self.view, trips)??.all)
    }

    /// The pixels that show reflectors and lenses.
    pub(crate) fn mask(&self) -> Vec<bool> {
        specular_mask(&self.scene, &self.view)
    }
}

/// Settings of a method, lines of TOML: sample-based cameras draw all paths, however long that takes.
pub(crate) fn alone_if_cameras(method: &str, settings: &str) -> String {
    let draws_all = method != CAMERAS || settings.contains(PINHOLE);
    if draws_all { settings.into() } else { alone(settings) }
}

/// Draws some frames of the same view.
pub(crate) fn draw(session: &mut Session, view: &View, frames: u32) -> Result<Frames> {
    let mut picture = Framebuffer::new(view.width, view.height);
    let mut first: Option<(Report, f64)> = None;
    let mut later_ms = f64::INFINITY;
    for _ in 0..frames.max(1) {
        let (report, frame_ms) = timed(session, view, &mut picture)?;
        match first {
            None => first = Some((report, frame_ms)),
            Some(_) => later_ms = later_ms.min(frame_ms),
        }
    }
    let (report, first_ms) = first.unwrap_or_default();
    Ok(Frames { picture, report, first_ms, later_ms })
}

/// Draws a frame; its report and its time in milliseconds.
pub(crate) fn timed(session: &mut Session, view: &View, picture: &mut Framebuffer) -> Result<(Report, f64)> {
    let start = Instant::now();
    let report = session.draw_into(view, picture)?;
    Ok((report, start.elapsed().as_secs_f64() * 1e3))
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

/// Prints a line of a table.
pub(crate) fn print(line: &str) -> Result<()> {
    writeln!(std::io::stdout(), "{line}")?;
    Ok(())
}
