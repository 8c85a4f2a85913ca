//! Multiperspective rasterisation: every piece of a reflector's picture asks which triangles its rays see.
//!
//! See this folder's `README.md`.

mod bundles;
mod counts;
mod limits;
mod settings;
mod shapes;
mod source;
mod tiles;

pub use settings::MultiperspectiveSettings;

use super::draw::PathShader;
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::light::wide_hierarchy::WideHierarchy;
use crate::methods::bake::Baked;
use crate::methods::{Family, Frame, Method, MethodInfo, Prepared, Quality, Report, Settings};
use crate::optics::path::manifold::MeshTopologies;
use crate::progress::{Progress, Stage};
use crate::raster;
use crate::scene::{Scene, View};
use counts::Counts;
use glam::Vec3;
use shapes::SceneShapes;
use source::Reflections;
use std::sync::Arc;
use tiles::follow::MAX_BOUNCES;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "multiperspective",
    family: Family::Projection,
    summary: "each tile of a reflector's picture finds the triangles that its bundle of rays sees, and draws them",
    paper: "this project; after Mei, Popescu, Sacks 2007 and Yu, Yu, McMillan 2009",
    assumptions: "none beyond those of the reference; analytic surfaces are seen in reflectors by their triangles",
    cpu: true,
    gpu: false,
    bake: None,
    settings: MultiperspectiveSettings::describe,
    effective: MultiperspectiveSettings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new(Multiperspective { settings: MultiperspectiveSettings::from_table(table)? })),
};

struct Multiperspective {
    settings: MultiperspectiveSettings,
}

/// The hierarchy over a scene.
struct PreparedTiles {
    settings: MultiperspectiveSettings,
    scene: Arc<Scene>,
    quality: Quality,
    hierarchy: WideHierarchy,
    shapes: SceneShapes,
    report: Report,
}

/// One view.
struct TilesFrame<'a> {
    prepared: &'a PreparedTiles,
    view: View,
}

impl Method for Multiperspective {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        INFO.refuse_bake(bake)?;
        Ok(Box::new(PreparedTiles::new(&self.settings, scene, quality, None, progress)?))
    }
}

impl PreparedTiles {
    fn new(
        settings: &MultiperspectiveSettings,
        scene: &Arc<Scene>,
        quality: Quality,
        old: Option<&Self>,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let stage = Stage::begin(progress, "building the hierarchy", 2)?;
        let mut watch = Stopwatch::new();
        let kept = old.filter(|old| old.scene.triangles == scene.triangles);
        let hierarchy = match kept {
            Some(old) => {
                let mut hierarchy = old.hierarchy.clone();
                hierarchy.refit(scene);
                hierarchy
            }
            None => WideHierarchy::build(scene, |_| true),
        };
        stage.advance(1)?;
        let mut report = Report { stages_ms: vec![("bvh", watch.lap_ms())], ..Report::default() };
        let shapes = SceneShapes::new(scene, &MeshTopologies::of(scene));
        report.stages_ms.push(("topology", watch.lap_ms()));
        report.bytes.insert("bvh", hierarchy.byte_count());
        stage.advance(1)?;
        Ok(Self { settings: settings.clone(), scene: scene.clone(), quality, hierarchy, shapes, report })
    }
}

impl Prepared for PreparedTiles {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        *self = Self::new(&self.settings, scene, quality, Some(self), progress)?;
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(TilesFrame { prepared: self, view: view.clone() }))
    }
}

impl Frame for TilesFrame<'_> {
    fn report(&self) -> &Report {
        Report::none()
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let PreparedTiles { settings, scene, quality, hierarchy, shapes, .. } = self.prepared;
        let mut watch = Stopwatch::new();
        let order = (quality.order as usize).min(MAX_BOUNCES);
        let list = raster::scene_draw_list(scene, &self.view, |object| {
            let goes_on = order > 0 && scene.role_of(object).is_specular();
            Some(if goes_on { object + 1 } else { 0 })
        });
        let mut report = Report { stages_ms: vec![("project", watch.lap_ms())], ..Report::default() };
        let source = Reflections {
            scene,
            rays: self.view.rays(),
            forward: -Vec3::from(self.view.world_from_view.matrix3.z_axis),
            positions: raster::sample_positions(quality.samples)?,
            hierarchy,
            shapes,
            order,
            accuracy_px: settings.accuracy_px,
            counts: Counts::default(),
        };
        let shader = PathShader::new(scene, &self.view);
        let drawn = raster::draw_with(&self.view, quality.samples, &[list], &source, &shader, target, progress)?;
        report.add_raster(&drawn);
        source.counts.describe(&mut report);
        Ok(report)
    }
}
