//! The textures that pictures are drawn to.

use super::timer::Timer;
use crate::device::context::Context;
use crate::device::pipelines::{COLOR_FORMAT, CONFINED_FORMAT, DEPTH_FORMAT, ID_FORMAT};
use crate::device::scene::DeviceScene;
use crate::error::GpuError;
use wgpu::{LoadOp, Operations, StoreOp, Texture, TextureFormat, TextureUsages, TextureView};

/// The textures that a view is drawn to.
#[derive(Debug)]
pub(crate) struct Targets {
    /// Hits at what is seen directly.
    pub(crate) ids: TextureView,
    pub(crate) colors: Texture,
    depth: TextureView,
    /// Hits at what is seen on the paths that hardware draws, shorter ones first.
    pub(crate) drawn: Vec<TextureView>,
}

impl Targets {
    /// Textures for views of a size, and for what is seen on so many paths.
    pub(super) fn new(context: &Context, size: [u32; 2], samples: u32, paths: usize) -> Result<Self, GpuError> {
        let [width, height] = size;
        let allowed = context.device.limits().max_texture_dimension_2d;
        if width > allowed || height > allowed {
            return Err(GpuError::Limit {
                what: "the picture".into(),
                needed: format!("{width} x {height} pixels"),
                allowed: format!("{allowed} a side"),
                remedy: "make it smaller, or use the CPU backend",
            });
        }
        let target = |label, format: TextureFormat, sample_count, usage| {
            context.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attached = TextureUsages::RENDER_ATTACHMENT;
        let read = attached | TextureUsages::TEXTURE_BINDING;
        let ids = target("triangles seen", ID_FORMAT, samples, read);
        let drawn = (0..paths).map(|_| target("triangles on a path", CONFINED_FORMAT, samples, read));
        let drawn = drawn.map(|texture| texture.create_view(&Default::default())).collect();
        let depth = target("depth", DEPTH_FORMAT, samples, attached);
        let used = TextureUsages::STORAGE_BINDING
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC
            | TextureUsages::COPY_DST;
        let colors = target("colours", COLOR_FORMAT, 1, used);
        context.check()?;
        let [ids, depth] = [ids, depth].map(|texture| texture.create_view(&Default::default()));
        Ok(Self { ids, colors, depth, drawn })
    }

    /// Begins to draw hits into one of the textures, where nothing is seen yet.
    pub(crate) fn begin<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        view: &TextureView,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> wgpu::RenderPass<'a> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("hits"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(wgpu::Color::TRANSPARENT), store: StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes,
            ..Default::default()
        })
    }

    /// Draws the triangles that are seen directly.
    pub(crate) fn draw_ids(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        scene: &DeviceScene,
        index: usize,
        timer: &mut Timer,
    ) {
        let pipelines = &context.pipelines.samples[index];
        let mut pass = self.begin(encoder, &self.ids, timer.render("seen"));
        pass.set_bind_group(0, &scene.scene, &[0]);
        pass.set_bind_group(1, &scene.order, &[]);
        let solid = scene.solid_count * 3;
        pass.set_pipeline(&pipelines.solid);
        pass.draw(0..solid, 0..1);
        if scene.triangle_count > scene.solid_count {
            pass.set_pipeline(&pipelines.with_holes);
            pass.draw(solid..scene.triangle_count * 3, 0..1);
        }
    }
}
