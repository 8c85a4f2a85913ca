//! Flat mirrors by mirrored geometry and stencil, to any order.
//!
//! See this folder's `README.md`.

mod chain;
mod paths;
mod planes;
mod projector;
mod search;
mod settings;

pub use settings::PlanarMirrorSettings;

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projection::drawing::PathShader;
use crate::methods::projection::finder::PathSearch;
use crate::methods::projection::projector::{MAX_BOUNCES, VertexProjector};
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::parallel;
use crate::progress::Progress;
use crate::raster::{self, DrawList, DrawTriangle, Stencil};
use crate::scene::Scene;
use glam::DVec3;
use paths::{MirrorPath, visible_paths};
use planes::Mirrors;
use projector::MirrorProjector;
use search::MirrorSearch;

/// What planar mirrors are.
pub static INFO: MethodInfo = MethodInfo {
    id: "planar_mirror",
    family: Family::Projection,
    summary: "flat mirrors: the scene mirrored in each, clipped and stencilled, mirrors in mirrors to any order",
    paper: "Diefenbach, Badler 1997, Multi-pass pipeline rendering: realism for dynamic environments",
    assumptions: "reflectors are flat or have at most 64 flat faces; curved ones and lenses are drawn black",
    cpu: true,
    gpu: false,
    bake: None,
    settings: PlanarMirrorSettings::describe,
    in_force: PlanarMirrorSettings::in_force,
    create: |table| {
        Ok(Box::new(PlanarMirror { settings: PlanarMirrorSettings::from_table(table)?, mirrors: Mirrors::default() }))
    },
};

struct PlanarMirror {
    settings: PlanarMirrorSettings,
    mirrors: Mirrors,
}

impl ReflectionMethod for PlanarMirror {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, _quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        self.mirrors = Mirrors::find(scene);
        let mut report = Report { stages_ms: vec![("find_mirrors", watch.lap_ms())], ..Report::default() };
        report.counts.insert("mirrors", self.mirrors.planes.len() as u64);
        let (curved, lenses) = (self.mirrors.curved_triangles, self.mirrors.lens_triangles);
        if curved > 0 {
            report.fallbacks.insert("curved_triangles", curved);
            report.warnings.push(format!("{curved} triangles of curved reflectors are drawn black"));
        }
        if lenses > 0 {
            report.fallbacks.insert("lens_triangles", lenses);
            report.warnings.push(format!("{lenses} triangles of lenses are drawn black"));
        }
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let scene = job.scene;
        self.check_prepared(scene)?;
        let mut watch = Stopwatch::new();
        let max_paths = self.settings.max_lists as usize;
        let (paths, left_out) = visible_paths(scene, &self.mirrors, job.view, job.quality.order, max_paths);
        let lists = parallel::map_collect(paths.len(), |path| self.mirrored_scene(job, &paths[path]));
        let mut report = Report { stages_ms: vec![("project", watch.lap_ms())], ..Report::default() };
        report.counts.insert("lists", lists.len() as u64);
        report.counts.insert("vertices_projected", lists.iter().map(|list| list.vertices.len() as u64).sum());
        report.counts.insert("virtual_triangles", lists[1..].iter().map(|list| list.triangles.len() as u64).sum());
        if left_out > 0 {
            report.fallbacks.insert("lists_left_out", left_out);
            report.warnings.push(format!("{left_out} mirrored copies of the scene are left out; raise max_lists"));
        }
        let shader = PathShader::new(scene, job.view);
        report.add_raster(&raster::draw(job.view, job.quality.samples, &lists, &shader, target)?);
        Ok(report)
    }

    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        self.check_prepared(job.scene)?;
        let order = job.quality.order.min(MAX_BOUNCES as u32);
        let max_paths = self.settings.max_lists as usize;
        let (paths, _) = visible_paths(job.scene, &self.mirrors, job.view, order, max_paths);
        Ok(Some(Box::new(MirrorProjector::new(job.scene, &self.mirrors, job.view, &paths))))
    }

    fn path_search<'a>(
        &'a mut self,
        job: &Job<'a>,
        eye: DVec3,
        objects: &[u32],
    ) -> Result<Option<Box<dyn PathSearch + 'a>>, RenderError> {
        self.check_prepared(job.scene)?;
        Ok(Some(Box::new(MirrorSearch::new(job.scene, &self.mirrors, eye, job.quality.order, objects)?)))
    }
}

impl PlanarMirror {
    fn check_prepared(&self, scene: &Scene) -> Result<(), RenderError> {
        if self.mirrors.mirror_of_triangle.len() == scene.triangles.len() {
            return Ok(());
        }
        let problem = "it has not been prepared for the scene".into();
        Err(RenderError::Limit { method: INFO.id, problem })
    }

    /// The scene as it is seen at the end of a path, in front of its last mirror.
    fn mirrored_scene(&self, job: &Job<'_>, path: &MirrorPath) -> DrawList {
        let (scene, goes_on) = (job.scene, path.order < job.quality.order);
        let picture = job.view.picture_from_moved(&path.world_from_scene);
        let vertices = scene.positions.iter().map(|position| picture.apply(*position)).collect();
        let clip_distances: Vec<f32> = match path.mirror {
            Some(_) => {
                let height = |position: &glam::Vec3| path.height(&self.mirrors, position.as_dvec3()) as f32;
                scene.positions.iter().map(height).collect()
            }
            None => Vec::new(),
        };
        let own = path.mirror.map_or(0, |mirror| mirror + 1);
        let visible = |triangle: &u32| {
            let corners = scene.triangles[*triangle as usize];
            let in_front = path.mirror.is_none() || corners.iter().any(|&vertex| clip_distances[vertex as usize] > 0.0);
            in_front && (own == 0 || self.mirrors.mirror_of_triangle[*triangle as usize] != own)
        };
        let triangles = (0..scene.triangles.len() as u32).filter(visible).map(|triangle| DrawTriangle {
            vertices: scene.triangles[triangle as usize],
            source: triangle,
            patch: 0,
            // Group 0 of a reflector is black: those of the last order, and curved ones.
            group: if goes_on { self.mirrors.mirror_of_triangle[triangle as usize] } else { 0 },
            alpha_tested: scene.is_alpha_tested(scene.triangle_objects[triangle as usize]),
        });
        let stencil = path.parent.map(|list| Stencil { list, group: own, ..Stencil::default() });
        DrawList {
            triangles: triangles.collect(),
            vertices,
            clip_distances,
            layer: path.order,
            stencil,
            ..DrawList::default()
        }
    }
}
