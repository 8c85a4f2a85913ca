//! Pipelines of the sums of samples that are drawn one after the other.

use super::bindings::{layout, texture, written};
use super::kept::Kept;
use super::making::{pipeline_layout, shader_module};
use wgpu::{BindGroupLayout, ComputePipeline, ShaderStages, TextureSampleType};

/// Pipelines that add up the colours of parts.
#[derive(Debug)]
pub(crate) struct SumPipelines {
    pub(crate) layout: BindGroupLayout,
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
        let module = shader_module(device, "sum.wgsl");
        Self { layout, whole, module, known: Kept::default() }
    }

    /// The pipeline that adds one of so many parts, to those before if it goes on.
    pub(crate) fn get(&self, device: &wgpu::Device, parts: u32, goes_on: bool) -> ComputePipeline {
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
