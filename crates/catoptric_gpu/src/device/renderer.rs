//! Drawing into textures of the caller's, among other work: for engines and windows.

use super::context::Context;
use super::frame::timer::Timer;
use super::frame::{self, Sight};
use super::upload::{DeviceScene, Reflections, group};
use crate::error::GpuError;
use catoptric::methods::Quality;
use catoptric::scene::{Scene, View};
use std::sync::Arc;
use wgpu::{BindingResource, LoadOp, Operations, StoreOp, TextureFormat};

/// A scene on a device, drawn by `multiperspective` into textures that the caller owns.
///
/// Nothing is waited for: work is added to an encoder of the caller's. The example `into_texture` has all of it.
#[derive(Debug)]
pub struct Renderer {
    context: Arc<Context>,
    scene: Arc<Scene>,
    resident: DeviceScene,
}

impl Renderer {
    /// Loads a scene. Its lights cast shadows if it has been given them
    /// ([`cast_shadows`](catoptric::light::visibility::cast_shadows)).
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] and [`GpuError::Limit`] for scenes that cannot be drawn, [`GpuError::Device`].
    pub fn new(context: &Arc<Context>, scene: &Arc<Scene>) -> Result<Self, GpuError> {
        let resident = DeviceScene::new(context, scene, None, Reflections::Followed)?;
        Ok(Self { context: context.clone(), scene: scene.clone(), resident })
    }

    /// Replaces the scene after something has moved or changed; textures and environments that stay are kept.
    ///
    /// # Errors
    /// As [`Self::new`]; the earlier scene stays then.
    pub fn update(&mut self, scene: &Arc<Scene>) -> Result<(), GpuError> {
        self.resident = DeviceScene::new(&self.context, scene, Some(&self.resident), Reflections::Followed)?;
        self.scene = scene.clone();
        Ok(())
    }

    /// Adds the drawing of a view to `encoder`, into a target of the view's size that can be rendered to. Colours are
    /// linear; targets of an sRGB format encode them.
    ///
    /// # Errors
    /// [`GpuError::Limit`] for other numbers of samples than 1 and 4, for orders above 8 and for views that are too
    /// large; [`GpuError::Device`].
    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        quality: Quality,
        target: &wgpu::TextureView,
        format: TextureFormat,
    ) -> Result<(), GpuError> {
        frame::check_quality(quality)?;
        if view.width == 0 || view.height == 0 {
            return Ok(());
        }
        let Context { device, pipelines, .. } = &*self.context;
        let sight = Sight { scene: &self.scene, view, quality, lists: None };
        let drawing = frame::encode(&self.context, &self.resident, sight, encoder, &mut Timer::none())?;
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
        self.context.check()
    }
}
