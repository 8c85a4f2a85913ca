//! The making of pipelines: of shaders, of what they read, and of how they draw.

use super::formats::DEPTH_FORMAT;
use crate::shader;
use wgpu::{ComputePipeline, TextureFormat};

/// A shader with all that it includes.
pub(crate) fn shader_module(device: &wgpu::Device, path: &str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(shader::source(path).into());
    device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(path), source })
}

pub(crate) fn pipeline_layout(device: &wgpu::Device, groups: &[&wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

/// A pipeline that computes.
pub(crate) fn compute(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    entry: &str,
    constants: &[(&str, f64)],
) -> ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(layout),
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}

/// How triangles' numbers are drawn. Depth is reversed: 1 at the near plane, 0 infinitely far away.
pub(crate) struct Draws<'a> {
    pub(crate) module: &'a wgpu::ShaderModule,
    pub(crate) layout: &'a wgpu::PipelineLayout,
    pub(crate) vertex: &'a str,
    /// The layout of a buffer of corners; `None` where the shader reads corners from the scene.
    pub(crate) corners: Option<&'a wgpu::VertexBufferLayout<'a>>,
    pub(crate) fragment: &'a str,
    pub(crate) format: TextureFormat,
    pub(crate) samples: u32,
    /// The nearest is drawn, not the last.
    pub(crate) has_depth: bool,
    pub(crate) constants: &'a [(&'a str, f64)],
}

pub(crate) fn draws(device: &wgpu::Device, how: &Draws<'_>) -> wgpu::RenderPipeline {
    let Draws { module, layout, vertex, corners, fragment, format, samples, has_depth, constants } = *how;
    let buffers: Vec<_> = corners.into_iter().cloned().map(Some).collect();
    let compilation_options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: compilation_options.clone(),
            buffers: &buffers,
        },
        primitive: Default::default(),
        depth_stencil: has_depth.then(|| wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options,
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
