//! Pipelines that draw by hardware where a picture shows something: hits one event further.

use super::bindings::{group, layout, table, texture, uniform};
use super::formats::CONFINED_FORMAT;
use super::kept::Kept;
use super::making::{Draws, draws, pipeline_layout, shader_module};
use crate::layout::ListCorner;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, RenderPipeline, ShaderStages};
use wgpu::{TextureSampleType, TextureView, VertexAttribute, VertexBufferLayout, VertexStepMode, vertex_attr_array};

/// A kind of geometry that is drawn where a picture shows something.
pub(crate) struct Kind {
    /// The shader.
    pub(crate) shader: &'static str,
    /// The table that the shader reads beside a path's record (binding 0) and the picture before it (2 or 3).
    pub(crate) table: Option<(u32, BindingType)>,
    /// The layout of a buffer of corners; `None` where the shader reads corners from the scene.
    pub(crate) corners: Option<VertexBufferLayout<'static>>,
}

const ATTRIBUTES: [VertexAttribute; 4] = vertex_attr_array![0 => Float32x4, 1 => Float32x2, 2 => Uint32, 3 => Uint32];

/// How virtual geometry is drawn.
pub(crate) const LISTS: Kind = Kind {
    shader: "lists.wgsl",
    table: None,
    corners: Some(VertexBufferLayout {
        array_stride: size_of::<ListCorner>() as u64,
        step_mode: VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }),
};

/// How mirrored scenes are drawn: with the mirrors of triangles.
pub(crate) const MIRRORS: Kind = Kind { shader: "mirrors.wgsl", table: Some(table(1)), corners: None };

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
        let module = shader_module(device, label);
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

    /// The bindings of a pass: one of several records of paths, a table if there is one, and the picture of what is
    /// seen before.
    pub(crate) fn group(
        &self,
        device: &wgpu::Device,
        index: usize,
        record: BindingResource<'_>,
        table: Option<(u32, BindingResource<'_>)>,
        before: &TextureView,
    ) -> BindGroup {
        let resources = [(0, record), (2 + index as u32, BindingResource::TextureView(before))];
        group(device, &self.paths[index], resources.into_iter().chain(table))
    }
}
