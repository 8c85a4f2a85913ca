//! Multiperspective rasterisation: every piece of a reflector's picture asks which triangles its rays see.
//!
//! See this folder's `README.md`.

mod limits;
mod settings;

pub use super::draw::multiperspective::{ObjectShape, object_shapes};
pub use settings::{ModelOfRays, MultiperspectiveSettings};

use super::draw::MapsInView;
use super::draw::multiperspective::{TileModel, TiledScene};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::{About, Family, Frame, Job, Method, MethodInfo, Prepared, Quality, Report, Settings};
use catoptric_engine::raster::{self, DrawList};
use std::sync::Arc;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "multiperspective",
    family: Family::Projection,
    summary: "each tile of a reflector's picture finds the triangles that its bundle of rays sees, and draws them",
    paper: "this project; after Mei, Popescu, Sacks 2007 and Yu, Yu, McMillan 2009",
    assumptions: "none beyond those of the reference; analytic surfaces are seen in reflectors by their triangles",
    about: About {
        readme: include_str!("README.md"),
        draws: "all mirrors and glass by tiles of their pixels, each with the triangles that its rays see; single \
            rays at rims",
        costs: "nothing beforehand and nothing kept from frame to frame; a frame costs what its reflecting pixels cost",
        cannot: "edges may be off by accuracy_px where a bundle misses its rays, and wide lobes are noisy at rims",
        useful: &["accuracy_px", "model"],
    },
    cpu: true,
    gpu: true,
    bake: None,
    settings: MultiperspectiveSettings::describe,
    effective: MultiperspectiveSettings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new(Multiperspective { settings: MultiperspectiveSettings::from_table(table)? })),
};

struct Multiperspective {
    settings: MultiperspectiveSettings,
}

/// A scene, ready for any view.
struct PreparedTiles {
    settings: MultiperspectiveSettings,
    scene: Arc<Scene>,
    quality: Quality,
    tiled: TiledScene,
    report: Report,
}

/// A frame: the prepared method for one view.
struct TilesFrame<'a> {
    prepared: &'a PreparedTiles,
    view: View,
}

impl Method for Multiperspective {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn overlays(&self) -> &'static [OverlayKind] {
        &[OverlayKind::Paths, OverlayKind::Tiles]
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
        let mut report = Report::default();
        let tiled = TiledScene::new(scene, old.map(|old| &old.tiled), &mut report, progress)?;
        Ok(Self { settings: settings.clone(), scene: scene.clone(), quality, tiled, report })
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
        let PreparedTiles { scene, quality, tiled, .. } = self.prepared;
        let mut watch = Stopwatch::new();
        let list = self.seen();
        let mut report = Report { stages_ms: vec![("project", watch.lap_ms())], ..Report::default() };
        let job = Job { scene, view: &self.view, quality: *quality, progress };
        report.add(tiled.draw(&job, &[list], Some(self.model()), MapsInView::default(), target)?);
        Ok(report)
    }

    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        let PreparedTiles { scene, quality, tiled, .. } = self.prepared;
        if kind == OverlayKind::VirtualTriangles {
            return Ok(None);
        }
        let job = Job { scene, view: &self.view, quality: *quality, progress };
        tiled.overlay(kind, &job, &[self.seen()], self.model())
    }
}

impl TilesFrame<'_> {
    /// The list of the direct view.
    fn seen(&self) -> DrawList {
        let PreparedTiles { scene, quality, .. } = self.prepared;
        raster::scene_draw_list(scene, &self.view, |object| {
            let goes_on = quality.order > 0 && scene.role_of(object).is_specular();
            Some(if goes_on { object + 1 } else { 0 })
        })
    }

    fn model(&self) -> TileModel {
        let settings = &self.prepared.settings;
        let by_rays = settings.model == ModelOfRays::Rays;
        TileModel { accuracy_px: settings.accuracy_px, by_rays, turns_normals: true }
    }
}
