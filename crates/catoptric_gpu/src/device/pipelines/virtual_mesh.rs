//! Pipelines that find what smooth reflectors show.

use super::bindings::{layout, texture, uniform, written_storage};
use super::kept::Kept;
use super::making::{Draws, compute, draws, pipeline_layout, shader_module};
use crate::tables::SceneFeatures;
use wgpu::{BindGroupLayout, ComputePipeline, RenderPipeline, ShaderStages, TextureFormat, TextureSampleType};

/// The format of a reflector's own picture: numbers of triangles, plus 1.
pub(crate) const PICTURE_FORMAT: TextureFormat = TextureFormat::R32Uint;
/// The format of explosion maps: places of the picture, and 1.
pub(crate) const MAP_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// A step of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Step {
    /// The rays from which searches begin.
    Rays,
    /// Before the first piece of a reflector.
    Begin,
    /// Where vertices appear.
    Vertices,
    /// Triangles become pieces.
    Pieces,
    /// Between rounds.
    Arrange,
    /// A round of division.
    Divide,
    /// The arguments with which the reflector's pieces are drawn.
    End,
}

impl Step {
    /// The module's place, and the shader's function.
    fn entry(self) -> (usize, &'static str) {
        match self {
            Self::Rays => (0, "take_rays"),
            Self::Vertices => (0, "project_vertices"),
            Self::Pieces => (0, "start_pieces"),
            Self::Begin => (1, "begin"),
            Self::Arrange => (1, "arrange"),
            Self::Divide => (1, "divide"),
            Self::End => (1, "end"),
        }
    }
}

/// The pipelines.
#[derive(Debug)]
pub(crate) struct VirtualPipelines {
    /// A reflector's record, for its own picture.
    pub(crate) drawing: BindGroupLayout,
    /// A reflector's record, its picture and the tables.
    pub(crate) working: BindGroupLayout,
    pub(crate) picture: RenderPipeline,
    /// Explosion maps of the near and of the far sphere.
    pub(crate) maps: [RenderPipeline; 2],
    layout: wgpu::PipelineLayout,
    /// The shaders of projection and of division.
    modules: [wgpu::ShaderModule; 2],
    /// By what scenes have, and whether searches begin at explosion maps.
    known: Kept<(SceneFeatures, bool, Step), ComputePipeline>,
}

impl VirtualPipelines {
    pub(crate) fn new(device: &wgpu::Device, scene: &BindGroupLayout) -> Self {
        let everywhere = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let drawing = layout(device, "a reflector", everywhere, &[(0, uniform(true))]);
        let tables = [(0, uniform(true)), texture(1, TextureSampleType::Uint, false)];
        let maps = [8, 9].map(|binding| texture(binding, TextureSampleType::Float { filterable: false }, false));
        let bindings: Vec<_> = tables.into_iter().chain((2..8).chain([10]).map(written_storage)).chain(maps).collect();
        let working = layout(device, "what a reflector shows", ShaderStages::COMPUTE, &bindings);
        let nothing = layout(device, "nothing", ShaderStages::COMPUTE, &[]);
        let module = |path: &str| shader_module(device, path);
        let [of_picture, of_maps] = ["virtual_mesh/reflector.wgsl", "virtual_mesh/explosion.wgsl"].map(module);
        let drawn = pipeline_layout(device, &[scene, &nothing, &drawing]);
        let draw = |module, [vertex, fragment]: [&str; 2], format, sphere: Option<u32>| {
            let constants: Vec<_> = sphere.map(|sphere| ("SPHERE", f64::from(sphere))).into_iter().collect();
            let (layout, corners, constants) = (&drawn, None, constants.as_slice());
            // Convex reflectors explode without overlaps.
            let has_depth = sphere.is_none();
            draws(
                device,
                &Draws { module, layout, vertex, corners, fragment, format, samples: 1, has_depth, constants },
            )
        };
        let picture = draw(&of_picture, ["reflector_corner", "reflector_number"], PICTURE_FORMAT, None);
        let maps = [0, 1].map(|sphere| draw(&of_maps, ["map_corner", "map_record"], MAP_FORMAT, Some(sphere)));
        let layout = pipeline_layout(device, &[scene, &nothing, &working]);
        let modules = ["virtual_mesh/project.wgsl", "virtual_mesh/divide.wgsl"].map(module);
        Self { drawing, working, picture, maps, layout, modules, known: Kept::default() }
    }

    /// The pipeline of a step for scenes with such features.
    pub(crate) fn get(
        &self,
        device: &wgpu::Device,
        features: SceneFeatures,
        from_maps: bool,
        step: Step,
    ) -> ComputePipeline {
        let features = features.of_rays();
        self.known.get((features, from_maps, step), || {
            let (module, entry) = step.entry();
            let mut constants = features.constants();
            constants.push(("FROM_MAPS", f64::from(u8::from(from_maps))));
            compute(device, &self.layout, &self.modules[module], entry, &constants)
        })
    }
}
