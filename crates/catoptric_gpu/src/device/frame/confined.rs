//! What is drawn by hardware where a picture shows something: hits one event further.

use crate::device::context::Context;
use crate::device::kept::Kept;
use crate::device::pipelines::{Draws, draws, layout, pipeline_layout, texture, uniform};
use crate::device::upload::group;
use crate::shader;
use bytemuck::Pod;
use std::num::NonZeroU64;

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, Buffer, BufferUsages};
use wgpu::{RenderPipeline, ShaderStages, TextureFormat, TextureSampleType, TextureView, VertexBufferLayout};

/// Hits in two halves, and the number of the path that they are on.
pub(crate) const CONFINED_FORMAT: TextureFormat = TextureFormat::Rgba16Uint;
/// From record to record: offsets of uniform buffers are multiples of 256.
const STRIDE: usize = 256;
/// Numbers of paths have 16 bits.
pub(crate) const MOST_PATHS: usize = 65_535;

/// What is drawn so.
pub(crate) struct Kind {
    /// The shader.
    pub(crate) shader: &'static str,
    /// What it reads beside a path's record (binding 0) and what is seen before (2 or 3).
    pub(crate) table: Option<(u32, BindingType)>,
    /// What corners are read from, if not from the scene.
    pub(crate) corners: Option<VertexBufferLayout<'static>>,
}

/// Pipelines that draw one kind.
#[derive(Debug)]
pub(crate) struct ConfinedPipelines {
    /// For one sample a pixel, and for several.
    paths: [BindGroupLayout; 2],
    layouts: [wgpu::PipelineLayout; 2],
    module: wgpu::ShaderModule,
    corners: Option<VertexBufferLayout<'static>>,
    /// By the place of the number of samples, and whether surfaces have holes.
    known: Kept<(usize, bool), RenderPipeline>,
}

impl ConfinedPipelines {
    pub(crate) fn new(device: &wgpu::Device, kind: Kind, scene: &BindGroupLayout, order: &BindGroupLayout) -> Self {
        let Kind { shader: label, table, corners } = kind;
        let before = |binding, multisampled| texture(binding, TextureSampleType::Uint, multisampled);
        let paths = [before(2, false), before(3, true)].map(|before| {
            let bindings: Vec<_> = [(0, uniform(true)), before].into_iter().chain(table).collect();
            layout(device, label, ShaderStages::VERTEX_FRAGMENT, &bindings)
        });
        let layouts = [0, 1].map(|index| pipeline_layout(device, &[scene, order, &paths[index]]));
        let source = wgpu::ShaderSource::Wgsl(shader::source(label).into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source });
        Self { paths, layouts, module, corners, known: Kept::default() }
    }

    /// The pipeline for a place of the number of samples.
    pub(crate) fn get(&self, device: &wgpu::Device, index: usize, has_holes: bool) -> RenderPipeline {
        self.known.get((index, has_holes), || {
            let (fragment, samples) = [("confined_one_sample", 1), ("confined_four_samples", 4)][index];
            let constants = [("HAS_HOLES", if has_holes { 1.0 } else { 0.0 })];
            let (module, layout, format) = (&self.module, &self.layouts[index], CONFINED_FORMAT);
            let (vertex, corners) = ("confined_corner", self.corners.as_ref());
            let (has_depth, constants) = (true, &constants);
            draws(device, &Draws { module, layout, vertex, corners, fragment, format, samples, has_depth, constants })
        })
    }

    /// What a pass reads: records of paths, a table if there is one, and what is seen before.
    pub(crate) fn group(
        &self,
        context: &Context,
        index: usize,
        records: &PathRecords,
        table: Option<(u32, BindingResource<'_>)>,
        before: &TextureView,
    ) -> BindGroup {
        let record = wgpu::BufferBinding { buffer: &records.buffer, offset: 0, size: NonZeroU64::new(records.size) };
        let resources =
            [(0, BindingResource::Buffer(record)), (2 + index as u32, BindingResource::TextureView(before))];
        group(&context.device, &self.paths[index], resources.into_iter().chain(table))
    }
}

/// A record for each path on a device.
pub(crate) struct PathRecords {
    buffer: Buffer,
    /// Of one record.
    size: u64,
}

impl PathRecords {
    pub(crate) fn new<T: Pod>(device: &wgpu::Device, records: impl IntoIterator<Item = T>) -> Self {
        let mut bytes = Vec::new();
        for record in records {
            bytes.extend_from_slice(bytemuck::bytes_of(&record));
            bytes.resize(bytes.len().next_multiple_of(STRIDE), 0);
        }
        bytes.resize(bytes.len().max(STRIDE), 0);
        let (label, usage) = (Some("paths"), BufferUsages::UNIFORM);
        let buffer = device.create_buffer_init(&BufferInitDescriptor { label, contents: &bytes, usage });
        Self { buffer, size: size_of::<T>() as u64 }
    }

    /// The dynamic offset of a record.
    pub(crate) fn offset(index: usize) -> u32 {
        (index * STRIDE) as u32
    }
}
