//! The search in pictures of reflectors: a point appears where a reflector's normal is the half vector of the directions
//! to the eye and to the point.
//!
//! See this folder's `README.md`.

mod candidates;
mod cell;
mod cube;
mod image;
mod law;
mod search;
mod settings;
#[cfg(test)]
mod tests;

pub use settings::{Images, Refine, ReflectorSearchSettings};

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
use image::ReflectorImage;
use search::ReflectorSearch;
use std::sync::Arc;

/// Edges of reflectors longer than this share of their radius are halved: corrections need small triangles.
const LONGEST_EDGE: f32 = 0.125;

/// What the search in pictures of reflectors is.
pub static INFO: MethodInfo = MethodInfo {
    id: "reflector_search",
    family: Family::Projection,
    summary: "a picture of the reflector's positions and normals is searched for the half vector of every vertex",
    paper: "Estalella, Martin, Drettakis, Tost 2006, A GPU-driven algorithm for accurate interactive reflections on curved objects",
    assumptions: "reflectors are finely tessellated and smooth between creases; answers are approximate",
    cpu: true,
    gpu: false,
    bake: false,
    settings: ReflectorSearchSettings::describe,
    in_force: ReflectorSearchSettings::in_force,
    create: |table| Ok(Box::new(ReflectorSearchMethod::new(ReflectorSearchSettings::from_table(table)?))),
};

/// Appearances behind other parts of a reflector are told by a picture of it with this many texels a side.
const EYE_IMAGE_SIZE: u32 = 256;

/// The method with what it keeps from frame to frame.
struct ReflectorSearchMethod {
    settings: ReflectorSearchSettings,
    scene: Option<VirtualScene>,
    meshes: Vec<ReflectorMesh>,
    /// Of each mesh, once they are needed.
    cubes: Vec<Arc<ReflectorImage>>,
    frame: Option<Frame>,
}

/// What depends on the view and the mirrors, but not on what moves among them.
struct Frame {
    view: View,
    order: u32,
    levels: Levels<ReflectorSearch>,
    bytes: u64,
}

impl ReflectorSearchMethod {
    fn new(settings: ReflectorSearchSettings) -> Self {
        Self { settings, scene: None, meshes: Vec::new(), cubes: Vec::new(), frame: None }
    }

    /// Makes the cube maps that are missing, if paths of this order need them.
    fn make_cubes(&mut self, order: u32) {
        let needed = order > 1 || self.settings.images == Images::Cube;
        if needed && self.cubes.len() != self.meshes.len() {
            // As many texels around as there are in two pictures of half of it.
            let size = self.settings.map_size.div_ceil(2);
            self.cubes = self.meshes.iter().map(|mesh| Arc::new(ReflectorImage::around(mesh, size))).collect();
        }
    }

    /// Builds what depends on the view where the kept one does not fit it.
    fn build(&mut self, job: &Job<'_>) -> Result<(), RenderError> {
        let fits = self.scene.as_ref().is_some_and(|prepared| prepared.fits(job.scene));
        if !fits {
            return Err(unprepared());
        }
        let order = job.quality.order;
        if self.frame.as_ref().is_some_and(|frame| frame.view == *job.view && frame.order == order) {
            return Ok(());
        }
        self.make_cubes(order);
        let (meshes, cubes, size) = (&self.meshes, &self.cubes, self.settings.map_size);
        let from_eye = |index: usize| ReflectorImage::from_eye(&meshes[index], job.view, size).map(Arc::new);
        let seen = match self.settings.images {
            Images::Eye => parallel::map_collect(meshes.len(), from_eye),
            Images::Cube => Vec::new(),
        };
        let make = |reflector: &Reflector<'_>| {
            let index = meshes.iter().position(|mesh| mesh.object == reflector.mesh.object)?;
            let image = match (reflector.view, self.settings.images) {
                (Some(_), Images::Eye) => seen.get(index)?.clone()?,
                _ => cubes.get(index)?.clone(),
            };
            ReflectorSearch::new(reflector, image)
        };
        let levels = Levels::build(job.scene, meshes, job.view, order, EYE_IMAGE_SIZE, make);
        let images = seen.iter().flatten().chain(cubes);
        let bytes = levels.byte_count() + images.map(|image| image.byte_count()).sum::<u64>();
        self.frame = Some(Frame { view: job.view.clone(), order, levels, bytes });
        if let Some(prepared) = &mut self.scene {
            prepared.forget_meshes();
        }
        Ok(())
    }
}

fn projector<'a>(
    settings: &ReflectorSearchSettings,
    frame: &'a Frame,
    meshes: &'a [ReflectorMesh],
    job: &Job<'_>,
    surfaces: SpecularSurfaces<'a>,
) -> VirtualObjects<'a, ReflectorSearch> {
    VirtualObjects {
        levels: &frame.levels,
        meshes,
        surfaces,
        eye: eye_of(job.view),
        picture: job.view.picture_from_world(),
        view: PreciseView::new(job.view),
        options: Options {
            polish: settings.polish,
            recursion: match settings.refine {
                Refine::Corrected => Recursion::Feet,
                Refine::Texel => Recursion::VirtualPoints,
            },
        },
    }
}

fn unprepared() -> RenderError {
    RenderError::Limit { method: INFO.id, problem: "it has not been prepared for the scene".into() }
}

impl ReflectionMethod for ReflectorSearchMethod {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut report = VirtualScene::prepare(&mut self.scene, &mut self.frame, scene);
        if self.frame.is_none() {
            let mut watch = Stopwatch::new();
            let objects = scene.specular_objects();
            let mesh = |index: usize| ReflectorMesh::new(scene, objects[index], LONGEST_EDGE);
            self.meshes = parallel::map_collect(objects.len(), mesh);
            self.cubes.clear();
            report.stages_ms.push(("reflectors", watch.lap_ms()));
        }
        let mut watch = Stopwatch::new();
        self.make_cubes(quality.order);
        report.stages_ms.push(("cube_maps", watch.lap_ms()));
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        self.build(job)?;
        report.stages_ms.push(("build", watch.lap_ms()));
        let (Some(scene), Some(frame)) = (&mut self.scene, &self.frame) else { return Err(unprepared()) };
        report.bytes.insert("maps", frame.bytes);
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
