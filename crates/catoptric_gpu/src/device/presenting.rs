//! What was drawn as it is shown: on targets of any format.

use super::context::Context;
use super::frame::Drawing;
use super::upload::group;
use wgpu::{BindingResource, LoadOp, Operations, StoreOp, TextureFormat, TextureUsages};

impl Drawing {
    /// Adds the copying of the colours to a target of the same size.
    pub(crate) fn present(
        &self,
        context: &Context,
        encoder: &mut wgpu::CommandEncoder,
        (target, format): (&wgpu::TextureView, TextureFormat),
    ) {
        let Context { device, pipelines, .. } = context;
        let colors = self.colors().create_view(&Default::default());
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
    }

    /// Adds the copying of the colours to a texture of 8-bit sRGB, which it returns.
    pub(crate) fn shown(&self, context: &Context, encoder: &mut wgpu::CommandEncoder) -> wgpu::Texture {
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
        self.present(context, encoder, (&shown.create_view(&Default::default()), format));
        shown
    }
}
