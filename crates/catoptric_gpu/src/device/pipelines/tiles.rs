//! Pipelines of the passes that find which triangle every ray hits, by tiles.

use super::bindings::{layout, table, texture, uniform, written_storage};
use super::kept::Kept;
use super::making::{compute, pipeline_layout, shader_module};
use crate::tables::SceneFeatures;
use wgpu::{BindGroupLayout, ComputePipeline, ShaderStages, TextureSampleType};

/// A pass of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Pass {
    /// Reads a picture of what is seen after so many events of kinds.
    Gather {
        events: u32,
        kinds: u32,
        holes_wait: bool,
    },
    Classify,
    Cover,
    Trace,
}

/// The pipelines of tiles.
#[derive(Debug)]
pub(crate) struct TilePipelines {
    /// Hits, and the picture of what is seen; for one sample a pixel, and for several.
    pub(crate) gathering: [BindGroupLayout; 2],
    /// Hits, work, and what a pass works on.
    pub(crate) working: BindGroupLayout,
    gather_layouts: [wgpu::PipelineLayout; 2],
    gather: wgpu::ShaderModule,
    /// The shaders of classification, of tiles and of traced rays.
    modules: [wgpu::ShaderModule; 3],
    layouts: [wgpu::PipelineLayout; 2],
    /// By samples and what scenes have.
    known: Kept<(u32, SceneFeatures, Pass), ComputePipeline>,
}

impl TilePipelines {
    pub(crate) fn new(device: &wgpu::Device, scene: &BindGroupLayout, hierarchy: &BindGroupLayout) -> Self {
        let stage = ShaderStages::COMPUTE;
        let seen = |binding, multisampled| texture(binding, TextureSampleType::Uint, multisampled);
        let gathering = [seen(1, false), seen(2, true)]
            .map(|seen| layout(device, "gathering", stage, &[written_storage(0), seen, table(3)]));
        let working = layout(device, "tiles", stage, &[written_storage(0), written_storage(1), (2, uniform(true))]);
        let module = |path: &str| shader_module(device, path);
        let gather = module("tiles/gather.wgsl");
        let gather_layouts = [0, 1].map(|index| pipeline_layout(device, &[scene, &gathering[index]]));
        let modules = [module("tiles/classify.wgsl"), module("tiles/cover.wgsl"), module("tiles/trace.wgsl")];
        let empty = layout(device, "nothing", stage, &[]);
        let layouts = [
            pipeline_layout(device, &[scene, &empty, &working]),
            pipeline_layout(device, &[scene, hierarchy, &working]),
        ];
        Self { gathering, working, gather_layouts, gather, modules, layouts, known: Kept::default() }
    }

    /// The pipeline of a pass, for so many samples a pixel and scenes with such features.
    pub(crate) fn get(
        &self,
        device: &wgpu::Device,
        samples: u32,
        features: SceneFeatures,
        pass: Pass,
    ) -> ComputePipeline {
        // All but tracing need to know no more of a scene than what changes rays.
        let features = if pass == Pass::Trace { features } else { features.of_rays() };
        self.known.get((samples, features, pass), || {
            let mut constants = features.constants();
            constants.push(("SAMPLES", f64::from(samples)));
            let (layout, module, entry) = match pass {
                Pass::Gather { events, kinds, holes_wait } => {
                    let numbers = [("EVENTS", events), ("KINDS", kinds), ("HOLES_WAIT", u32::from(holes_wait))];
                    constants.extend(numbers.map(|(name, number)| (name, f64::from(number))));
                    let index = usize::from(samples > 1);
                    let entry = ["gather_one_sample", "gather_four_samples"][index];
                    (&self.gather_layouts[index], &self.gather, entry)
                }
                Pass::Classify => (&self.layouts[0], &self.modules[0], "classify"),
                Pass::Cover => (&self.layouts[1], &self.modules[1], "cover"),
                Pass::Trace => (&self.layouts[1], &self.modules[2], "trace"),
            };
            compute(device, layout, module, entry, &constants)
        })
    }
}
