//! Multiperspective rasterisation: every piece of a reflector's picture asks which triangles its rays meet.
//!
//! See the method's [README](../../multiperspective/README.md).

pub(crate) mod bundles;
mod counts;
mod shapes;
mod source;
mod tile_log;
mod tile_model;
mod tiles;

pub use shapes::{ObjectShape, object_shapes};
pub(crate) use tile_model::TileModel;

use super::drawn_by::PixelsByOthers;
use super::far_maps::MapsInView;
use super::flat_mirrors::has_flat_faces;
use super::lobe_lights::LobeLights;
use super::overlays::{self, ShownPixels};
use super::path_shader::PathShader;
use super::rough::{RoughMirrors, RoughReflections};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::{Progress, Stage};
use catoptric_core::scene::{Role, Scene};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::bodies::bodies_meet;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::light::wide_hierarchy::WideHierarchy;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::projector::PathBeginnings;
use catoptric_engine::method::{Job, Quality, Report};
use catoptric_engine::optics::path::manifold::MeshTopologies;
use catoptric_engine::raster::{self, DrawList};
use counts::Counts;
use glam::Vec3;
use shapes::SceneShapes;
use std::sync::Arc;
use tile_log::TileLog;
use tiles::follow::MAX_BOUNCES;
use tiles::reflections::{Reflections, outermost};

/// True if anything of a scene reflects or scatters light in lobes.
pub(super) fn spreads_light(scene: &Scene) -> bool {
    (0..scene.objects.len() as u32).any(|object| {
        let material = scene.material_of(object);
        material.may_spread_light() || material.lobes().is_some()
    })
}

/// Tiles of longer paths through curved glass, and through glass with flat faces, take longer than rays.
const MOST_TILED_ORDERS: [u32; 2] = [2, 4];

/// Returns true if rays, in place of tiles, follow the lenses that are seen directly or in flat mirrors: on long paths,
/// and where bodies may touch or lie within each other, as tiles know of vacuum alone about each of them.
pub(crate) fn follows_lenses(scene: &Scene, quality: Quality) -> bool {
    let lenses = || (0..scene.objects.len() as u32).filter(|object| scene.role_of(*object) == Role::Lens);
    let [of_curved, of_flat] = MOST_TILED_ORDERS;
    let is_long = || match quality.order {
        order if order > of_flat => true,
        order => order > of_curved && !lenses().all(|object| has_flat_faces(scene, object)),
    };
    lenses().next().is_some() && (is_long() || bodies_meet(scene))
}

/// The part of tile drawing that depends on the scene, not on the view.
pub(crate) struct TiledScene {
    scene: Arc<Scene>,
    hierarchy: WideHierarchy,
    shapes: SceneShapes,
    /// If there are any.
    rough: Option<RoughMirrors>,
    /// Rays follow lobes of surfaces, or lenses.
    follows_rays: bool,
    /// The tracer of these rays, unless rough mirrors have one.
    tracer: Option<Tracer>,
}

impl TiledScene {
    /// The tables of a scene, by those of another moment of it if these are given.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(crate) fn new(
        scene: &Arc<Scene>,
        old: Option<&Self>,
        report: &mut Report,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let stage = Stage::begin(progress, "building the hierarchy", 2)?;
        let mut watch = Stopwatch::new();
        let old = old.filter(|old| old.scene.triangles == scene.triangles);
        let refitted = old.and_then(|old| {
            let mut hierarchy = old.hierarchy.clone();
            hierarchy.refit(scene).then_some(hierarchy)
        });
        let hierarchy = refitted.unwrap_or_else(|| WideHierarchy::build(scene, |_| true));
        let rough = RoughMirrors::new(scene, old.and_then(|old| old.rough.as_ref()));
        let has_lobes = |object: u32| scene.material_of(object).lobes().is_some();
        let follows_rays = (0..scene.objects.len() as u32).any(has_lobes);
        let tracer = (follows_rays && rough.is_none()).then(|| {
            let refitted = old.and_then(|old| old.tracer.as_ref()).and_then(|old| old.refitted(scene));
            refitted.unwrap_or_else(|| Tracer::build(scene, |_| true))
        });
        stage.advance(1)?;
        report.stages_ms.push(("bvh", watch.lap_ms()));
        let shapes = SceneShapes::new(scene, &MeshTopologies::of(scene));
        report.stages_ms.push(("topology", watch.lap_ms()));
        let of_rough = rough.as_ref().map_or(0, RoughMirrors::byte_count);
        let of_tracer = tracer.as_ref().map_or(0, Tracer::byte_count);
        report.bytes.insert("bvh", hierarchy.byte_count() + of_rough + of_tracer);
        stage.advance(1)?;
        Ok(Self { scene: scene.clone(), hierarchy, shapes, rough, follows_rays, tracer })
    }

    /// Has rays follow lenses that no list or tile goes on from, as those of the lobes of other surfaces.
    pub(crate) fn follow_lenses(&mut self) {
        self.follows_rays = true;
        if self.rough.is_none() && self.tracer.is_none() {
            self.tracer = Some(Tracer::build(&self.scene, |_| true));
        }
    }

    /// The tracer for rays over lobes and through lenses, if such rays are traced.
    fn tracer(&self) -> Option<&Tracer> {
        let of_rough = self.rough.as_ref().map(RoughMirrors::tracer);
        of_rough.or(self.tracer.as_ref()).filter(|_| self.follows_rays)
    }

    /// Draws lists. With a model for tiles, these draw reflectors and lenses at which no list goes on; else these show
    /// the environment. Reflectors with environment maps show these.
    ///
    /// # Errors
    /// As [`raster::draw`].
    pub(crate) fn draw(
        &self,
        job: &Job<'_>,
        lists: &[DrawList],
        model: Option<TileModel>,
        maps: MapsInView<'_>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let Job { scene, view, quality, progress } = *job;
        let mut watch = Stopwatch::new();
        let rough = self.rough_reflections(job)?;
        let mut report = Report::default();
        if rough.is_some() {
            report.stages_ms.push(("rough", watch.lap_ms()));
        }
        let lobe_lights = self.tracer().map(|tracer| LobeLights::new(job, tracer)).transpose()?.flatten();
        if lobe_lights.is_some() {
            report.stages_ms.push(("lobes", watch.lap_ms()));
        }
        let shader = PathShader::new(scene, view, quality.samples)
            .with_rough(rough.as_ref())
            .with_turned_normals(model.is_some_and(|model| model.turns_normals))
            .with_maps(maps, quality.order)
            .with_lobes(self.tracer(), quality.order)
            .with_lobe_lights(lobe_lights.as_ref())
            .with_neighbours(&self.shapes.neighbours);
        let (drawn, by_others) = match model {
            Some(model) => {
                let source = self.reflections(job, model, maps, rough.as_ref(), None)?;
                let drawn = raster::draw_with(view, quality.samples, lists, &source, &shader, target, progress)?;
                source.counts.describe(&mut report);
                (drawn, source.counts.pixels_by_others())
            }
            None => {
                let drawn = raster::draw(view, quality.samples, lists, &shader, target, progress)?;
                (drawn, PixelsByOthers::default())
            }
        };
        report.add_raster(&drawn);
        shader.describe(by_others, &mut report);
        Ok(report)
    }

    fn rough_reflections<'a>(&'a self, job: &Job<'a>) -> Result<Option<RoughReflections<'a>>, RenderError> {
        let rough = self.rough.as_ref().map(|mirrors| RoughReflections::new(job, mirrors)).transpose()?;
        Ok(rough.flatten())
    }

    /// The source of surfaces from which tiles draw a picture.
    fn reflections<'a>(
        &'a self,
        job: &Job<'a>,
        model: TileModel,
        maps: MapsInView<'a>,
        rough: Option<&'a RoughReflections<'a>>,
        log: Option<&'a TileLog>,
    ) -> Result<Reflections<'a>, RenderError> {
        let Job { scene, view, quality, .. } = *job;
        let positions = raster::sample_positions(quality.samples)?;
        Ok(Reflections {
            scene,
            rays: view.rays(),
            forward: -Vec3::from(view.world_from_view.matrix3.z_axis),
            positions,
            outermost: outermost(positions),
            hierarchy: &self.hierarchy,
            shapes: &self.shapes,
            order: (quality.order as usize).min(MAX_BOUNCES),
            model,
            maps: maps.whole,
            rough,
            log,
            counts: Counts::default(),
        })
    }

    /// The surfaces that pixels show of lists, and in reflectors and through lenses at which no list goes on; rough
    /// mirrors count as smooth.
    ///
    /// # Errors
    /// As [`raster::draw`].
    pub(crate) fn shown(
        &self,
        job: &Job<'_>,
        lists: &[DrawList],
        model: TileModel,
        maps: MapsInView<'_>,
    ) -> Result<ShownPixels, RenderError> {
        let job = &Job { quality: Quality { samples: 1, ..job.quality }, ..*job };
        let source = self.reflections(job, model, maps, None, None)?;
        ShownPixels::of(job.scene, job.view, |shader, target| {
            raster::draw_with(job.view, 1, lists, &source, shader, target, job.progress).map(drop)
        })
    }

    /// An overlay of the picture that [`Self::draw`] draws; `None` for kinds that tiles and lists do not have.
    ///
    /// # Errors
    /// As [`raster::draw`].
    pub(crate) fn overlay(
        &self,
        kind: OverlayKind,
        job: &Job<'_>,
        lists: &[DrawList],
        model: TileModel,
    ) -> Result<Option<Overlay>, RenderError> {
        let Job { scene, view, quality, progress } = *job;
        let maps = MapsInView::default();
        let shown = || self.shown(job, lists, model, maps);
        Ok(match kind {
            OverlayKind::Paths => Some(overlays::paths(scene, &shown()?, &PathBeginnings::default())),
            OverlayKind::VirtualTriangles => {
                Some(overlays::virtual_triangles(scene, view, lists, &shown()?, progress)?)
            }
            OverlayKind::Tiles => {
                // The same settings as for the picture: tiles depend on its samples, and on rough mirrors.
                let (rough, log) = (self.rough_reflections(job)?, TileLog::default());
                let source = self.reflections(job, model, maps, rough.as_ref(), Some(&log))?;
                let samples = quality.samples;
                ShownPixels::of(scene, view, |shader, target| {
                    raster::draw_with(view, samples, lists, &source, shader, target, progress).map(drop)
                })?;
                Some(log.overlay([view.width, view.height]))
            }
            OverlayKind::Leaves | OverlayKind::Layers => None,
        })
    }
}
