//! A budget of time a frame, for any method.

use super::bake::Baked;
use super::{Frame, Method, MethodInfo, Prepared, Quality, Report};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::path_query::PathSearch;
use catoptric_engine::method::projector::{PathBeginnings, VertexProjector};
use catoptric_engine::raster::SAMPLE_COUNTS;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The method that draws what is not done in time.
const EXACT: &str = "auto";

/// A method whose frames are ended after a time, and are then drawn by `auto`.
///
/// A frame takes little longer than its budget and `auto`'s frame together. A clock decides: the same input may give
/// other pixels on another machine. Without clocks (see [`Stopwatch`]) no frame is ended. `auto` and
/// `multiperspective`, whose frames nothing exact would draw faster, are left alone.
pub struct Budgeted<'a> {
    method: &'a dyn Method,
    budget_ms: f64,
}

impl<'a> Budgeted<'a> {
    /// Gives the frames of a method a budget in milliseconds.
    pub fn new(method: &'a dyn Method, budget_ms: f64) -> Self {
        Self { method, budget_ms }
    }
}

/// Progress that also cancels when the time is over.
struct Deadline<'a> {
    progress: &'a dyn Progress,
    watch: &'a Stopwatch,
    budget_ms: f64,
    is_over: AtomicBool,
}

impl<'a> Deadline<'a> {
    fn new(progress: &'a dyn Progress, watch: &'a Stopwatch, budget_ms: f64) -> Self {
        Self { progress, watch, budget_ms, is_over: AtomicBool::new(false) }
    }

    /// The result of work, or `None` if the time was over before it was done.
    fn outcome<T>(&self, result: Result<T, RenderError>) -> Result<Option<T>, RenderError> {
        match result {
            Err(RenderError::Cancelled(_)) if self.is_over.load(Ordering::Relaxed) => Ok(None),
            other => other.map(Some),
        }
    }
}

impl Progress for Deadline<'_> {
    fn at(&self, stage: &str, done: u64, of: u64) -> Result<(), Cancelled> {
        self.progress.at(stage, done, of)?;
        if self.watch.elapsed_ms() > self.budget_ms {
            self.is_over.store(true, Ordering::Relaxed);
            return Err(Cancelled);
        }
        Ok(())
    }
}

/// The quality with as many of its samples as the rasteriser has a pattern for.
fn rasterised(quality: Quality) -> Quality {
    let counts = SAMPLE_COUNTS.into_iter().filter(|count| *count <= quality.samples);
    Quality { samples: counts.max().unwrap_or(1), ..quality }
}

struct PreparedBudget {
    prepared: Box<dyn Prepared>,
    /// Draws what the method could not end.
    exact: Box<dyn Prepared>,
    budget_ms: f64,
}

struct BudgetFrame<'a> {
    /// `None` if the time was over before it was built.
    frame: Option<Box<dyn Frame + 'a>>,
    exact: Box<dyn Frame + 'a>,
    budget_ms: f64,
    /// The time that building it has taken.
    built_ms: f64,
}

impl Method for Budgeted<'_> {
    fn info(&self) -> &'static MethodInfo {
        self.method.info()
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        let prepared = self.method.prepare(scene, quality, bake, progress)?;
        if [EXACT, "multiperspective"].contains(&self.info().id) {
            return Ok(prepared);
        }
        let exact = super::create(EXACT, &toml::Table::new())?.prepare(scene, rasterised(quality), None, progress)?;
        Ok(Box::new(PreparedBudget { prepared, exact, budget_ms: self.budget_ms }))
    }
}

impl Prepared for PreparedBudget {
    fn report(&self) -> &Report {
        self.prepared.report()
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        self.exact.update(scene, rasterised(quality), progress)?;
        self.prepared.update(scene, quality, progress)
    }

    fn frame<'a>(&'a mut self, view: &View, progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        let watch = Stopwatch::new();
        let exact = self.exact.frame(view, progress)?;
        let frame = {
            let deadline = Deadline::new(progress, &watch, self.budget_ms);
            deadline.outcome(self.prepared.frame(view, &deadline))?
        };
        let (budget_ms, built_ms) = (self.budget_ms, watch.elapsed_ms());
        Ok(Box::new(BudgetFrame { frame, exact, budget_ms, built_ms }))
    }
}

impl Frame for BudgetFrame<'_> {
    fn report(&self) -> &Report {
        self.frame.as_ref().map_or(Report::none(), |frame| frame.report())
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        // A frame that is drawn again has its time again.
        let watch = Stopwatch::new();
        if let Some(frame) = &self.frame {
            let deadline = Deadline::new(progress, &watch, self.budget_ms - self.built_ms);
            if let Some(report) = deadline.outcome(frame.draw(target, &deadline))? {
                return Ok(report);
            }
        }
        let mut report = self.exact.draw(target, progress)?;
        report.add_fallback("frames_over_budget", 1);
        let budget_ms = self.budget_ms;
        report.warnings.push(format!("the frame was not done within {budget_ms} ms: `auto` has drawn it"));
        Ok(report)
    }

    fn paths_left(&self, progress: &dyn Progress) -> Result<PathBeginnings, RenderError> {
        self.frame.as_ref().map_or_else(|| Ok(PathBeginnings::default()), |frame| frame.paths_left(progress))
    }

    fn projector(&self) -> Option<Box<dyn VertexProjector + '_>> {
        self.frame.as_ref()?.projector()
    }

    fn path_search(&self, eye: DVec3, objects: &[u32]) -> Result<Option<Box<dyn PathSearch + '_>>, RenderError> {
        match &self.frame {
            Some(frame) => frame.path_search(eye, objects),
            None => Ok(None),
        }
    }
}
