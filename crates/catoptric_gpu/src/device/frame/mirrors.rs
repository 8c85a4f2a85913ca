//! Flat mirrors: the scene mirrored in each, drawn by hardware where the mirror is seen.

use crate::device::context::Context;

use super::targets::Targets;
use super::timer::Timer;
use crate::device::pipelines::{Draws, draws, layout, pipeline_layout, table, texture};
use crate::device::upload::{DeviceScene, Upload, group};
use crate::error::GpuError;
use crate::layout::MirrorPath;
use crate::shader;
use catoptric::methods::projection::planar_mirror::{FlatMirrors, MirrorView, PlanarMirrorSettings};
use catoptric::methods::{Quality, Report};
use catoptric::scene::{Scene, View};
use glam::{DMat4, Mat4};
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::sync::{Mutex, PoisonError};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroupLayout, BindingResource, BindingType, BufferBindingType, BufferUsages};
use wgpu::{RenderPipeline, ShaderStages, TextureFormat, TextureSampleType, TextureView};

/// Hits in two halves, and the number of the path that they are on.
pub(crate) const MIRRORED_FORMAT: TextureFormat = TextureFormat::Rgba16Uint;
/// From record to record: offsets of uniform buffers are multiples of 256.
const STRIDE: usize = 256;
/// Numbers of paths have 16 bits.
const MOST_PATHS: usize = 65_535;

/// The pipelines that draw mirrored scenes.
#[derive(Debug)]
pub(crate) struct MirrorPipelines {
    /// A path, the mirrors of triangles, and what is seen one mirror before; for one sample a pixel, and for several.
    paths: [BindGroupLayout; 2],
    layouts: [wgpu::PipelineLayout; 2],
    module: wgpu::ShaderModule,
    /// By the place of the number of samples, and whether surfaces have holes.
    known: Mutex<HashMap<(usize, bool), RenderPipeline>>,
}

impl MirrorPipelines {
    pub(crate) fn new(device: &wgpu::Device, scene: &BindGroupLayout, order: &BindGroupLayout) -> Self {
        let record =
            BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: true, min_binding_size: None };
        let before = |binding, multisampled| texture(binding, TextureSampleType::Uint, multisampled);
        let paths = [before(2, false), before(3, true)]
            .map(|before| layout(device, "mirrors", ShaderStages::VERTEX_FRAGMENT, &[(0, record), table(1), before]));
        let layouts = [0, 1].map(|index| pipeline_layout(device, &[scene, order, &paths[index]]));
        let source = wgpu::ShaderSource::Wgsl(shader::source("mirrors.wgsl").into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("mirrors"), source });
        Self { paths, layouts, module, known: Mutex::default() }
    }

    fn get(&self, device: &wgpu::Device, index: usize, has_holes: bool) -> RenderPipeline {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let pipeline = known.entry((index, has_holes)).or_insert_with(|| {
            let (fragment, samples) = [("mirrored_one_sample", 1), ("mirrored_four_samples", 4)][index];
            let constants = [("HAS_HOLES", if has_holes { 1.0 } else { 0.0 })];
            let (module, layout, format) = (&self.module, &self.layouts[index], MIRRORED_FORMAT);
            let vertex = "mirrored_corner";
            draws(device, &Draws { module, layout, vertex, fragment, format, samples, constants: &constants })
        });
        pipeline.clone()
    }
}

/// The flat mirrors of a scene on a device.
#[derive(Debug)]
pub(crate) struct DeviceMirrors {
    mirrors: FlatMirrors,
    settings: PlanarMirrorSettings,
    /// The mirror of every triangle.
    table: TextureView,
}

impl DeviceMirrors {
    /// The flat mirrors of a scene, and a report of what is none.
    pub(crate) fn new(
        context: &Context,
        scene: &Scene,
        settings: &PlanarMirrorSettings,
    ) -> Result<(Self, Report), GpuError> {
        let (mirrors, report) = FlatMirrors::find(scene);
        let rows: Vec<[u32; 4]> = mirrors
            .mirror_of_triangle()
            .chunks(4)
            .map(|chunk| std::array::from_fn(|index| chunk.get(index).copied().unwrap_or_default()))
            .collect();
        let table = Upload { context, byte_count: 0 }.table("the mirrors of triangles", &rows)?;
        Ok((Self { mirrors, settings: settings.clone(), table }, report))
    }

    /// True for triangles that are part of a flat mirror.
    pub(crate) fn shows(&self, triangle: u32) -> bool {
        self.mirrors.mirror_of_triangle()[triangle as usize] != 0
    }

    /// Draws what a view shows after each number of mirrors. What has to be left out is added to a report.
    #[expect(clippy::too_many_arguments, reason = "a frame needs as many")]
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        resident: &DeviceScene,
        (scene, view, quality): (&Scene, &View, Quality),
        clip_from_world: Mat4,
        targets: &Targets,
        timer: &mut Timer,
        report: &mut Report,
    ) -> Result<(), GpuError> {
        let Context { device, pipelines, .. } = context;
        let mut views = self.mirrors.views(&self.settings, scene, view, quality.order, report);
        if views.len() > MOST_PATHS {
            report.add_fallback("lists_left_out", (views.len() - MOST_PATHS) as u64);
            views.truncate(MOST_PATHS);
        }
        report.counts.insert("lists", views.len() as u64 + 1);
        let mut records = Vec::with_capacity(views.len() * STRIDE);
        for (number, view) in (1..).zip(&views) {
            records.extend_from_slice(bytemuck::bytes_of(&record(view, number, clip_from_world)));
            records.resize(records.len().next_multiple_of(STRIDE), 0);
        }
        records.resize(records.len().max(STRIDE), 0);
        let (label, usage) = (Some("paths of mirrors"), BufferUsages::UNIFORM);
        let buffer = device.create_buffer_init(&BufferInitDescriptor { label, contents: &records, usage });
        let size = NonZeroU64::new(size_of::<MirrorPath>() as u64);
        let index = usize::from(quality.samples > 1);
        let mut last = &targets.ids;
        for (order, picture) in (1..).zip(&targets.mirrored) {
            let before = BindingResource::TextureView(last);
            let path = BindingResource::Buffer(wgpu::BufferBinding { buffer: &buffer, offset: 0, size });
            let table = BindingResource::TextureView(&self.table);
            let resources = [(0, path), (1, table), (2 + index as u32, before)];
            let group = group(device, &pipelines.mirrors.paths[index], resources);
            // Every sample is on one path of each order: all of them share the depth.
            let mut pass = targets.begin(encoder, picture, timer.render("mirrored"));
            pass.set_bind_group(0, &resident.scene, &[0]);
            pass.set_bind_group(1, &resident.order, &[]);
            let (solid, all) = (resident.solid_count * 3, resident.triangle_count * 3);
            for (has_holes, part) in [(false, 0..solid), (true, solid..all)] {
                if part.is_empty() {
                    continue;
                }
                pass.set_pipeline(&pipelines.mirrors.get(device, index, has_holes));
                for (place, _) in views.iter().enumerate().filter(|(_, view)| view.order == order) {
                    pass.set_bind_group(2, &group, &[(place * STRIDE) as u32]);
                    pass.draw(part.clone(), 0..1);
                }
            }
            last = picture;
        }
        context.check()
    }
}

fn record(view: &MirrorView, number: u32, clip_from_world: Mat4) -> MirrorPath {
    let clip_from_scene = (clip_from_world.as_dmat4() * DMat4::from(view.world_from_scene)).as_mat4();
    MirrorPath {
        clip_from_scene: clip_from_scene.to_cols_array_2d(),
        plane: view.plane.as_vec4().to_array(),
        mirror: view.mirror,
        parent: view.parent,
        number,
        unused: 0,
    }
}
