//! Pictures of other numbers of samples a pixel than devices draw at once: one sample after the other.

use super::tiles::{WORKGROUP, begin};
use super::timer::Timer;
use crate::device::context::Context;
use crate::device::kept::Kept;
use crate::device::pipelines::{COLOR_FORMAT, SAMPLE_COUNTS, layout, pipeline_layout, texture, written};
use crate::device::upload::group;
use crate::shader;
use catoptric::raster::sample_positions;

use wgpu::{
    BindGroupLayout, BindingResource, ComputePipeline, ShaderStages, Texture, TextureSampleType, TextureUsages,
};

/// A part of a pixel's samples, which is drawn at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// How many.
    pub(crate) samples: u32,
    /// The place of a single one from the pixel's corner.
    pub(crate) place: [f32; 2],
    /// The side of the square that a single one stands for, in pixels.
    pub(crate) side: f32,
    /// What is the same for all parts is found with it.
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

/// Pipelines that add up the colours of parts.
#[derive(Debug)]
pub(crate) struct SumPipelines {
    layout: BindGroupLayout,
    whole: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    /// By the number of parts, and whether there are some before.
    known: Kept<(u32, bool), ComputePipeline>,
}

impl SumPipelines {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let colors = |binding| texture(binding, TextureSampleType::Float { filterable: false }, false);
        let layout = layout(device, "sums", ShaderStages::COMPUTE, &[colors(0), colors(1), written(2)]);
        let whole = pipeline_layout(device, &[&layout]);
        let source = wgpu::ShaderSource::Wgsl(shader::source("sum.wgsl").into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("sum.wgsl"), source });
        Self { layout, whole, module, known: Kept::default() }
    }

    fn get(&self, device: &wgpu::Device, parts: u32, goes_on: bool) -> ComputePipeline {
        self.known.get((parts, goes_on), || {
            let constants = [("SHARE", 1.0 / f64::from(parts)), ("GOES_ON", if goes_on { 1.0 } else { 0.0 })];
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("add"),
                layout: Some(&self.whole),
                module: &self.module,
                entry_point: Some("add"),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                cache: None,
            })
        })
    }
}

/// The mean over the parts of a picture, while they are drawn.
pub(crate) struct Sums {
    textures: [Texture; 2],
    parts: u32,
    drawn: u32,
}

impl Sums {
    /// Of so many parts; `None` of a single one, which is the picture.
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
