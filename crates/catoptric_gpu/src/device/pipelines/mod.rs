//! The pipelines of all passes, made once a device.

mod bindings;
mod confined;
mod formats;
mod kept;
mod lookups;
mod making;
mod rough;
mod sums;
mod tiles;
mod virtual_mesh;

pub(crate) use bindings::group;
pub(crate) use formats::{COLOR_FORMAT, CONFINED_FORMAT, DEPTH_FORMAT, ID_FORMAT};
pub(crate) use rough::{BLUR, FIND_NEAR, FOLLOW, MARK, MEET, REDUCE};
pub(crate) use tiles::Pass;
pub(crate) use virtual_mesh::{MAP_FORMAT, PICTURE_FORMAT, Step};

use crate::tables::SceneFeatures;
use bindings::{layout, storage, table, texture, uniform, written};
use confined::{ConfinedPipelines, LISTS, MIRRORS};
use kept::Kept;
use lookups::{FIELDS, LAYERS};
use making::{Draws, draws, pipeline_layout, shader_module};
use rough::RoughPipelines;
use sums::SumPipelines;
use tiles::TilePipelines;
use virtual_mesh::VirtualPipelines;
use wgpu::{ShaderStages, TextureFormat, TextureSampleType};

/// The numbers of samples a pixel that devices draw at once.
pub(crate) const SAMPLE_COUNTS: [u32; 2] = [1, 4];

/// Rays for each sample where light is looked up on surfaces that spread it, as on the processor.
const RAYS_A_SAMPLE: f64 = 16.0;

/// Pipelines for one number of samples a pixel.
#[derive(Debug)]
pub(crate) struct SamplePipelines {
    /// Triangles without holes.
    pub(crate) solid: wgpu::RenderPipeline,
    /// Triangles whose alpha is tested.
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

/// How the light of mirrors and glass that a pixel shows is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Meeting {
    /// Paths are followed, or end.
    Followed,
    /// Light is looked up in environment maps.
    Maps,
    /// Light is looked up in light fields.
    Fields,
    /// Light is looked up in layers.
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
    /// The table of hits, the colours, and the light of rough mirrors.
    pub(crate) picture: wgpu::BindGroupLayout,
    pub(crate) tiles: TilePipelines,
    /// Grids that tell what rough mirrors reflect.
    pub(crate) rough: RoughPipelines,
    /// Sums of samples that are drawn one after the other.
    pub(crate) sums: SumPipelines,
    /// Pipelines that draw mirrored scenes, and virtual geometry.
    pub(crate) mirrors: ConfinedPipelines,
    pub(crate) lists: ConfinedPipelines,
    /// Pipelines that find on the device what smooth reflectors show.
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
    /// Pipelines that draw to targets, by the targets' formats.
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
        let [mirrors, lists] = [MIRRORS, LISTS].map(|kind| ConfinedPipelines::new(device, kind, &scene, &order));
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
        let of_fields: Vec<_> = of_maps.into_iter().chain(FIELDS).collect();
        let fields = layout(device, "light fields", shades, &of_fields);
        let layers = layout(device, "layers", shades, &LAYERS);
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
