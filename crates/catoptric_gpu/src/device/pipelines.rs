//! The pipelines of all passes, made once a device.

use super::frame::confined::ConfinedPipelines;
use super::frame::rough::{self, RoughPipelines};
use super::frame::samples::SumPipelines;
use super::frame::tiles::TilePipelines;
use super::frame::virtual_mesh::VirtualPipelines;
use super::frame::{fields, layers, lists, mirrors};
use super::kept::Kept;
use crate::shader;
use crate::tables::SceneFeatures;
use wgpu::{BindingType, BufferBindingType, ShaderStages, TextureFormat, TextureSampleType, TextureViewDimension};

/// Triangles' numbers, in two halves: 32 bits in one number cannot be antialiased.
pub(crate) const ID_FORMAT: TextureFormat = TextureFormat::Rg16Uint;
/// Linear colours.
pub(crate) const COLOR_FORMAT: TextureFormat = TextureFormat::Rgba32Float;
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// The numbers of samples a pixel that devices draw at once.
pub(crate) const SAMPLE_COUNTS: [u32; 2] = [1, 4];

/// Rays for each sample where light is looked up on surfaces that spread it, as on the processor.
const RAYS_A_SAMPLE: f64 = 16.0;

/// Pipelines for one number of samples a pixel.
#[derive(Debug)]
pub(crate) struct SamplePipelines {
    /// Triangles without holes.
    pub(crate) solid: wgpu::RenderPipeline,
    /// Those whose alpha is tested.
    pub(crate) with_holes: wgpu::RenderPipeline,
}

/// A way to shade pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Shading {
    /// The shader's function.
    pub(crate) entry: &'static str,
    pub(crate) samples: u32,
    pub(crate) features: SceneFeatures,
    /// There are paths longer than those that tiles follow.
    pub(crate) traces: bool,
    pub(crate) meeting: Meeting,
}

/// What becomes of light at mirrors and glass that a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Meeting {
    /// Paths are followed, or end.
    Followed,
    /// It is looked up in environment maps.
    Maps,
    /// It is looked up in light fields.
    Fields,
    /// It is looked up in layers.
    Layers,
}

/// All pipelines.
#[derive(Debug)]
pub(crate) struct Pipelines {
    /// The scene's tables.
    pub(crate) scene: wgpu::BindGroupLayout,
    /// The hierarchy.
    pub(crate) hierarchy: wgpu::BindGroupLayout,
    /// The order in which triangles are drawn.
    pub(crate) order: wgpu::BindGroupLayout,
    /// What rays hit, and the colours.
    pub(crate) picture: wgpu::BindGroupLayout,
    pub(crate) tiles: TilePipelines,
    /// Grids that tell what rough mirrors reflect.
    pub(crate) rough: RoughPipelines,
    /// Sums of samples that are drawn one after the other.
    pub(crate) sums: SumPipelines,
    /// Those of mirrored scenes, and of virtual geometry.
    pub(crate) mirrors: ConfinedPipelines,
    pub(crate) lists: ConfinedPipelines,
    /// What smooth reflectors show, found on the device.
    pub(crate) virtual_mesh: VirtualPipelines,
    /// Environment maps.
    pub(crate) maps: wgpu::BindGroupLayout,
    /// Light fields, with environment maps.
    pub(crate) fields: wgpu::BindGroupLayout,
    /// Layered environment maps.
    pub(crate) layers: wgpu::BindGroupLayout,
    /// For [`Meeting`]s.
    shading: [wgpu::PipelineLayout; 4],
    /// For each of [`SAMPLE_COUNTS`].
    pub(crate) samples: [SamplePipelines; 2],
    /// Colours to be drawn to a target.
    pub(crate) colors: wgpu::BindGroupLayout,
    /// For [`Meeting`]s.
    shaders: [wgpu::ShaderModule; 4],
    present: wgpu::ShaderModule,
    /// Those that draw to targets, by their formats.
    presenting: Kept<TextureFormat, wgpu::RenderPipeline>,
    shade: Kept<Shading, wgpu::ComputePipeline>,
}

impl Pipelines {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let everywhere = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let shades = ShaderStages::COMPUTE;
        let numbers = |binding| texture(binding, TextureSampleType::Float { filterable: false }, false);
        let scene = layout(
            device,
            "scene",
            everywhere,
            &[
                (0, uniform(true)),
                table(1),
                table(2),
                table(3),
                table(4),
                table(5),
                numbers(6),
                numbers(7),
                numbers(8),
                (9, uniform(false)),
            ],
        );
        let hierarchy = layout(device, "hierarchy", shades, &[table(0), table(1), table(2)]);
        let order = layout(device, "order", ShaderStages::VERTEX, &[storage(0)]);
        let of_picture: Vec<_> = [storage(0), written(1), storage(2)].into_iter().chain(rough::READ).collect();
        let picture = layout(device, "picture", shades, &of_picture);
        let tiles = TilePipelines::new(device, &scene, &hierarchy);
        let rough = RoughPipelines::new(device, &scene, &hierarchy);
        let [mirrors, lists] =
            [mirrors::KIND, lists::KIND].map(|kind| ConfinedPipelines::new(device, kind, &scene, &order));
        let virtual_mesh = VirtualPipelines::new(device, &scene);
        let module = |path: &str| shader_module(device, path);
        let colors = layout(device, "colours", ShaderStages::FRAGMENT, &[numbers(0), (1, uniform(false))]);
        let shaders = ["frame.wgsl", "look.wgsl", "field.wgsl", "layered.wgsl"].map(module);
        let [visibility, present] = ["visibility.wgsl", "present.wgsl"].map(module);
        let drawing = pipeline_layout(device, &[&scene, &order]);
        let samples = [0, 1].map(|index| {
            let (module, layout, samples) = (&visibility, &drawing, SAMPLE_COUNTS[index]);
            let draws = |vertex, fragment| {
                let (corners, format, has_depth) = (None, ID_FORMAT, true);
                draws(
                    device,
                    &Draws { module, layout, vertex, corners, fragment, format, samples, has_depth, constants: &[] },
                )
            };
            SamplePipelines { solid: draws("solid_corner", "solid"), with_holes: draws("corner", "with_holes") }
        });
        let of_maps = [table(0), numbers(1)];
        let maps = layout(device, "maps", shades, &of_maps);
        let of_fields: Vec<_> = of_maps.into_iter().chain(fields::BINDINGS).collect();
        let fields = layout(device, "light fields", shades, &of_fields);
        let layers = layout(device, "layers", shades, &layers::BINDINGS);
        let shading = [
            pipeline_layout(device, &[&scene, &hierarchy, &picture]),
            pipeline_layout(device, &[&scene, &hierarchy, &picture, &maps]),
            pipeline_layout(device, &[&scene, &hierarchy, &picture, &fields]),
            pipeline_layout(device, &[&scene, &hierarchy, &picture, &layers]),
        ];
        let (shade, presenting) = (Kept::default(), Kept::default());
        Self {
            scene,
            hierarchy,
            order,
            picture,
            tiles,
            rough,
            sums: SumPipelines::new(device),
            mirrors,
            lists,
            virtual_mesh,
            maps,
            fields,
            layers,
            shading,
            samples,
            colors,
            shaders,
            present,
            presenting,
            shade,
        }
    }

    /// The pipeline that shades pixels in a way.
    pub(crate) fn shade(&self, device: &wgpu::Device, how: Shading) -> wgpu::ComputePipeline {
        let Shading { entry, samples, features, traces, meeting } = how;
        self.shade.get(how, || {
            let (layout, module) = (&self.shading[meeting as usize], &self.shaders[meeting as usize]);
            let mut constants = features.constants();
            constants.push(("SAMPLES", f64::from(samples)));
            if meeting != Meeting::Maps {
                constants.push(("TRACES", if traces { 1.0 } else { 0.0 }));
            }
            if matches!(meeting, Meeting::Fields | Meeting::Layers) {
                constants.push(("RAYS_A_SAMPLE", RAYS_A_SAMPLE));
            }
            if meeting == Meeting::Layers {
                constants.push(("TWO_PATHS", 1.0));
            }
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(layout),
                module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                cache: None,
            })
        })
    }

    /// The pipeline that draws colours to targets of a format.
    pub(crate) fn present(&self, device: &wgpu::Device, format: TextureFormat) -> wgpu::RenderPipeline {
        self.presenting.get(format, || {
            let layout = pipeline_layout(device, &[&self.colors]);
            let (module, compilation_options) = (&self.present, wgpu::PipelineCompilationOptions::default());
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("present"),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("whole_target"),
                    compilation_options: compilation_options.clone(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some("color"),
                    compilation_options,
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })
    }
}

/// A table, as it is read.
pub(crate) const fn table(binding: u32) -> (u32, BindingType) {
    texture(binding, TextureSampleType::Uint, false)
}

/// The colours, as they are written.
pub(crate) fn written(binding: u32) -> (u32, BindingType) {
    let access = wgpu::StorageTextureAccess::WriteOnly;
    (binding, BindingType::StorageTexture { access, format: COLOR_FORMAT, view_dimension: TextureViewDimension::D2 })
}

/// A record.
pub(crate) const fn uniform(has_dynamic_offset: bool) -> BindingType {
    BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset, min_binding_size: None }
}

pub(crate) const fn storage(binding: u32) -> (u32, BindingType) {
    buffer(binding, true)
}

/// A storage buffer that is written, too.
pub(crate) fn written_storage(binding: u32) -> (u32, BindingType) {
    buffer(binding, false)
}

const fn buffer(binding: u32, read_only: bool) -> (u32, BindingType) {
    let ty = BufferBindingType::Storage { read_only };
    (binding, BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None })
}

pub(crate) const fn texture(binding: u32, sample_type: TextureSampleType, multisampled: bool) -> (u32, BindingType) {
    (binding, BindingType::Texture { sample_type, view_dimension: TextureViewDimension::D2, multisampled })
}

/// Several pictures of one size.
pub(crate) const fn array_texture(binding: u32, sample_type: TextureSampleType) -> (u32, BindingType) {
    let view_dimension = TextureViewDimension::D2Array;
    (binding, BindingType::Texture { sample_type, view_dimension, multisampled: false })
}

/// A shader with all that it includes.
pub(crate) fn shader_module(device: &wgpu::Device, path: &str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(shader::source(path).into());
    device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(path), source })
}

pub(crate) fn layout(
    device: &wgpu::Device,
    label: &str,
    visibility: ShaderStages,
    bindings: &[(u32, BindingType)],
) -> wgpu::BindGroupLayout {
    let entry =
        |&(binding, ty): &(u32, BindingType)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = bindings.iter().map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

pub(crate) fn pipeline_layout(device: &wgpu::Device, groups: &[&wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(|group| Some(*group)).collect();
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

/// How triangles' numbers are drawn. Depth is reversed: 1 at the near plane, 0 infinitely far away.
pub(crate) struct Draws<'a> {
    pub(crate) module: &'a wgpu::ShaderModule,
    pub(crate) layout: &'a wgpu::PipelineLayout,
    pub(crate) vertex: &'a str,
    /// What corners are read from, if not from the scene.
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
