//! Pictures of other numbers of samples a pixel than devices draw at once: one sample after the other.

use super::passes::{WORKGROUP, begin};
use super::timer::Timer;
use crate::device::context::Context;
use crate::device::pipelines::{COLOR_FORMAT, SAMPLE_COUNTS, group};
use catoptric::raster::sample_positions;
use wgpu::{BindingResource, Texture, TextureUsages};

/// A part of a pixel's samples, which is drawn at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// How many.
    pub(crate) samples: u32,
    /// The place of a single one from the pixel's corner.
    pub(crate) place: [f32; 2],
    /// The side of the square that a single one stands for, in pixels.
    pub(crate) side: f32,
    /// True for the first part: the values that all parts share are found with it.
    pub(crate) is_first: bool,
}

/// The parts of so many samples; none if devices cannot draw them.
pub(crate) fn parts_of(samples: u32) -> Vec<Part> {
    if SAMPLE_COUNTS.contains(&samples) {
        return vec![Part { samples, place: [0.5; 2], side: 1.0, is_first: true }];
    }
    let side = 1.0 / (samples as f32).sqrt();
    let part = |(number, place): (usize, &glam::Vec2)| Part {
        samples: 1,
        place: place.to_array(),
        side,
        is_first: number == 0,
    };
    sample_positions(samples).unwrap_or_default().iter().enumerate().map(part).collect()
}

/// The mean over the parts of a picture, while they are drawn.
pub(crate) struct Sums {
    textures: [Texture; 2],
    parts: u32,
    drawn: u32,
}

impl Sums {
    /// The mean of so many parts; `None` of a single one, which is the picture itself.
    pub(crate) fn new(context: &Context, [width, height]: [u32; 2], parts: usize) -> Option<Self> {
        let texture = || {
            context.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("sums of samples"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: COLOR_FORMAT,
                usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        (parts > 1).then(|| Self { textures: [texture(), texture()], parts: parts as u32, drawn: 0 })
    }

    /// Adds a part; after the last one the picture's colours are the mean.
    pub(crate) fn add(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        colors: &Texture,
        timer: &mut Timer,
    ) {
        let Context { device, pipelines, .. } = context;
        let place = (self.drawn % 2) as usize;
        let (sum, before) = (&self.textures[place], &self.textures[1 - place]);
        let views = [colors, before, sum].map(|texture| texture.create_view(&Default::default()));
        let group = group(device, &pipelines.sums.layout, (0..).zip(views.iter().map(BindingResource::TextureView)));
        {
            let mut pass = begin(encoder, timer.compute("sum of samples"));
            pass.set_pipeline(&pipelines.sums.get(device, self.parts, self.drawn > 0));
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(colors.width().div_ceil(WORKGROUP), colors.height().div_ceil(WORKGROUP), 1);
        }
        self.drawn += 1;
        if self.drawn == self.parts {
            encoder.copy_texture_to_texture(sum.as_image_copy(), colors.as_image_copy(), colors.size());
        }
    }
}
