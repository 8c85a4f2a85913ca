//! A method for each reflector, chosen among those that are exact and cheap for it.
//!
//! See this folder's `README.md`.

mod limits;
mod settings;

pub use settings::AutoSettings;

use super::draw::MapsInView;
use super::draw::flat_mirrors::{MirroredScenes, Mirrors, OtherReflectors, visible_paths};
use super::draw::multiperspective::{TileModel, TiledScene, follows_lenses};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{Role, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::{
    About, Choice, Family, Frame, Job, Method, MethodInfo, Prepared, Quality, Report, Settings,
};
use catoptric_engine::raster::DrawList;
use std::sync::Arc;

/// Triangles of all mirrored copies in a view: beyond, flat mirrors are drawn by tiles. Copies of as many triangles
/// take about as long as tiles that fill the picture. Chosen, not measured.
const MAX_COPIED_TRIANGLES: usize = 600_000;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "auto",
    family: Family::Projection,
    summary: "flat mirrors by mirrored copies of the scene, everything else by multiperspective rasterisation",
    paper: "this project",
    assumptions: "none beyond those of the reference; analytic surfaces are seen in reflectors by their triangles",
    about: About {
        readme: include_str!("README.md"),
        draws: "everything: flat mirrors by mirrored copies of the scene, curved mirrors and glass by tiles, deep \
            paths in glass by rays of its own",
        costs: "nothing beforehand; a frame of 16 samples takes a fifth to a twelfth of the reference's time, with \
            fewer samples less is gained",
        cannot: "edges in curved mirrors and glass may be off by accuracy_px",
        useful: &["accuracy_px"],
    },
    cpu: true,
    gpu: true,
    bake: None,
    settings: AutoSettings::describe,
    effective: AutoSettings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new(Auto { settings: AutoSettings::from_table(table)? })),
};

struct Auto {
    settings: AutoSettings,
}

/// A scene, ready for any view.
struct PreparedChoice {
    settings: AutoSettings,
    scene: Arc<Scene>,
    quality: Quality,
    mirrors: Mirrors,
    tiled: TiledScene,
    /// Rays, in place of tiles, follow lenses.
    follows_lenses: bool,
    report: Report,
}

/// A frame: the prepared method for one view.
struct ChoiceFrame<'a> {
    prepared: &'a PreparedChoice,
    view: View,
}

impl Method for Auto {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn overlays(&self) -> &'static [OverlayKind] {
        &[OverlayKind::Paths, OverlayKind::VirtualTriangles, OverlayKind::Tiles]
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        INFO.refuse_bake(bake)?;
        Ok(Box::new(PreparedChoice::new(&self.settings, scene, quality, None, progress)?))
    }
}

impl PreparedChoice {
    fn new(
        settings: &AutoSettings,
        scene: &Arc<Scene>,
        quality: Quality,
        old: Option<&Self>,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let mut watch = Stopwatch::new();
        // Mirrors with normal maps are treated as curved.
        let mirrors = Mirrors::find_among(scene, |object| scene.material_of(object).turning_map().is_none());
        let mut report = Report { stages_ms: vec![("find_mirrors", watch.lap_ms())], ..Report::default() };
        let mut tiled = TiledScene::new(scene, old.map(|old| &old.tiled), &mut report, progress)?;
        let follows_lenses = follows_lenses(scene, quality);
        if follows_lenses {
            tiled.follow_lenses();
        }
        report.choices = choices(scene, &mirrors, follows_lenses);
        let (settings, scene) = (settings.clone(), scene.clone());
        Ok(Self { settings, scene, quality, mirrors, tiled, follows_lenses, report })
    }
}

/// The most mirrored copies of a scene in one view.
fn max_copies(scene: &Scene) -> usize {
    MAX_COPIED_TRIANGLES / scene.triangles.len().max(1)
}

/// The method chosen for every reflector and lens, and the reason.
fn choices(scene: &Scene, mirrors: &Mirrors, follows_lenses: bool) -> Vec<Choice> {
    let mut planes = vec![0u32; scene.objects.len()];
    for plane in &mirrors.planes {
        planes[plane.object as usize] += 1;
    }
    let choose = |object: u32| {
        let (method, reason) = match (scene.role_of(object), planes[object as usize]) {
            (Role::Lens, _) if follows_lenses => {
                ("reference", "glass, and long paths or bodies that meet: by rays".to_owned())
            }
            (Role::Lens, _) => ("multiperspective", "glass".to_owned()),
            (_, 0) if scene.material_of(object).turning_map().is_some() => ("multiperspective", "bumpy".to_owned()),
            (_, 0) => ("multiperspective", "curved".to_owned()),
            (_, _) if max_copies(scene) == 0 => {
                let reason = format!("flat, but a copy of the scene has {} triangles", scene.triangles.len());
                ("multiperspective", reason)
            }
            (_, 1) => ("planar_mirror", "flat".to_owned()),
            (_, faces) => ("planar_mirror", format!("{faces} flat faces")),
        };
        Choice { object: scene.objects[object as usize].name.clone(), method, reason }
    };
    scene.specular_objects().into_iter().map(choose).collect()
}

impl Prepared for PreparedChoice {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        *self = Self::new(&self.settings, scene, quality, Some(self), progress)?;
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(ChoiceFrame { prepared: self, view: view.clone() }))
    }
}

impl Frame for ChoiceFrame<'_> {
    fn report(&self) -> &Report {
        Report::none()
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let PreparedChoice { scene, quality, tiled, .. } = self.prepared;
        let mut watch = Stopwatch::new();
        let lists = self.lists(progress)?;
        let mut report = Report { stages_ms: vec![("project", watch.lap_ms())], ..Report::default() };
        report.counts.insert("lists", lists.len() as u64);
        let job = Job { scene, view: &self.view, quality: *quality, progress };
        report.add(tiled.draw(&job, &lists, Some(self.model()), MapsInView::default(), target)?);
        Ok(report)
    }

    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        let PreparedChoice { scene, quality, tiled, .. } = self.prepared;
        let job = Job { scene, view: &self.view, quality: *quality, progress };
        tiled.overlay(kind, &job, &self.lists(progress)?, self.model())
    }
}

impl ChoiceFrame<'_> {
    /// The lists of the direct view, and of the copies of the scene in flat mirrors.
    fn lists(&self, progress: &dyn Progress) -> Result<Vec<DrawList>, Cancelled> {
        let PreparedChoice { scene, quality, mirrors, follows_lenses, .. } = self.prepared;
        // Paths that have no copy are drawn by tiles.
        let (paths, _) = visible_paths(scene, mirrors, &self.view, quality.order, 1 + max_copies(scene));
        let (order, others) = (quality.order, OtherReflectors::GoOn);
        let (view, follows_lenses) = (&self.view, *follows_lenses);
        let scenes = MirroredScenes { scene, mirrors, view, order, others, follows_lenses };
        parallel::map_stage(progress, "mirroring", paths.len(), |path| scenes.list(&paths[path]))
    }

    fn model(&self) -> TileModel {
        TileModel { accuracy_px: self.prepared.settings.accuracy_px, by_rays: false, turns_normals: true }
    }
}
