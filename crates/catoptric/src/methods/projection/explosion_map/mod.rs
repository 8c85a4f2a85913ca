//! Explosion maps: reflected rays of a reflector's vertices, by where they hit a near and a far sphere, tell where
//! every point appears.
//!
//! See this folder's `README.md`.

mod cells;
mod chart;
mod map;
mod samples;
mod settings;
mod subdivision;
mod vertices;

pub use settings::{ExplosionMapSettings, Preset, Variant, VirtualVertex};
pub use vertices::ReflectorMap;

use super::virtual_objects::{Levels, Options, Recursion, Reflector, ReflectorMesh, VirtualObjects};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projection::VertexProjector;
use crate::methods::projection::ray_map::eye_of;
use crate::methods::projection::virtual_mesh::{MeshQuality, PictureScale};
use crate::methods::projection::virtual_scene::{MAX_PIECES, VirtualScene};
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::parallel;
use crate::progress::Progress;
use crate::scene::{PreciseView, Scene, View};
use crate::surface::site::SpecularSurfaces;
use map::ExplosionMap;

/// What explosion maps are.
pub static INFO: MethodInfo = MethodInfo {
    id: "explosion_map",
    family: Family::Projection,
    summary: "maps of where a reflector's rays hit a near and a far sphere say in which tangent plane a vertex is mirrored",
    paper: "Ofek, Rappoport 1998, Interactive reflections on curved objects",
    assumptions: "reflectors are finely tessellated; the spheres about them hold nothing but them; answers are approximate",
    cpu: true,
    gpu: false,
    bake: false,
    settings: ExplosionMapSettings::describe,
    in_force: ExplosionMapSettings::in_force,
    create: |table| Ok(Box::new(ExplosionMapMethod::new(ExplosionMapSettings::from_table(table)?))),
};

/// Appearances behind other parts of a reflector are told by a picture of it with this many texels a side.
const EYE_IMAGE_SIZE: u32 = 256;

/// The method with what it keeps from frame to frame.
struct ExplosionMapMethod {
    settings: ExplosionMapSettings,
    scene: Option<VirtualScene>,
    meshes: Vec<ReflectorMesh>,
    frame: Option<Frame>,
}

/// What depends on the view and the mirrors, but not on what moves among them.
struct Frame {
    view: View,
    order: u32,
    levels: Levels<ExplosionMap>,
}

impl ExplosionMapMethod {
    fn new(settings: ExplosionMapSettings) -> Self {
        Self { settings, scene: None, meshes: Vec::new(), frame: None }
    }

    /// Builds the maps where the kept ones do not fit the view.
    fn build(&mut self, job: &Job<'_>) -> Result<(), RenderError> {
        let Some(prepared) = &mut self.scene else { return Err(unprepared()) };
        if !prepared.fits(job.scene) {
            return Err(unprepared());
        }
        let order = job.quality.order;
        if self.frame.as_ref().is_some_and(|frame| frame.view == *job.view && frame.order == order) {
            return Ok(());
        }
        let settings = &self.settings;
        let make = |reflector: &Reflector<'_>| ExplosionMap::new(reflector, &job.scene.bounds, settings);
        let levels = Levels::build(job.scene, &self.meshes, job.view, order, EYE_IMAGE_SIZE, make);
        self.frame = Some(Frame { view: job.view.clone(), order, levels });
        prepared.forget_meshes();
        Ok(())
    }
}

fn projector<'a>(
    settings: &ExplosionMapSettings,
    frame: &'a Frame,
    meshes: &'a [ReflectorMesh],
    job: &Job<'_>,
    surfaces: SpecularSurfaces<'a>,
) -> VirtualObjects<'a, ExplosionMap> {
    VirtualObjects {
        levels: &frame.levels,
        meshes,
        surfaces,
        eye: eye_of(job.view),
        picture: job.view.picture_from_world(),
        view: PreciseView::new(job.view),
        options: Options {
            polish: settings.polish,
            // The solver starts at feet that obey the law as well as the mesh knows.
            recursion: match settings.virtual_vertex {
                VirtualVertex::Mirrored if settings.polish == 0 => Recursion::VirtualPoints,
                _ => Recursion::Feet,
            },
        },
    }
}

fn unprepared() -> RenderError {
    RenderError::Limit { method: INFO.id, problem: "it has not been prepared for the scene".into() }
}

impl ReflectionMethod for ExplosionMapMethod {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, _quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut report = VirtualScene::prepare(&mut self.scene, &mut self.frame, scene);
        if self.frame.is_none() {
            let mut watch = Stopwatch::new();
            let objects = scene.specular_objects();
            let longest_edge = self.settings.longest_edge;
            let mesh = |index: usize| ReflectorMesh::new(scene, objects[index], longest_edge);
            self.meshes = parallel::map_collect(objects.len(), mesh);
            report.stages_ms.push(("reflectors", watch.lap_ms()));
        }
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        self.build(job)?;
        report.stages_ms.push(("build", watch.lap_ms()));
        let (Some(scene), Some(frame)) = (&mut self.scene, &self.frame) else { return Err(unprepared()) };
        report.bytes.insert("maps", frame.levels.byte_count());
        let surfaces = scene.surfaces(job.scene);
        let projector = projector(&self.settings, frame, &self.meshes, job, surfaces);
        let quality = MeshQuality {
            edge_error_px: self.settings.edge_error_px,
            piece_px: self.settings.piece_px,
            picture: PictureScale::new(job.view),
            max_pieces: MAX_PIECES,
        };
        scene.draw(job, &projector, &quality, None, &mut report, target)?;
        Ok(report)
    }

    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        self.build(job)?;
        let (Some(scene), Some(frame)) = (&self.scene, &self.frame) else { return Err(unprepared()) };
        let surfaces = scene.surfaces(job.scene);
        Ok(Some(Box::new(projector(&self.settings, frame, &self.meshes, job, surfaces))))
    }
}
