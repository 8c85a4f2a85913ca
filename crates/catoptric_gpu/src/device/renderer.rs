//! Drawing into textures of the caller's, among other work: for engines and windows.

use super::frame::{Timer, VertexAppearance};
use super::method::{DeviceMethod, PreparedScene};
use super::reading::{Encoding, Reading};
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::bake::Baked;
use catoptric::methods::{Frame, Method, Prepared, Quality, Report};
use catoptric::progress::Progress;
use catoptric::scene::{Scene, View};
use catoptric::tone::Display;
use std::sync::Arc;
use wgpu::TextureFormat;

/// A scene on a device, drawn by a method into textures that the caller owns.
///
/// Work is added to an encoder of the caller's, and not waited for. The example `into_texture` has all of it.
pub struct Renderer {
    prepared: PreparedScene,
    display: Display,
}

impl std::fmt::Debug for Renderer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Renderer").field("method", &self.prepared.method).finish_non_exhaustive()
    }
}

impl Renderer {
    /// Loads a scene for a method, with what it captures or takes from a baked file. The scene's lights cast shadows if
    /// it has been given them ([`cast_shadows`](catoptric::light::visibility::cast_shadows)).
    ///
    /// # Errors
    /// As [`Method::prepare`](catoptric::methods::Method::prepare); [`RenderError::Limit`] for what the device cannot
    /// draw: other numbers of samples than 1, 2, 4, 8 and 16, orders above 16, scenes beyond its limits.
    pub fn new(
        method: &DeviceMethod,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let prepared = method.prepare_scene(scene, quality, bake, progress)?;
        Ok(Self { prepared, display: Display::default() })
    }

    /// The exposure and tone curve of what is drawn from now on, into targets and as [`Encoding::Srgba8`]; pictures in
    /// linear colours have none. At first radiance is drawn as it is.
    pub fn set_display(&mut self, display: Display) {
        self.display = display;
    }

    /// Replaces the scene after something has moved or changed; what holds is kept, and what moves is written in place:
    /// what was drawn before must have been submitted.
    ///
    /// # Errors
    /// As [`Self::new`]; the earlier scene stays then.
    pub fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        self.prepared.update(scene, quality, progress)
    }

    /// Times, counts and warnings of loading the scene.
    pub fn report(&self) -> &Report {
        self.prepared.report()
    }

    /// Where every vertex of the scene appears in the reflectors of a view, by the method's own search, made exact by
    /// Newton's method in single precision: to about 0.01 pixels. What hides vertices on their way is not looked at.
    /// Waits for the device. `None` for methods and scenes whose vertices the processor projects
    /// ([`Frame::projector`](catoptric::methods::Frame::projector)).
    ///
    /// # Errors
    /// [`RenderError::Limit`] where the device fails.
    pub fn vertex_appearances(&mut self, view: &View) -> Result<Option<Vec<VertexAppearance>>, RenderError> {
        self.prepared.vertex_appearances(view)
    }

    /// Draws a view into a picture of its size, and waits for it.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn read(
        &mut self,
        view: &View,
        target: &mut Framebuffer,
        progress: &dyn Progress,
    ) -> Result<Report, RenderError> {
        let frame = self.prepared.device_frame(view, progress)?;
        let mut report = Frame::report(&frame).clone();
        report.add(frame.draw(target, progress)?);
        Ok(report)
    }

    /// Begins to draw a view and to read it, and waits for nothing: for programs that must not, as in browsers. Other
    /// views may be drawn meanwhile.
    ///
    /// # Errors
    /// As [`Self::draw`]; [`RenderError::Limit`] for views without pixels.
    pub fn begin_reading(
        &mut self,
        view: &View,
        encoding: Encoding,
        progress: &dyn Progress,
    ) -> Result<Reading, RenderError> {
        if view.width == 0 || view.height == 0 {
            let problem = "the view has no pixels".into();
            return Err(RenderError::Limit { method: self.prepared.method.info().id, problem });
        }
        let frame = self.prepared.device_frame(view, progress)?;
        let mut reading = frame.begin_reading((encoding, self.display), progress)?;
        let of_drawing = std::mem::replace(&mut reading.drawing.report, Frame::report(&frame).clone());
        reading.drawing.report.add(of_drawing);
        Ok(reading)
    }

    /// Adds the drawing of a view to `encoder`, into a target of the view's size that can be rendered to. Colours are
    /// linear; targets of an sRGB format encode them. Methods that project may find geometry on the processor
    /// meanwhile.
    ///
    /// # Errors
    /// [`RenderError::Limit`] for views that are too large, and where the device fails; [`RenderError::Cancelled`].
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        (target, format): (&wgpu::TextureView, TextureFormat),
        progress: &dyn Progress,
    ) -> Result<Report, RenderError> {
        if view.width == 0 || view.height == 0 {
            return Ok(Report::default());
        }
        let (context, display) = (self.prepared.method.context().clone(), self.display);
        let frame = self.prepared.device_frame(view, progress)?;
        let mut report = Frame::report(&frame).clone();
        let drawing = frame.encode(encoder, &mut Timer::none(), progress)?;
        drawing.present(&context, encoder, display, (target, format));
        context.check().map_err(|error| frame.failed(&error))?;
        report.add(drawing.report);
        Ok(report)
    }
}
