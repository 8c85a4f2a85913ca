//! Drawing into textures of the caller's, among other work: for engines and windows.

use super::context::Context;
use super::frame::VertexAppearance;
use super::frame::timer::Timer;
use super::method::{DeviceMethod, PreparedScene};
use super::upload::group;
use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::bake::Baked;
use catoptric::methods::{Frame, Prepared, Quality, Report};
use catoptric::progress::Progress;
use catoptric::scene::{Scene, View};
use std::sync::Arc;
use wgpu::{BindingResource, LoadOp, Operations, StoreOp, TextureFormat};

/// A scene on a device, drawn by a method into textures that the caller owns.
///
/// Work is added to an encoder of the caller's, and not waited for. The example `into_texture` has all of it.
pub struct Renderer {
    prepared: PreparedScene,
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
        Ok(Self { prepared: method.prepare_scene(scene, quality, bake, progress)? })
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
        let context = self.prepared.method.context().clone();
        let frame = self.prepared.device_frame(view, progress)?;
        let mut report = Frame::report(&frame).clone();
        let drawing = frame.encode(encoder, &mut Timer::none(), progress)?;
        let Context { device, pipelines, .. } = &*context;
        let colors = drawing.colors();
        let picture = group(device, &pipelines.colors, [(0, BindingResource::TextureView(&colors))]);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("present"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(wgpu::Color::BLACK), store: StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipelines.present(device, format));
        pass.set_bind_group(0, &picture, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        context.check().map_err(|error| frame.failed(&error))?;
        report.add(drawing.report);
        Ok(report)
    }
}
