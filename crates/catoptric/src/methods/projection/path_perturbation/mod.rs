//! Perturbation of specular paths: a sparse set of traced rays, expanded to second order, tells where everything
//! appears.
//!
//! See this folder's `README.md`.

mod project;
mod settings;

pub use settings::{Candidates, ExpansionOrder, PathPerturbationSettings};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::math::Aabb;
use crate::methods::projection::VertexProjector;
use crate::methods::projection::ray_map::{RayMap, Sampling, Specular, ViewField, eye_of};
use crate::methods::projection::virtual_mesh::MeshQuality;
use crate::methods::projection::virtual_scene::VirtualScene;
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::progress::Progress;
use crate::scene::{PreciseView, Scene, View};
use crate::surface::site::SpecularSurfaces;
use glam::Vec3;
use project::{Perturber, rule};

/// What the perturbation method is.
pub static INFO: MethodInfo = MethodInfo {
    id: "path_perturbation",
    family: Family::Projection,
    summary: "a sparse set of traced specular paths, perturbed to second order, and polished, shows where vertices appear",
    paper: "Chen, Arvo 2000, Perturbation methods for interactive specular reflections",
    assumptions: "reflectors and lenses are smooth; reflections smaller than the finest sample spacing can be missed",
    cpu: true,
    gpu: false,
    bake: None,
    settings: PathPerturbationSettings::describe,
    in_force: PathPerturbationSettings::in_force,
    create: |table| Ok(Box::new(PathPerturbation::new(PathPerturbationSettings::from_table(table)?))),
};

/// The least edge error and size of pieces without polish.
const COARSE_PX: (f32, f32) = (1.0, 3.0);

/// The method with what it keeps from frame to frame.
struct PathPerturbation {
    settings: PathPerturbationSettings,
    scene: Option<VirtualScene>,
    frame: Option<Frame>,
}

/// What depends on the view and the mirrors, but not on what moves among them.
struct Frame {
    view: View,
    order: u32,
    map: RayMap,
}

impl PathPerturbation {
    fn new(settings: PathPerturbationSettings) -> Self {
        Self { settings, scene: None, frame: None }
    }

    /// The mirrors of the scene that was prepared, made ready for solvers.
    fn surfaces<'a>(&self, scene: &'a Scene) -> Result<SpecularSurfaces<'a>, RenderError> {
        Ok(self.scene.as_ref().ok_or_else(unprepared)?.surfaces(scene))
    }

    /// Builds the ray map where the kept one does not fit the view.
    fn build(&mut self, job: &Job<'_>, surfaces: &SpecularSurfaces<'_>) -> Result<u64, RenderError> {
        let Some(prepared) = &mut self.scene else { return Err(unprepared()) };
        if !prepared.fits(job.scene) {
            return Err(unprepared());
        }
        let order = job.quality.order;
        if self.frame.as_ref().is_some_and(|frame| frame.view == *job.view && frame.order == order) {
            return Ok(0);
        }
        let settings = &self.settings;
        let sampling = Sampling {
            spacing_px: settings.spacing_px,
            finest_px: settings.finest_px,
            accuracy_px: settings.accuracy_px,
            max_cells: settings.max_samples as usize,
        };
        let specular = Specular { scene: job.scene, tracer: prepared.tracer(), surfaces, order };
        let field = ViewField::new(job.view, margin_px(settings));
        let map = RayMap::build(&specular, &field, &sampling, &around(&job.scene.bounds), rule(settings));
        let traced = map.rays_traced;
        self.frame = Some(Frame { view: job.view.clone(), order, map });
        prepared.forget_meshes();
        Ok(traced)
    }
}

/// What projects points, of a ray map that was made for the view.
fn perturber<'a>(
    settings: &'a PathPerturbationSettings,
    frame: &'a Frame,
    job: &Job<'_>,
    surfaces: SpecularSurfaces<'a>,
) -> Perturber<'a> {
    let sizes = job.scene.objects.iter().map(|object| f64::from(object.bounds.diagonal()));
    Perturber {
        map: &frame.map,
        surfaces,
        paths: frame.map.groups.iter().map(|group| group.path.clone()).collect(),
        eye: eye_of(job.view),
        view: PreciseView::new(job.view),
        settings,
        margin_px: margin_px(settings).into(),
        sizes: sizes.collect(),
    }
}

/// What appears just outside the picture belongs to triangles that reach into it.
fn margin_px(settings: &PathPerturbationSettings) -> f32 {
    2.0 * settings.spacing_px
}

fn unprepared() -> RenderError {
    RenderError::Limit { method: INFO.id, problem: "it has not been prepared for the scene".into() }
}

/// A box a little larger than the scene's.
fn around(bounds: &Aabb) -> Aabb {
    let margin = Vec3::splat(bounds.diagonal() * 0.01);
    Aabb { min: bounds.min - margin, max: bounds.max + margin }
}

impl ReflectionMethod for PathPerturbation {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, _quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        Ok(VirtualScene::prepare(&mut self.scene, &mut self.frame, scene))
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        let surfaces = self.surfaces(job.scene)?;
        let traced = self.build(job, &surfaces)?;
        report.counts.insert("rays_traced", traced);
        report.stages_ms.push(("build", watch.lap_ms()));

        let (Some(scene), Some(frame)) = (&mut self.scene, &self.frame) else { return Err(unprepared()) };
        report.counts.insert("sample_rays", frame.map.samples as u64);
        report.bytes.insert("ray_map", frame.map.byte_count());
        let perturber = perturber(&self.settings, frame, job, surfaces);
        // What expansions alone say of neighbouring points differs by more than the finest pieces.
        let (edge_error_px, piece_px) = if self.settings.polish == 0 { COARSE_PX } else { (0.0, 0.0) };
        let (edge_error_px, piece_px) =
            (self.settings.edge_error_px.max(edge_error_px), self.settings.piece_px.max(piece_px));
        let quality = MeshQuality::new(job.view, edge_error_px, piece_px);
        scene.draw(job, &perturber, &quality, None, &mut report, target)?;
        Ok(report)
    }

    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        let surfaces = self.surfaces(job.scene)?;
        self.build(job, &surfaces)?;
        let frame = self.frame.as_ref().ok_or_else(unprepared)?;
        Ok(Some(Box::new(perturber(&self.settings, frame, job, surfaces))))
    }
}
