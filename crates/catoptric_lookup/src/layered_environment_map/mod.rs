//! Layered environment maps: paths among reflectors and lenses are traced alone, and their surroundings are looked up
//! in layers.
//!
//! See this folder's `README.md`.

pub(crate) mod bake;
pub(crate) mod inference;
mod inspect;
mod layer_numbers;
mod limits;
mod lookup;
pub(crate) mod mesh;
mod settings;
pub(crate) mod shell;
pub(crate) mod shells;
pub(crate) mod texels;
mod texture_size;
pub(crate) mod textures;

pub use inspect::{InferredLayer, inferred_layers, subdivision};
pub use settings::{
    Clustering, Direct, Edges, LayeredEnvironmentMapSettings, Preset, Shells, Textures, Transfer, Viewpoints,
};

use crate::shared::regions::Regions;
use bake::LayersWork;
use bake::stored::BakedLayers;
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::{
    About, Family, Frame, Job, Method, MethodInfo, Prepared, Quality, Report, Settings, report,
};
use catoptric_engine::raster::{self, DrawList};
use inference::Inference;
use layer_numbers::LayerNumbers;
use lookup::LensShader;
use mesh::{AdaptiveMesh, Criteria, NO_LEAF};
use shells::layer_geometry::LayerGeometry;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use textures::maps::{Layer, LayersAbout};
pub use textures::tables::{DepthTables, LayerTables, ShellShape, ViewpointLayers};

/// Description of the method in the registry.
pub static INFO: MethodInfo = MethodInfo {
    id: "layered_environment_map",
    family: Family::Lookup,
    summary: "reflectors and lenses traced alone at an adaptive mesh's vertices; around them layers of textured shells",
    paper: "Hakura, Snyder 2001, Realistic reflections and refractions on graphics hardware with hybrid rendering and \
        layered \
            environment maps",
    assumptions: "what is around a group of reflectors lies on a few simple shells; two paths a pixel",
    about: About {
        readme: include_str!("README.md"),
        draws: "reflectors and glass by rays that meet them alone; what is around them by look-ups in the textures \
            of a few layers",
        costs: "the layers' textures are captured beforehand, or once by `catoptric bake`, which takes long for many \
            layers; then rays meet little geometry",
        cannot: "parts that are hidden from the middle of a group are missing, things between its members are \
            smeared, and magnified textures are blurred",
        useful: &["layers", "size", "shells", "textures"],
    },
    cpu: true,
    gpu: true,
    bake: Some(|table, scene, quality| {
        let settings = LayeredEnvironmentMapSettings::from_table(table)?;
        Ok(Box::new(LayersWork::new(&settings, scene, quality)?))
    }),
    settings: LayeredEnvironmentMapSettings::describe,
    effective: LayeredEnvironmentMapSettings::effective,
    limits: &limits::LIMITS,
    create: |table| {
        let settings = LayeredEnvironmentMapSettings::from_table(table)?;
        Ok(Box::new(LayeredEnvironmentMap { settings }))
    },
};

/// Viewpoints of a group whose layers are kept in memory: those of the last views. A bound on memory; chosen, not
/// measured.
const MAX_KEPT: usize = 8;

/// Texels a side that textures have at least, unless fewer are wanted: a bound on automatic reduction. Chosen, not
/// measured.
const MIN_SIZE: u32 = 64;

struct LayeredEnvironmentMap {
    settings: LayeredEnvironmentMapSettings,
}

/// The layers of a scene, and those of the viewpoints of the views so far.
pub struct LayeredMaps {
    wanted: LayeredEnvironmentMapSettings,
    /// The settings of the present layers.
    settings: LayeredEnvironmentMapSettings,
    scene: Arc<Scene>,
    quality: Quality,
    /// The source of layers, where they are not made now.
    baked: Option<BakedLayers>,
    known: LayerGeometry,
    /// Layers of every group, as seen from the centres of the shells, by the size of their textures; without textures
    /// where a bake has inferred ones.
    projected: BTreeMap<u32, Vec<Vec<Layer>>>,
    /// Layers of viewpoints, of every group.
    of_viewpoints: Vec<BTreeMap<u32, Vec<Layer>>>,
    report: Report,
}

/// A frame: the prepared method for one view.
struct LayersFrame<'a> {
    prepared: &'a LayeredMaps,
    view: View,
    report: Report,
}

impl Method for LayeredEnvironmentMap {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn overlays(&self) -> &'static [OverlayKind] {
        &[OverlayKind::Layers]
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(LayeredMaps::new(&self.settings, scene, quality, bake, progress)?))
    }
}

impl LayeredMaps {
    /// Makes the layers of a scene, or prepares those of a bake.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where tables do not fit into memory or a bake is of another scene,
    /// [`RenderError::Cancelled`].
    pub fn new(
        wanted: &LayeredEnvironmentMapSettings,
        scene: &Arc<Scene>,
        quality: Quality,
        baked: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        let for_views = wanted.size == 0 && wanted.textures == Textures::Projected && baked.is_none();
        let settings = if for_views { wanted.clone() } else { wanted.sized() };
        let settings = &captured_at_once(&settings, scene, baked.is_some(), &mut report);
        let baked = baked.map(|units| BakedLayers::open(settings, &units)).transpose()?;
        let known = match &baked {
            Some(baked) => baked.geometry(settings, scene, quality.order)?,
            None => LayerGeometry::new(settings, scene, quality.order),
        };
        report.stages_ms.push(("layers", watch.lap_ms()));
        let mut projected = BTreeMap::new();
        if !for_views {
            let viewpoints = if settings.textures == Textures::Inferred { MAX_KEPT + 1 } else { 1 };
            known.check_memory(settings, viewpoints)?;
            let layers = match &baked {
                Some(baked) => baked.layers(settings)?,
                None => known.projected(settings, scene, progress)?,
            };
            projected.insert(settings.size, layers);
        }
        report.stages_ms.push((if baked.is_some() { "bake_load" } else { "capture" }, watch.lap_ms()));
        report.counts.insert("lens_groups", known.groups.len() as u64);
        report.counts.insert("layers", 0);
        for stratum in (0..known.part_count()).flat_map(|part| known.strata_of(part)) {
            *report.counts.entry("layers").or_default() += 1;
            *report.counts.entry(stratum.shell.name()).or_default() += 1;
        }
        if settings.share_far {
            report.counts.insert("shared_layers", u64::from(known.shared.is_some()));
        }
        report.bytes.insert("layers", byte_count(&projected));
        let of_viewpoints = vec![BTreeMap::new(); known.part_count()];
        let (wanted, settings, scene) = (wanted.clone(), settings.clone(), scene.clone());
        Ok(Self { wanted, settings, scene, quality, baked, known, projected, of_viewpoints, report })
    }
}

/// Memory of layers.
fn byte_count(projected: &BTreeMap<u32, Vec<Vec<Layer>>>) -> u64 {
    projected.values().flatten().flatten().map(Layer::byte_count).sum()
}

/// Settings for layers about a scene's groups that are all captured now: textures are smaller about many of them.
fn captured_at_once(
    settings: &LayeredEnvironmentMapSettings,
    scene: &Scene,
    is_baked: bool,
    report: &mut Report,
) -> LayeredEnvironmentMapSettings {
    let regions = Regions::of(scene, 0.0);
    report.add_fallback("joined_groups", regions.joined);
    let mut settings = settings.clone();
    if regions.share_of_side() < 1.0 && !is_baked {
        settings.size = halved(settings.size);
        report.add_fallback("groups_with_smaller_layers", regions.boxes.len() as u64);
    }
    settings
}

/// Half of a size, unless that is too small.
fn halved(size: u32) -> u32 {
    (size / 2).max(MIN_SIZE.min(size))
}

impl Prepared for LayeredMaps {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        let baked = self.baked.as_ref().map(BakedLayers::units);
        *self = Self::new(&self.wanted, scene, quality, baked, progress)?;
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        let report = self.infer(view, progress)?;
        Ok(Box::new(LayersFrame { prepared: self, view: view.clone(), report }))
    }
}

impl LayeredMaps {
    /// Times, counts and warnings of making them.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The number of every object's group of reflectors and lenses, if it is in one.
    pub fn group_of(&self) -> &[Option<u32>] {
        self.known.group_of_objects()
    }

    /// The layers that the rays of each group look up in a view, by the viewpoints that are blended (at most four, with
    /// their shares, which sum to one), the nearest first. Those of a view must have been inferred.
    pub fn layers_of_groups(&self, view: &View) -> Vec<Vec<ViewpointLayers<'_>>> {
        let of_group = |group| {
            // Projected layers have no viewpoints: they are the same for all views.
            let numbers = match self.settings.textures {
                Textures::Projected => vec![0],
                Textures::Inferred => {
                    let shares = self.known.shares(group, &self.scene, view);
                    shares.into_iter().map(|(viewpoint, _)| viewpoint).collect()
                }
            };
            let viewpoints = numbers.into_iter().zip(self.maps_of(group, view));
            viewpoints.map(|(number, (layers, share))| ViewpointLayers { number, share, layers }).collect()
        };
        (0..self.known.groups.len()).map(of_group).collect()
    }

    /// The layers that a group's rays look up, with their weights.
    fn maps_of(&self, group: usize, view: &View) -> Vec<(LayersAbout<'_>, f32)> {
        let Self { settings, scene, known, of_viewpoints, .. } = self;
        match settings.textures {
            Textures::Projected => vec![(known.layers_about(group, |part| self.projected_of(part)), 1.0)],
            Textures::Inferred => {
                let of_viewpoint =
                    |part: usize, viewpoint: u32| of_viewpoints[part].get(&viewpoint).map_or(&[][..], Vec::as_slice);
                let layers = |viewpoint: u32| known.layers_about(group, |part| of_viewpoint(part, viewpoint));
                let weights = known.shares(group, scene, view).into_iter();
                weights.map(|(viewpoint, weight)| (layers(viewpoint), weight)).collect()
            }
        }
    }

    /// The layers of a part as seen from the centres of their shells, of the size that the last view reads.
    fn projected_of(&self, part: usize) -> &[Layer] {
        self.projected.get(&self.settings.size).and_then(|parts| parts.get(part)).map_or(&[][..], Vec::as_slice)
    }

    /// Captures the layers as large as a view reads them, if their size is by views: each size once.
    fn fit(
        &mut self,
        view: &View,
        (report, watch): (&mut Report, &mut Stopwatch),
        progress: &dyn Progress,
    ) -> Result<(), RenderError> {
        if self.wanted.size != 0 || self.baked.is_some() {
            return Ok(());
        }
        let Self { settings, scene, known, projected, .. } = self;
        let size = texture_size::of_view(known, settings, scene, view);
        // Textures are smaller about many groups.
        settings.size =
            if self.report.fallbacks.contains_key("groups_with_smaller_layers") { halved(size) } else { size };
        if let Entry::Vacant(place) = projected.entry(settings.size) {
            known.check_memory(settings, 1)?;
            place.insert(known.projected(settings, scene, progress)?);
            report.stages_ms.push(("capture", watch.lap_ms()));
        }
        report.counts.insert("layer_texels", u64::from(settings.size));
        report.bytes.insert("layers", byte_count(projected));
        Ok(())
    }

    /// Infers the layers of the viewpoints about a view, or takes them from the bake.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub fn infer(&mut self, view: &View, progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut report = Report::default();
        let mut watch = Stopwatch::new();
        if self.settings.textures == Textures::Projected {
            self.fit(view, (&mut report, &mut watch), progress)?;
            return Ok(report);
        }
        let Self { settings, scene, baked, known, projected, of_viewpoints, .. } = self;
        let projected = projected.get(&settings.size).map_or(&[][..], Vec::as_slice);
        let (mut inferred, mut worst) = (0, 0.0f64);
        for (part, kept) in of_viewpoints.iter_mut().enumerate() {
            let shares = known.groups_of(part).flat_map(|group| known.shares(group, scene, view));
            let viewpoints: BTreeSet<u32> = shares.map(|(viewpoint, _)| viewpoint).collect();
            for &viewpoint in &viewpoints {
                if kept.contains_key(&viewpoint) {
                    continue;
                }
                let layers = match &*baked {
                    Some(baked) => {
                        baked.of_viewpoint(projected.get(part).map_or(&[][..], Vec::as_slice), part, viewpoint)
                    }
                    None => {
                        let inference = Inference { scene, settings, known };
                        inferred += 1;
                        let (layers, residuals) = inference.infer(
                            part,
                            projected.get(part).map_or(&[][..], Vec::as_slice),
                            viewpoint,
                            progress,
                        )?;
                        worst = residuals.iter().fold(worst, |worst: f64, residual| worst.max(residual.after));
                        layers
                    }
                };
                // Viewpoints with the most different numbers go first: eyes move along a path.
                while kept.len() >= MAX_KEPT.max(viewpoints.len()) {
                    let others = kept.keys().filter(|number| !viewpoints.contains(number));
                    let furthest = others.max_by_key(|number| number.abs_diff(viewpoint)).copied();
                    furthest.and_then(|number| kept.remove(&number));
                }
                kept.insert(viewpoint, layers);
            }
        }
        if inferred > 0 {
            report.counts.insert("viewpoints_inferred", inferred);
            // The remaining error of pictures of the worst layer, as root mean square in millionths of the radiance 1.
            report.counts.insert("worst_residual_millionths", (worst * 1e6).round() as u64);
            report.stages_ms.push(("infer", watch.lap_ms()));
        }
        Ok(report)
    }
}

impl Frame for LayersFrame<'_> {
    fn report(&self) -> &Report {
        &self.report
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let LayeredMaps { settings, scene, quality, known, .. } = self.prepared;
        let (view, samples) = (&self.view, quality.samples);
        let job = Job { scene, view, quality: *quality, progress };
        let mut report = Report::default();
        report.warnings.extend(report::bumpy_surfaces(scene));
        let mut watch = Stopwatch::new();
        let tests_before = known.test_count();
        let (lists, mesh) = self.lists(&job)?;
        report.stages_ms.push(("tessellate_and_trace", watch.lap_ms()));
        let ray_count = AtomicU64::new(0);
        let drawn =
            self.with_shader(&mesh, &ray_count, |shader| raster::draw(view, samples, &lists, shader, target, progress));
        report.add_raster(&drawn?);
        report.counts.insert("mesh_vertices", mesh.points.len() as u64);
        report.counts.insert("mesh_triangles", mesh.leaves.len() as u64);
        report.counts.insert("rays_traced", mesh.ray_count + ray_count.into_inner());
        if let (true, Some(before), Some(after)) = (settings.count_tests, tests_before, known.test_count()) {
            report.counts.insert("triangle_tests", after - before);
        }
        Ok(report)
    }

    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        if kind != OverlayKind::Layers {
            return Ok(None);
        }
        let LayeredMaps { scene, quality, .. } = self.prepared;
        let view = &self.view;
        let (lists, mesh) = self.lists(&Job { scene, view, quality: *quality, progress })?;
        let mut picture = Framebuffer::new(view.width, view.height);
        self.with_shader(&mesh, &AtomicU64::new(0), |shader| {
            raster::draw(view, 1, &lists, &LayerNumbers(shader), &mut picture, progress)
        })?;
        Ok(Some(LayerNumbers::overlay(&picture)))
    }
}

impl LayersFrame<'_> {
    /// The lists that are drawn, and the adaptive mesh in them.
    fn lists(&self, job: &Job<'_>) -> Result<(Vec<DrawList>, AdaptiveMesh), RenderError> {
        let LayeredMaps { settings, known, .. } = self.prepared;
        let paths = |object: u32| known.paths(job.scene, object);
        Ok(match settings.transfer {
            Transfer::Exact => {
                (vec![raster::scene_draw_list(job.scene, job.view, |_| Some(NO_LEAF))], AdaptiveMesh::default())
            }
            Transfer::Adaptive => mesh::drawn(job, &known.welds, &paths, Criteria::of(settings), |_| true)?,
        })
    }

    /// Calls `draw` with the view's shader.
    fn with_shader<T>(&self, mesh: &AdaptiveMesh, ray_count: &AtomicU64, draw: impl FnOnce(&LensShader<'_>) -> T) -> T {
        let LayeredMaps { settings, scene, known, .. } = self.prepared;
        let maps: Vec<_> = (0..known.groups.len()).map(|group| self.prepared.maps_of(group, &self.view)).collect();
        let lenses = |object: u32| Some((known.paths(scene, object)?, known.group_of(object)?));
        let (rays, edges) = (self.view.rays(), settings.edges);
        draw(&LensShader { scene, rays, lenses: &lenses, maps: &maps, mesh, edges, ray_count })
    }
}
