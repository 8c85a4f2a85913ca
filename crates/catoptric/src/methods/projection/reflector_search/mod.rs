//! The search in pictures of reflectors: a point appears where a reflector's normal is the half vector of the directions
//! to the eye and to the point.
//!
//! See this folder's `README.md`.

mod batch;
mod candidates;
mod cell;
mod cube;
mod image;
mod law;
mod origins;
mod pictures;
mod search;
mod settings;
mod starts;
#[cfg(test)]
mod tests;

pub use pictures::ReflectorPictures;
pub use settings::{Images, Refine, ReflectorSearchSettings};

use super::virtual_objects::{Kept, LONGEST_EDGE, Options, Recursion};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projection::VertexProjector;
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::parallel;
use crate::progress::Progress;
use crate::scene::Scene;
use image::ReflectorImage;
use search::ReflectorSearch;
use std::sync::Arc;

/// What the search in pictures of reflectors is.
pub static INFO: MethodInfo = MethodInfo {
    id: "reflector_search",
    family: Family::Projection,
    summary: "a picture of the reflector's positions and normals is searched for the half vector of every vertex",
    paper: "Estalella, Martin, Drettakis, Tost 2006, A GPU-driven algorithm for accurate interactive reflections on curved objects",
    assumptions: "reflectors are finely tessellated and smooth between creases; answers are approximate",
    cpu: true,
    gpu: false,
    bake: None,
    settings: ReflectorSearchSettings::describe,
    in_force: ReflectorSearchSettings::in_force,
    create: |table| Ok(Box::new(ReflectorSearchMethod::new(ReflectorSearchSettings::from_table(table)?))),
};

/// The method with what it keeps from frame to frame.
struct ReflectorSearchMethod {
    settings: ReflectorSearchSettings,
    kept: Kept<ReflectorSearch>,
    /// Of each mesh, once they are needed.
    cubes: Vec<Arc<ReflectorImage>>,
}

impl ReflectorSearchMethod {
    fn new(settings: ReflectorSearchSettings) -> Self {
        Self { settings, kept: Kept::new(INFO.id), cubes: Vec::new() }
    }

    /// Makes the cube maps that are missing, if paths of this order need them.
    fn make_cubes(&mut self, order: u32) {
        let needed = order > 1 || self.settings.images == Images::Cube;
        let meshes = self.kept.meshes();
        if needed && self.cubes.len() != meshes.len() {
            // As many texels around as there are in two pictures of half of it.
            let size = self.settings.map_size.div_ceil(2);
            self.cubes = meshes.iter().map(|mesh| Arc::new(ReflectorImage::around(mesh, size))).collect();
        }
    }

    /// Builds what depends on the view where the kept one does not fit it.
    fn build(&mut self, job: &Job<'_>) -> Result<(), RenderError> {
        if self.kept.fits(job)? {
            return Ok(());
        }
        self.make_cubes(job.quality.order);
        let (meshes, cubes, size) = (self.kept.meshes(), &self.cubes, self.settings.map_size);
        let from_eye = |index: usize| ReflectorImage::from_eye(&meshes[index], job.view, size).map(Arc::new);
        let images = self.settings.images;
        let seen = match images {
            Images::Eye => parallel::map_collect(meshes.len(), from_eye),
            Images::Cube => Vec::new(),
        };
        self.kept.build(job, |reflector| {
            let image = match (reflector.index, reflector.view, images) {
                (Some(index), Some(_), Images::Eye) => seen.get(index as usize)?.clone()?,
                (Some(index), ..) => cubes.get(index as usize)?.clone(),
                (None, ..) => Arc::new(ReflectorImage::around(reflector.mesh, size.div_ceil(2))),
            };
            ReflectorSearch::new(reflector, image)
        });
        Ok(())
    }

    fn options(&self) -> Options {
        let recursion = match self.settings.refine {
            Refine::Corrected => Recursion::Feet,
            Refine::Texel => Recursion::VirtualPoints,
        };
        Options { polish: self.settings.polish, recursion }
    }
}

impl ReflectionMethod for ReflectorSearchMethod {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        let (mut report, new) = self.kept.prepare(scene, LONGEST_EDGE);
        if new {
            self.cubes.clear();
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
        let sizes = [self.settings.edge_error_px, self.settings.piece_px];
        self.kept.draw(job, self.options(), sizes, &mut report, target)?;
        Ok(report)
    }

    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        self.build(job)?;
        Ok(Some(Box::new(self.kept.projector(job, self.options())?)))
    }
}
