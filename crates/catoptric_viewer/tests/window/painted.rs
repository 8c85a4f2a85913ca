//! The window's looks where the processor draws it, alone and beside a device.

use egui::{Context, FullOutput, TexturesDelta};
use egui_kittest::TestRenderer;
use egui_kittest::wgpu::WgpuTestRenderer;
use image::{RgbaImage, imageops};
use softbuffer_painter::Painter;

/// Draws as windows without a graphics driver are drawn.
#[derive(Default)]
pub(crate) struct Painted(Painter);

impl TestRenderer for Painted {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        self.0.update(delta);
        self.0.free(delta);
        delta.clear();
    }

    fn render(&mut self, ctx: &Context, output: &FullOutput) -> Result<RgbaImage, String> {
        let scale = ctx.pixels_per_point();
        let size = ctx.content_rect().size() * scale;
        let [width, height] = [size.x, size.y].map(|length| length.round() as u32);
        let mut pixels = vec![0; (width * height) as usize];
        let primitives = ctx.tessellate(output.shapes.clone(), scale);
        self.0.paint(&mut pixels, [width as usize, height as usize], scale, &primitives);
        let bytes = pixels.iter().flat_map(|pixel| {
            let [_, red, green, blue] = pixel.to_be_bytes();
            [red, green, blue, 255]
        });
        RgbaImage::from_raw(width, height, bytes.collect()).ok_or_else(|| "sizes do not agree".to_owned())
    }
}

/// Draws the same on a device, to the left, and on the processor, to the right.
pub(crate) struct Beside {
    pub(crate) device: WgpuTestRenderer,
    pub(crate) painted: Painted,
}

impl TestRenderer for Beside {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        self.painted.handle_delta(&mut delta.clone());
        self.device.handle_delta(delta);
    }

    fn render(&mut self, ctx: &Context, output: &FullOutput) -> Result<RgbaImage, String> {
        let [left, right] = [self.device.render(ctx, output)?, self.painted.render(ctx, output)?];
        let mut both = RgbaImage::new(left.width() + right.width(), left.height());
        imageops::replace(&mut both, &left, 0, 0);
        imageops::replace(&mut both, &right, i64::from(left.width()), 0);
        Ok(both)
    }
}
