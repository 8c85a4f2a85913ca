//! Flat mirrors by mirrored geometry and stencil, to any order.
//!
//! See this folder's `README.md`.

mod chain;
mod flat;
mod limits;
pub(crate) mod path_search;
mod project;
mod settings;

pub use flat::{FlatMirrors, MirrorView};
pub use settings::PlanarMirrorSettings;

use crate::draw::flat_mirrors::{MirrorPath, MirroredScenes, Mirrors, OtherReflectors, visible_paths};
use crate::draw::overlays::{self, ShownPixels};
use crate::draw::{PathShader, PixelsByOthers};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::path_query::PathSearch;
use catoptric_engine::method::projector::{MAX_BOUNCES, PathBeginnings, VertexProjector};
use catoptric_engine::method::{About, Family, Frame, Method, MethodInfo, Prepared, Quality, Report, Settings, report};
use catoptric_engine::raster::{self, DrawList};
use glam::DVec3;
use path_search::MirrorSearch;
use project::MirrorProjector;
use std::sync::Arc;

/// Triangles of all mirrored copies of the scene together: beyond, copies are left out. A bound on time and memory;
/// chosen, not measured.
const MAX_TRIANGLES: usize = 16_000_000;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "planar_mirror",
    family: Family::Projection,
    summary: "flat mirrors: the scene mirrored in each, clipped and stencilled, mirrors in mirrors to any order",
    paper: "Diefenbach, Badler 1997, Multi-pass pipeline rendering: realism for dynamic environments",
    assumptions: "reflectors are flat or have at most 64 flat faces; curved ones and lenses are drawn black",
    about: About {
        readme: include_str!("README.md"),
        draws: "flat mirrors, and mirrors in mirrors, by one mirrored copy of the scene each",
        costs: "nothing beforehand; a pass over the scene's triangles for every copy, of which mirrors in mirrors \
            need many",
        cannot: "curved reflectors and lenses are black; copies beyond max_lists are left out and counted",
        useful: &["max_lists"],
    },
    cpu: true,
    gpu: true,
    bake: None,
    settings: PlanarMirrorSettings::describe,
    effective: PlanarMirrorSettings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new(PlanarMirror { settings: PlanarMirrorSettings::from_table(table)? })),
};

struct PlanarMirror {
    settings: PlanarMirrorSettings,
}

/// The flat mirrors of a scene.
struct PreparedMirrors {
    settings: PlanarMirrorSettings,
    scene: Arc<Scene>,
    quality: Quality,
    mirrors: Mirrors,
    report: Report,
}

/// A frame: the prepared method for one view.
struct MirrorFrame<'a> {
    prepared: &'a PreparedMirrors,
    view: View,
}

impl Method for PlanarMirror {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn overlays(&self) -> &'static [OverlayKind] {
        &[OverlayKind::Paths, OverlayKind::VirtualTriangles]
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        _progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        INFO.refuse_bake(bake)?;
        Ok(Box::new(PreparedMirrors::new(&self.settings, scene, quality)))
    }
}

impl PreparedMirrors {
    fn new(settings: &PlanarMirrorSettings, scene: &Arc<Scene>, quality: Quality) -> Self {
        let (mirrors, report) = find(scene);
        Self { settings: settings.clone(), scene: scene.clone(), quality, mirrors, report }
    }
}

/// The flat mirrors of a scene, and a report of the surfaces that are not drawn as they should be.
fn find(scene: &Scene) -> (Mirrors, Report) {
    let mut watch = Stopwatch::new();
    let mirrors = Mirrors::find(scene);
    let mut report = Report { stages_ms: vec![("find_mirrors", watch.lap_ms())], ..Report::default() };
    report.warnings.extend(report::rough_mirrors(scene));
    report.warnings.extend(report::bumpy_surfaces(scene));
    report.counts.insert("mirrors", mirrors.planes.len() as u64);
    let (curved, lenses) = (mirrors.curved_triangles, mirrors.lens_triangles);
    if curved > 0 {
        report.fallbacks.insert("curved_triangles", curved);
        report.warnings.push(format!("{curved} triangles of curved reflectors are drawn black"));
    }
    if lenses > 0 {
        report.fallbacks.insert("lens_triangles", lenses);
        report.warnings.push(format!("{lenses} triangles of lenses are drawn black"));
    }
    (mirrors, report)
}

impl Prepared for PreparedMirrors {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, _progress: &dyn Progress) -> Result<(), RenderError> {
        *self = Self::new(&self.settings, scene, quality);
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(MirrorFrame { prepared: self, view: view.clone() }))
    }
}

impl Frame for MirrorFrame<'_> {
    fn report(&self) -> &Report {
        Report::none()
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let PreparedMirrors { scene, quality, .. } = self.prepared;
        let mut watch = Stopwatch::new();
        let (lists, left_out) = self.lists(progress)?;
        let mut report = Report { stages_ms: vec![("project", watch.lap_ms())], ..Report::default() };
        report.counts.insert("lists", lists.len() as u64);
        report.counts.insert("vertices_projected", lists.iter().map(|list| list.vertices.len() as u64).sum());
        report.counts.insert("virtual_triangles", lists[1..].iter().map(|list| list.triangles.len() as u64).sum());
        if left_out > 0 {
            report.fallbacks.insert("lists_left_out", left_out);
            report.warnings.push(left_out_warning(left_out));
        }
        let shader = PathShader::new(scene, &self.view, quality.samples);
        report.add_raster(&raster::draw(&self.view, quality.samples, &lists, &shader, target, progress)?);
        shader.describe(PixelsByOthers::default(), &mut report);
        Ok(report)
    }

    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        let (scene, view) = (&self.prepared.scene, &self.view);
        let (lists, _) = self.lists(progress)?;
        let shown = ShownPixels::of(scene, view, |shader, target| {
            raster::draw(view, 1, &lists, shader, target, progress).map(drop)
        })?;
        Ok(match kind {
            OverlayKind::Paths => Some(overlays::paths(scene, &shown, &PathBeginnings::default())),
            OverlayKind::VirtualTriangles => Some(overlays::virtual_triangles(scene, view, &lists, &shown, progress)?),
            OverlayKind::Tiles | OverlayKind::Leaves | OverlayKind::Layers => None,
        })
    }

    fn projector(&self) -> Option<Box<dyn VertexProjector + '_>> {
        let PreparedMirrors { scene, quality, mirrors, .. } = self.prepared;
        let (paths, _) = self.visible_paths(quality.order.min(MAX_BOUNCES as u32));
        Some(Box::new(MirrorProjector::new(scene, mirrors, &self.view, &paths)))
    }

    fn path_search(&self, eye: DVec3, objects: &[u32]) -> Result<Option<Box<dyn PathSearch + '_>>, RenderError> {
        let PreparedMirrors { scene, quality, mirrors, .. } = self.prepared;
        Ok(Some(Box::new(MirrorSearch::new(scene, mirrors, eye, quality.order, objects)?)))
    }
}

impl MirrorFrame<'_> {
    /// The lists of the direct view and of mirrored copies, and the number of copies that are left out.
    fn lists(&self, progress: &dyn Progress) -> Result<(Vec<DrawList>, u64), Cancelled> {
        let PreparedMirrors { scene, quality, mirrors, .. } = self.prepared;
        let (paths, left_out) = self.visible_paths(quality.order);
        let (order, others) = (quality.order, OtherReflectors::Black);
        let scenes = MirroredScenes { scene, mirrors, view: &self.view, order, others, follows_lenses: false };
        let lists = parallel::map_stage(progress, "mirroring", paths.len(), |path| scenes.list(&paths[path]))?;
        Ok((lists, left_out))
    }

    /// The paths of up to `order` mirrors that the view shows, and the number of those beyond `max_lists`.
    fn visible_paths(&self, order: u32) -> (Vec<MirrorPath>, u64) {
        let PreparedMirrors { settings, scene, mirrors, .. } = self.prepared;
        visible_paths(scene, mirrors, &self.view, order, most_lists(settings, scene))
    }
}

/// The maximum number of copies of a scene that are drawn in a frame.
fn most_lists(settings: &PlanarMirrorSettings, scene: &Scene) -> usize {
    (MAX_TRIANGLES / scene.triangles.len().max(1)).clamp(1, settings.max_lists as usize)
}

fn left_out_warning(left_out: u64) -> String {
    format!("{left_out} mirrored copies of the scene are left out; max_lists and the number of triangles limit them")
}
