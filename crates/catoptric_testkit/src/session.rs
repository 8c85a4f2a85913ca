//! A method on a scene, frame after frame: tests, benches and figures meet the life cycle of methods here alone.

use crate::baking::Units;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::bake::Baked;
use catoptric::methods::projector::VertexProjector;
use catoptric::methods::{self, Prepared, Quality, Report};
use catoptric::progress::Silent;
use catoptric::scene::{Scene, View};
use std::sync::Arc;

/// A method that is ready to draw a scene.
pub struct Session {
    prepared: Box<dyn Prepared>,
    quality: Quality,
}

/// A picture and the reports of how it was made.
#[derive(Clone)]
pub struct Drawn {
    /// The picture; all its values are finite.
    pub picture: Framebuffer,
    /// Report of the frame.
    pub report: Report,
    /// Report of the last preparation for the scene.
    pub setup: Report,
}

impl Session {
    /// Makes a method ready for a scene; `settings` are the lines of a TOML table.
    ///
    /// # Errors
    /// Settings and scenes that the method refuses.
    ///
    /// # Panics
    /// If `settings` is no TOML.
    pub fn new(id: &str, settings: &str, scene: &Scene, quality: Quality) -> Result<Self, RenderError> {
        Self::start(id, settings, scene, quality, None)
    }

    /// The same with units of a bake.
    ///
    /// # Errors
    /// As [`Self::new`], and units that do not fit.
    pub fn with_bake(
        id: &str,
        settings: &str,
        scene: &Scene,
        quality: Quality,
        units: Units,
    ) -> Result<Self, RenderError> {
        Self::start(id, settings, scene, quality, Some(Arc::new(units)))
    }

    fn start(
        id: &str,
        settings: &str,
        scene: &Scene,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
    ) -> Result<Self, RenderError> {
        let method = methods::create(id, &table(settings))?;
        Ok(Self { prepared: method.prepare(&Arc::new(scene.clone()), quality, bake, &Silent)?, quality })
    }

    /// Report of the last preparation for the scene.
    pub fn setup(&self) -> &Report {
        self.prepared.report()
    }

    /// Goes on with a changed scene.
    ///
    /// # Errors
    /// Scenes that the method refuses.
    pub fn update(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.prepared.update(&Arc::new(scene.clone()), self.quality, &Silent)
    }

    /// Builds what the method keeps for a view, without a picture.
    ///
    /// # Errors
    /// As [`Self::draw_into`].
    pub fn prepare_view(&mut self, view: &View) -> Result<Report, RenderError> {
        Ok(self.prepared.frame(view, &Silent)?.report().clone())
    }

    /// Draws a frame into a picture of the view's size; the report is that of building and drawing it.
    ///
    /// # Errors
    /// Views that the method cannot draw.
    pub fn draw_into(&mut self, view: &View, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let frame = self.prepared.frame(view, &Silent)?;
        let mut report = frame.report().clone();
        report.add(frame.draw(target, &Silent)?);
        Ok(report)
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// As [`Self::draw_into`].
    ///
    /// # Panics
    /// If a value of the picture is not finite.
    pub fn draw(&mut self, view: &View) -> Result<Drawn, RenderError> {
        let mut picture = Framebuffer::new(view.width, view.height);
        let report = self.draw_into(view, &mut picture)?;
        assert!(picture.pixels.iter().flatten().all(|value| value.is_finite()), "a value is not finite");
        Ok(Drawn { picture, report, setup: self.setup().clone() })
    }

    /// The result of `question` about the method's projector for a view.
    ///
    /// # Errors
    /// As [`Self::draw_into`].
    ///
    /// # Panics
    /// If the method projects no points.
    pub fn with_projector<R>(
        &mut self,
        view: &View,
        question: impl FnOnce(&dyn VertexProjector) -> R,
    ) -> Result<R, RenderError> {
        let frame = self.prepared.frame(view, &Silent)?;
        let projector = frame.projector().expect("the method projects points");
        Ok(question(projector.as_ref()))
    }
}

fn table(settings: &str) -> toml::Table {
    toml::from_str(settings).expect("settings are lines of TOML")
}
