//! The showing of pictures: with an exposure and a tone curve, on targets of any format.

use super::context::Context;
use super::frame::Drawing;
use super::pipelines::group;
use bytemuck::{Pod, Zeroable};
use catoptric::tone::{Display, ToneCurve};
use wgpu::util::DeviceExt;
use wgpu::{BindingResource, BufferUsages, LoadOp, Operations, StoreOp, TextureFormat, TextureUsages};

/// As `present.wgsl` has it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct DisplayRecord {
    scale: f32,
    curve: u32,
    padding: [u32; 2],
}

impl From<Display> for DisplayRecord {
    fn from(display: Display) -> Self {
        let curve = match display.curve {
            ToneCurve::None => 0,
            ToneCurve::Neutral => 1,
            ToneCurve::Agx => 2,
            ToneCurve::Aces => 3,
        };
        Self { scale: display.scale(), curve, padding: [0; 2] }
    }
}

impl Drawing {
    /// Adds the drawing of the colours, as they are displayed, to a target of the same size.
    pub(crate) fn present(
        &self,
        context: &Context,
        encoder: &mut wgpu::CommandEncoder,
        display: Display,
        (target, format): (&wgpu::TextureView, TextureFormat),
    ) {
        let Context { device, pipelines, .. } = context;
        let colors = self.colors().create_view(&Default::default());
        let display = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("display"),
            contents: bytemuck::bytes_of(&DisplayRecord::from(display)),
            usage: BufferUsages::UNIFORM,
        });
        let bindings = [(0, BindingResource::TextureView(&colors)), (1, display.as_entire_binding())];
        let picture = group(device, &pipelines.colors, bindings);
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
    }

    /// Adds the drawing of the colours, as they are displayed, to a texture of 8-bit sRGB, which it returns.
    pub(crate) fn shown(
        &self,
        context: &Context,
        encoder: &mut wgpu::CommandEncoder,
        display: Display,
    ) -> wgpu::Texture {
        let format = TextureFormat::Rgba8UnormSrgb;
        let shown = context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shown"),
            size: self.colors().size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        self.present(context, encoder, display, (&shown.create_view(&Default::default()), format));
        shown
    }
}
