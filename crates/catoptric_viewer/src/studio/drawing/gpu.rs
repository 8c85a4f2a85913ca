//! The graphics processor that draws, where there is one: the window's own.

use catoptric::error::RenderError;
use catoptric::methods::{Quality, Report};
use catoptric::progress::Progress;
use catoptric::scene::{Scene, View};
use catoptric_bake::BakeChoice;
use catoptric_gpu::{Context, DeviceMethod, GpuError, Renderer};
use std::sync::Arc;
use wgpu::{TextureFormat, TextureUsages};

/// A graphics processor.
#[derive(Clone, Debug)]
pub struct Gpu {
    context: Arc<Context>,
    /// True if this is the window's own device: its textures are shown without a copy, and it is waited for.
    is_window_s: bool,
}

impl Gpu {
    /// The window's device.
    ///
    /// # Errors
    /// [`GpuError::Device`] if its driver refuses the shaders.
    pub fn of_window(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, GpuError> {
        Ok(Self { context: Context::sharing(adapter, device, queue)?, is_window_s: true })
    }

    /// A device of the studio's own. Pictures are read from it, and nothing waits for it: browsers do not let
    /// programs wait.
    pub fn apart(context: Arc<Context>) -> Self {
        Self { context, is_window_s: false }
    }

    /// The name of the adapter, with the interface through which it is used.
    pub fn name(&self) -> String {
        let Some(adapter) = self.context.adapter() else { return "GPU".into() };
        match (adapter.name.as_str(), adapter.backend.as_str()) {
            // Browsers keep names to themselves.
            ("", "BrowserWebGpu") => "WebGPU".into(),
            (name, "BrowserWebGpu") => format!("{name} (WebGPU)"),
            (name, backend) => format!("{name} ({backend})"),
        }
    }

    /// A scene ready to be drawn by a method; `None` for methods that draw on the CPU alone.
    pub(super) fn prepare(
        &self,
        id: &str,
        BakeChoice { settings, bake, .. }: &BakeChoice,
        scene: &Arc<Scene>,
        quality: Quality,
        progress: &dyn Progress,
    ) -> Result<Option<DeviceScene>, RenderError> {
        let method: Option<DeviceMethod> = catoptric_gpu::create(&self.context, id, settings)?;
        let Some(method) = method else { return Ok(None) };
        let renderer = Renderer::new(&method, scene, quality, bake.clone(), progress)?;
        Ok(Some(DeviceScene { context: self.context.clone(), renderer, waits: self.is_window_s }))
    }
}

/// A scene on a device.
pub(super) struct DeviceScene {
    context: Arc<Context>,
    pub(super) renderer: Renderer,
    /// True if the device may be waited for.
    pub(super) waits: bool,
}

impl DeviceScene {
    /// Draws a view into a texture, 8-bit sRGB, and waits until that is done.
    pub(super) fn texture(
        &mut self,
        view: &View,
        progress: &dyn Progress,
    ) -> Result<(wgpu::Texture, Report), RenderError> {
        let (device, queue) = (self.context.device(), self.context.queue());
        // The window reads the bytes as they are.
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width: view.width, height: view.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TextureFormat::Rgba8Unorm,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
            view_formats: &[TextureFormat::Rgba8UnormSrgb],
        });
        let format = TextureFormat::Rgba8UnormSrgb;
        let encoded = wgpu::TextureViewDescriptor { format: Some(format), ..Default::default() };
        let target = texture.create_view(&encoded);
        let mut encoder = device.create_command_encoder(&Default::default());
        let report = self.renderer.draw(&mut encoder, view, (&target, format), progress)?;
        queue.submit([encoder.finish()]);
        // Waiting keeps frames from piling up, and makes their times known.
        let waited = device.poll(wgpu::PollType::wait_indefinitely());
        let failed = |problem: String| RenderError::Limit { method: "gpu", problem };
        waited.map_err(|error| failed(error.to_string()))?;
        self.context.check().map_err(|error| failed(error.to_string()))?;
        Ok((texture, report))
    }
}
