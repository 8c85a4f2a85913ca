//! Sample-based cameras: trees of small cameras, fitted to a dense map of reflected rays, project scene points.
//!
//! See this folder's `README.md`.

mod answer;
mod bsp;
mod bundle;
mod bundles;
mod cameras;
mod creases;
mod finer;
mod fit;
mod follow;
mod grid;
mod hybrid;
mod layout;
mod panorama;
mod path_rays;
mod pieces;
mod pinhole;
mod project;
mod seen_first;
mod seen_pieces;
mod settings;

pub use panorama::{PanoramaSettings, PanoramicCameras, PanoramicMirrors, PanoramicProjection, PanoramicProjector};
pub use seen_pieces::seen_pieces;
pub use settings::{CameraKind, Preset, SampleBasedCameraSettings};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::math::Aabb;
use crate::methods::lookup::environment_map::ReflectorMaps;
use crate::methods::projection::VertexProjector;
use crate::methods::projection::ray_map::{Specular, ViewField, eye_of};
use crate::methods::projection::virtual_mesh::MeshQuality;
use crate::methods::projection::virtual_scene::VirtualScene;
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::parallel;
use crate::progress::Progress;
use crate::scene::{PreciseView, Scene, View};
use crate::surface::site::SpecularSurfaces;
use crate::surface::tracer::Tracer;
use cameras::{Builder, CameraDemand, Cameras, Counts};
use grid::{RayGrid, Sampler};
use project::CameraProjector;
use std::sync::Arc;

/// What sample-based cameras are.
pub static INFO: MethodInfo = MethodInfo {
    id: "sample_based_camera",
    family: Family::Projection,
    summary: "trees of small cameras, fitted to a dense map of reflected rays within an accuracy, show where vertices appear",
    paper: "Popescu, Sacks, Mei 2006, Sample-based cameras for fast accurate reflections",
    assumptions: "reflections smaller than the spacing of the ray map can be missed",
    cpu: true,
    gpu: false,
    bake: None,
    settings: SampleBasedCameraSettings::describe,
    in_force: SampleBasedCameraSettings::in_force,
    create: |table| Ok(Box::new(SampleBasedCamera::new(SampleBasedCameraSettings::from_table(table)?))),
};

/// Cells of the ray map around the picture: what appears there belongs to triangles that reach into it.
const MARGIN_CELLS: f32 = 4.0;

struct SampleBasedCamera {
    settings: SampleBasedCameraSettings,
    scene: Option<VirtualScene>,
    frame: Option<Frame>,
    /// The environment maps of the prepared scene, which objects have them, and for which order.
    maps: Option<(Vec<bool>, u32, ReflectorMaps)>,
}

/// What depends on the view and the mirrors, but not on what moves among them.
struct Frame {
    view: View,
    order: u32,
    /// The scene's box when they were built.
    bounds: Aabb,
    grid: RayGrid,
    /// The cameras of each group of the grid.
    cameras: Vec<Cameras>,
    /// Which objects show environment maps.
    mapped: Vec<bool>,
}

impl SampleBasedCamera {
    fn new(settings: SampleBasedCameraSettings) -> Self {
        Self { settings, scene: None, frame: None, maps: None }
    }

    /// Builds the cameras where the kept ones do not fit the view.
    fn build(&mut self, job: &Job<'_>, report: &mut Report) -> Result<(), RenderError> {
        let mut watch = Stopwatch::new();
        let Some(prepared) = &mut self.scene else { return Err(unprepared()) };
        if !prepared.fits(job.scene) {
            return Err(unprepared());
        }
        let order = job.quality.order;
        let field = ViewField::new(job.view, margin_px(&self.settings));
        let mapped = hybrid::mapped(&self.settings, job.scene, &field)?;
        // Rays are tested as far as the scene reached when the cameras were built.
        let bounds = job.scene.bounds;
        let fits = |frame: &Frame| {
            frame.view == *job.view
                && frame.order == order
                && frame.mapped == mapped
                && frame.bounds.union(bounds) == frame.bounds
        };
        if self.frame.as_ref().is_some_and(fits) {
            report.counts.insert("rays_traced", 0);
            return Ok(());
        }
        let surfaces = prepared.surfaces(job.scene);
        let specular = Specular { scene: job.scene, tracer: prepared.tracer(), surfaces: &surfaces, order };
        let sampler = Sampler::new(&specular, &field, self.settings.downsampling as f32, &mapped);
        let mut grid = RayGrid::new(&sampler);
        report.stages_ms.push(("ray_map", watch.lap_ms()));
        let SampleBasedCameraSettings { camera, accuracy_px, finest_ray_px, .. } = self.settings;
        let demand = CameraDemand { camera, accuracy_px: accuracy_px.into(), finest_ray_px };
        let cameras = grid.cameras(&sampler, &PreciseView::new(job.view), bounds, demand);
        report.counts.insert("rays_traced", grid.traced);
        report.stages_ms.push(("build", watch.lap_ms()));
        self.frame = Some(Frame { view: job.view.clone(), order, bounds, grid, cameras, mapped });
        prepared.forget_meshes();
        Ok(())
    }
}

impl RayGrid {
    /// The cameras of each group; rays that they need are added to these.
    fn cameras(
        &mut self,
        sampler: &Sampler<'_>,
        view: &PreciseView,
        bounds: Aabb,
        demand: CameraDemand,
    ) -> Vec<Cameras> {
        let built = parallel::map_collect(self.groups.len(), |group| {
            Builder { group: &self.groups[group], view, bounds, sampler, demand }.cameras()
        });
        let with_rays = built.into_iter().zip(&mut self.groups);
        let cameras = with_rays.map(|((mut cameras, added), group)| {
            self.traced += added.traced;
            if !added.rays.is_empty() {
                cameras.renumber(&group.add(added.rays));
            }
            cameras
        });
        cameras.collect()
    }
}

impl SampleBasedCamera {
    /// Captures the environment maps that the frame wants and the kept ones are not.
    fn capture(&mut self, job: &Job<'_>, report: &mut Report) -> Result<(), RenderError> {
        let Some(frame) = &self.frame else { return Err(unprepared()) };
        let count = frame.mapped.iter().filter(|&&mapped| mapped).count() as u64;
        if count == 0 {
            self.maps = None;
            return Ok(());
        }
        let mut watch = Stopwatch::new();
        let order = job.quality.order;
        if self.maps.as_ref().is_none_or(|kept| (&kept.0, kept.1) != (&frame.mapped, order)) {
            let maps = hybrid::captured(&self.settings, job.scene, &frame.mapped, order, job.progress)?;
            self.maps = Some((frame.mapped.clone(), order, maps));
        }
        report.stages_ms.push(("capture", watch.lap_ms()));
        report.fallbacks.insert("environment_mapped_reflectors", count);
        report.bytes.insert("environment_maps", self.maps.as_ref().map_or(0, |(.., maps)| maps.byte_count()));
        Ok(())
    }
}

fn margin_px(settings: &SampleBasedCameraSettings) -> f32 {
    MARGIN_CELLS * settings.downsampling as f32
}

fn unprepared() -> RenderError {
    RenderError::Limit { method: INFO.id, problem: "it has not been prepared for the scene".into() }
}

fn projector<'a>(
    settings: &SampleBasedCameraSettings,
    frame: &'a Frame,
    job: &Job<'a>,
    tracer: Arc<Tracer>,
    surfaces: SpecularSurfaces<'a>,
) -> CameraProjector<'a> {
    let sizes = job.scene.objects.iter().map(|object| f64::from(object.bounds.diagonal()));
    CameraProjector {
        grid: &frame.grid,
        cameras: &frame.cameras,
        paths: frame.grid.groups.iter().map(|group| group.path.clone()).collect(),
        eye: eye_of(job.view),
        view: PreciseView::new(job.view),
        field: ViewField::new(job.view, margin_px(settings)),
        scene: job.scene,
        tracer,
        surfaces,
        margin_px: margin_px(settings).into(),
        accuracy_px: settings.accuracy_px,
        polish: settings.polish,
        sizes: sizes.collect(),
    }
}

impl ReflectionMethod for SampleBasedCamera {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, _quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        self.maps = None;
        Ok(VirtualScene::prepare(&mut self.scene, &mut self.frame, scene))
    }

    fn prepare_view(&mut self, job: &Job<'_>) -> Result<Report, RenderError> {
        let mut report = Report::default();
        self.build(job, &mut report)?;
        self.capture(job, &mut report)?;
        let Some(frame) = &self.frame else { return Err(unprepared()) };
        let counts: Vec<Counts> = frame.cameras.iter().map(Cameras::counts).collect();
        let sum = |count: fn(&Counts) -> u64| counts.iter().map(count).sum::<u64>();
        report.counts.insert("ray_map_rays", frame.grid.groups.iter().map(|group| group.rays.len() as u64).sum());
        report.counts.insert("leaves", sum(|counts| counts.leaves));
        report.counts.insert("ray_lists", sum(|counts| counts.ray_lists));
        report.counts.insert("rays_in_lists", sum(|counts| counts.rays_in_lists));
        report.counts.insert("pieces", frame.grid.groups.iter().map(|group| u64::from(group.piece_count)).sum());
        report.bytes.insert("cameras", sum(|counts| counts.bytes));
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let mut report = self.prepare_view(job)?;
        let (Some(scene), Some(frame)) = (&mut self.scene, &self.frame) else { return Err(unprepared()) };
        let (tracer, surfaces) = (scene.tracer().clone(), scene.surfaces(job.scene));
        let projector = projector(&self.settings, frame, job, tracer, surfaces);
        let quality = MeshQuality::new(job.view, self.settings.edge_error_px, self.settings.piece_px);
        let maps = self.maps.as_ref().map(|(.., maps)| maps);
        scene.draw(job, &projector, &quality, maps, &mut report, target)?;
        Ok(report)
    }

    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        self.build(job, &mut Report::default())?;
        let (Some(scene), Some(frame)) = (&self.scene, &self.frame) else { return Err(unprepared()) };
        let (tracer, surfaces) = (scene.tracer().clone(), scene.surfaces(job.scene));
        Ok(Some(Box::new(projector(&self.settings, frame, job, tracer, surfaces))))
    }
}
