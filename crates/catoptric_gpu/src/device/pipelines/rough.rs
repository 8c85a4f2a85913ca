//! Pipelines of the passes that trace and blur what rough mirrors reflect.

use super::bindings::{layout, storage, uniform, written_storage};
use super::kept::Kept;
use super::making::{pipeline_layout, shader_module};
use crate::tables::SceneFeatures;
use wgpu::{BindGroupLayout, BindingType, ComputePipeline, ShaderStages};

/// Where shaders that shade pixels read the light of cells, and the grids.
pub(crate) const READ: [(u32, BindingType); 2] = [storage(3), (5, uniform(false))];

/// The pipelines of grids.
#[derive(Debug)]
pub(crate) struct RoughPipelines {
    pub(crate) tables: BindGroupLayout,
    pub(crate) marking: BindGroupLayout,
    /// The layouts of passes over grids, and of the marking of hits.
    layouts: [wgpu::PipelineLayout; 2],
    /// The shaders of rays, of means, and of the marking of hits.
    modules: [wgpu::ShaderModule; 3],
    /// By entries, what scenes have, and samples.
    known: Kept<(&'static str, SceneFeatures, u32), ComputePipeline>,
}

/// The passes over a grid, by the place of their module.
pub(crate) const MEET: (usize, &str) = (0, "meet");
pub(crate) const FIND_NEAR: (usize, &str) = (0, "find_near");
pub(crate) const FOLLOW: (usize, &str) = (0, "follow");
pub(crate) const REDUCE: (usize, &str) = (1, "reduce");
pub(crate) const BLUR: (usize, &str) = (1, "blur");
pub(crate) const MARK: (usize, &str) = (2, "mark_blurred");

impl RoughPipelines {
    pub(crate) fn new(device: &wgpu::Device, scene: &BindGroupLayout, hierarchy: &BindGroupLayout) -> Self {
        let stage = ShaderStages::COMPUTE;
        let written = [0, 1, 2, 3, 4, 6, 7].map(written_storage);
        let of_tables: Vec<_> = written.into_iter().chain([(5, uniform(true))]).collect();
        let tables = layout(device, "rough mirrors", stage, &of_tables);
        let of_marking: Vec<_> = [written_storage(0)].into_iter().chain(READ).collect();
        let marking = layout(device, "hits on rough mirrors", stage, &of_marking);
        let empty = layout(device, "nothing", stage, &[]);
        let layouts = [
            pipeline_layout(device, &[scene, hierarchy, &tables]),
            pipeline_layout(device, &[scene, &empty, &marking]),
        ];
        let modules =
            ["rough/cells.wgsl", "rough/blur.wgsl", "tiles/blurred.wgsl"].map(|path| shader_module(device, path));
        Self { tables, marking, layouts, modules, known: Kept::default() }
    }

    /// The pipeline of a pass, for scenes with such features and so many samples a pixel.
    pub(crate) fn get(
        &self,
        device: &wgpu::Device,
        (module, entry): (usize, &'static str),
        features: SceneFeatures,
        samples: u32,
    ) -> ComputePipeline {
        // Means need to know no more of a scene than that there are rough mirrors.
        let features = if module == 0 { features } else { features.of_rays() };
        self.known.get((entry, features, samples), || {
            let mut constants = features.constants();
            if module != 1 {
                constants.push(("SAMPLES", f64::from(samples)));
            }
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&self.layouts[module / 2]),
                module: &self.modules[module],
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                cache: None,
            })
        })
    }
}
