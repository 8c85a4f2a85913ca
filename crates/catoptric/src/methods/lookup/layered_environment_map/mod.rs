//! Layered environment maps: paths among reflectors and lenses are traced alone, and what is around them is looked up in
//! layers.
//!
//! See this folder's `README.md`.

mod bake;
mod blend;
mod bounds;
mod capture;
mod depths;
mod direct;
mod distances;
mod group_layers;
mod groups;
mod infer;
mod inspect;
mod known;
mod layers;
mod least_squares;
mod maps;
mod merging;
mod mesh;
mod observations;
mod settings;
mod shader;
mod shared_layer;
mod shell;
mod surroundings;
mod texels;
mod texture;
mod viewpoints;
mod visible;
mod welds;

pub use inspect::{InferredLayer, inferred_layers, subdivision};
pub use settings::{Clustering, Direct, Edges, LayeredEnvironmentMapSettings, Shells, Textures, Transfer, Viewpoints};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::bake::Baked;
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::progress::Progress;
use crate::raster;
use crate::scene::Scene;
use bake::LayersWork;
use infer::Inference;
use known::Known;
use maps::{Layer, LayersAbout};
use mesh::{AdaptiveMesh, Criteria, NO_LEAF};
use shader::LensShader;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// What layered environment maps are.
pub static INFO: MethodInfo = MethodInfo {
    id: "layered_environment_map",
    family: Family::Lookup,
    summary: "reflectors and lenses traced alone at an adaptive mesh's vertices; around them layers of textured shells",
    paper: "Hakura, Snyder 2001, Realistic reflections and refractions on graphics hardware with hybrid rendering and layered \
            environment maps",
    assumptions: "what is around a group of reflectors lies on a few simple shells; two paths a pixel",
    cpu: true,
    gpu: false,
    bake: Some(|table, scene, quality| {
        let settings = LayeredEnvironmentMapSettings::from_table(table)?;
        Ok(Box::new(LayersWork::new(&settings, scene, quality)?))
    }),
    settings: LayeredEnvironmentMapSettings::describe,
    in_force: LayeredEnvironmentMapSettings::in_force,
    create: |table| {
        let settings = LayeredEnvironmentMapSettings::from_table(table)?;
        Ok(Box::new(LayeredEnvironmentMap { settings, baked: None, prepared: None }))
    },
};

/// Viewpoints of a group whose layers are kept in memory: those of the last views.
const MOST_KEPT: usize = 8;

struct LayeredEnvironmentMap {
    settings: LayeredEnvironmentMapSettings,
    /// What layers are taken from in place of inferring them.
    baked: Option<Arc<dyn Baked>>,
    prepared: Option<Prepared>,
}

/// What depends on the scene, and on the views so far.
struct Prepared {
    known: Known,
    /// Of every group the layers as they are seen from the middle of the shells; without textures where all are baked.
    projected: Vec<Vec<Layer>>,
    /// Of every group the layers of viewpoints.
    of_viewpoints: Vec<BTreeMap<u32, Vec<Layer>>>,
}

impl ReflectionMethod for LayeredEnvironmentMap {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn take_bake(&mut self, baked: Arc<dyn Baked>) -> Result<(), RenderError> {
        (self.baked, self.prepared) = (Some(baked), None);
        Ok(())
    }

    fn prepare(&mut self, scene: &Scene, quality: Quality, progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        let known = Known::new(&self.settings, scene, quality.order);
        let viewpoints = if self.settings.textures == Textures::Inferred { MOST_KEPT + 1 } else { 1 };
        known.check_memory(&self.settings, viewpoints)?;
        report.stages_ms.push(("layers", watch.lap_ms()));
        let is_baked = self.baked.is_some() && self.settings.textures == Textures::Inferred;
        let projected = match &self.baked {
            Some(baked) if is_baked => {
                bake::check(&known, &self.settings, &**baked)?;
                known.bare(&self.settings, scene, progress)
            }
            _ => known.projected(&self.settings, scene, progress),
        };
        report.stages_ms.push((if is_baked { "bake_load" } else { "capture" }, watch.lap_ms()));
        let groups = &known.groups;
        report.counts.insert("lens_groups", groups.len() as u64);
        report.counts.insert("layers", 0);
        for stratum in (0..known.part_count()).flat_map(|part| known.strata_of(part)) {
            *report.counts.entry("layers").or_default() += 1;
            *report.counts.entry(stratum.shell.name()).or_default() += 1;
        }
        if self.settings.share_far {
            report.counts.insert("shared_layers", u64::from(known.shared.is_some()));
        }
        report.bytes.insert("layers", projected.iter().flatten().map(Layer::byte_count).sum());
        let of_viewpoints = vec![BTreeMap::new(); known.part_count()];
        self.prepared = Some(Prepared { known, projected, of_viewpoints });
        Ok(report)
    }

    fn prepare_view(&mut self, job: &Job<'_>) -> Result<Report, RenderError> {
        let Self { settings, baked, prepared } = self;
        Prepared::of(prepared, job.scene)?.prepare_view(settings, baked.as_deref(), job)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let mut report = self.prepare_view(job)?;
        Prepared::of(&mut self.prepared, job.scene)?.draw(&self.settings, job, target, &mut report)?;
        Ok(report)
    }
}

impl Prepared {
    /// # Errors
    /// [`RenderError::Limit`] where there is none for the scene.
    fn of<'a>(prepared: &'a mut Option<Self>, scene: &Scene) -> Result<&'a mut Self, RenderError> {
        let problem =
            || RenderError::Limit { method: INFO.id, problem: "it has not been prepared for the scene".into() };
        prepared.as_mut().filter(|prepared| prepared.known.fit(scene)).ok_or_else(problem)
    }

    /// Infers the layers of the viewpoints about a view, or takes them from a bake.
    fn prepare_view(
        &mut self,
        settings: &LayeredEnvironmentMapSettings,
        baked: Option<&dyn Baked>,
        job: &Job<'_>,
    ) -> Result<Report, RenderError> {
        let mut report = Report::default();
        if settings.textures == Textures::Projected {
            return Ok(report);
        }
        let mut watch = Stopwatch::new();
        let Self { known, projected, of_viewpoints } = self;
        let (mut inferred, mut worst) = (0, 0.0f64);
        for (part, kept) in of_viewpoints.iter_mut().enumerate() {
            let shares = known.groups_of(part).flat_map(|group| known.shares(group, job.scene, job.view));
            let viewpoints: BTreeSet<u32> = shares.map(|(viewpoint, _)| viewpoint).collect();
            for &viewpoint in &viewpoints {
                if kept.contains_key(&viewpoint) {
                    continue;
                }
                let layers = match baked {
                    Some(baked) => bake::baked_layers(known, &projected[part], baked, part, viewpoint),
                    None => {
                        let inference = Inference { scene: job.scene, settings, known };
                        inferred += 1;
                        let (layers, residuals) = inference.infer(part, &projected[part], viewpoint, job.progress)?;
                        worst = residuals.iter().fold(worst, |worst: f64, residual| worst.max(residual.after));
                        layers
                    }
                };
                // Those that are furthest away in number go first: views move on a way.
                while kept.len() >= MOST_KEPT.max(viewpoints.len()) {
                    let others = kept.keys().filter(|number| !viewpoints.contains(number));
                    let furthest = others.max_by_key(|number| number.abs_diff(viewpoint)).copied();
                    furthest.and_then(|number| kept.remove(&number));
                }
                kept.insert(viewpoint, layers);
            }
        }
        if inferred > 0 {
            report.counts.insert("viewpoints_inferred", inferred);
            // What pictures of the worst layer are still off by, the root of the mean square in millionths of the radiance 1.
            report.counts.insert("worst_residual_millionths", (worst * 1e6).round() as u64);
            report.stages_ms.push(("infer", watch.lap_ms()));
        }
        Ok(report)
    }

    fn draw(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        job: &Job<'_>,
        target: &mut Framebuffer,
        report: &mut Report,
    ) -> Result<(), RenderError> {
        let (scene, view, samples) = (job.scene, job.view, job.quality.samples);
        let mut watch = Stopwatch::new();
        let tests_before = self.known.test_count();
        let paths = |object: u32| self.known.paths(scene, object);
        let (lists, mesh) = match settings.transfer {
            Transfer::Exact => (vec![raster::scene_draw_list(scene, view, |_| Some(NO_LEAF))], AdaptiveMesh::default()),
            Transfer::Adaptive => {
                mesh::drawn(scene, view, samples, &self.known.welds, &paths, Criteria::of(settings), |_| true)?
            }
        };
        report.stages_ms.push(("tessellate_and_trace", watch.lap_ms()));
        let groups = 0..self.known.groups.len();
        let maps: Vec<Vec<(LayersAbout<'_>, f32)>> = groups.map(|group| self.maps_of(settings, group, job)).collect();
        let lenses = |object: u32| Some((paths(object)?, self.known.group_of(object)?));
        let ray_count = AtomicU64::new(0);
        let (rays, edges) = (view.rays(), settings.edges);
        let shader =
            LensShader { scene, rays, lenses: &lenses, maps: &maps, mesh: &mesh, edges, ray_count: &ray_count };
        report.add_raster(&raster::draw(view, samples, &lists, &shader, target)?);
        report.counts.insert("mesh_vertices", mesh.points.len() as u64);
        report.counts.insert("mesh_triangles", mesh.leaves.len() as u64);
        report.counts.insert("rays_traced", mesh.ray_count + ray_count.into_inner());
        if let (true, Some(before), Some(after)) = (settings.count_tests, tests_before, self.known.test_count()) {
            report.counts.insert("triangle_tests", after - before);
        }
        Ok(())
    }

    /// What a group's rays look up.
    fn maps_of(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        group: usize,
        job: &Job<'_>,
    ) -> Vec<(LayersAbout<'_>, f32)> {
        match settings.textures {
            Textures::Projected => vec![(self.known.layers_about(group, |part| &self.projected[part]), 1.0)],
            Textures::Inferred => {
                let layers = |viewpoint: u32| {
                    self.known
                        .layers_about(group, |part| self.of_viewpoints[part].get(&viewpoint).map_or(&[], Vec::as_slice))
                };
                let shares = self.known.shares(group, job.scene, job.view).into_iter();
                shares.map(|(viewpoint, share)| (layers(viewpoint), share)).collect()
            }
        }
    }
}
