//! Stages of work with their times.

use catoptric_core::clock::Stopwatch;
use catoptric_core::progress::{Progress, Stage};
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::Report;
use std::sync::Arc;

/// Stages of work with their times.
pub(crate) struct Stages<'a> {
    pub(crate) report: Report,
    pub(crate) progress: &'a dyn Progress,
    watch: Stopwatch,
}

impl<'a> Stages<'a> {
    /// No stage so far.
    pub(super) fn new(progress: &'a dyn Progress) -> Self {
        Self { report: Report::default(), progress, watch: Stopwatch::new() }
    }

    /// Ends a stage: its time is that since the last one.
    pub(crate) fn lap(&mut self, name: &'static str) {
        self.report.stages_ms.push((name, self.watch.lap_ms()));
    }
}

/// The hierarchy over reflectors and lenses alone, for methods that trace rays through these: the old one if there is
/// one.
///
/// # Errors
/// [`RenderError::Cancelled`].
pub(crate) fn mirror_tracer(
    scene: &Scene,
    old: Option<&Arc<Tracer>>,
    stages: &mut Stages<'_>,
) -> Result<Arc<Tracer>, RenderError> {
    if let Some(old) = old {
        return Ok(old.clone());
    }
    Stage::begin(stages.progress, "building the hierarchy", 0)?;
    let tracer = Arc::new(Tracer::build(scene, |object| scene.role_of(object).is_specular()));
    stages.lap("bvh");
    Ok(tracer)
}
