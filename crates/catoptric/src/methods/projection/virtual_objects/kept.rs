//! What the methods of virtual objects keep from frame to frame, and the steps they share.

use super::levels::{Levels, Locator, Reflector};
use super::mesh::ReflectorMesh;
use super::projector::{Options, VirtualObjects};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projection::ray_map::eye_of;
use crate::methods::projection::virtual_mesh::MeshQuality;
use crate::methods::projection::virtual_scene::VirtualScene;
use crate::methods::{Job, Report};
use crate::parallel;
use crate::scene::{PreciseView, Scene, View};

/// Edges of reflectors longer than this share of their radius are halved: corrections need small triangles.
pub(in super::super) const LONGEST_EDGE: f32 = 0.125;

/// Appearances behind other parts of a reflector are told by a picture of it with this many texels a side.
const EYE_IMAGE_SIZE: u32 = 256;

/// The mirrors of a scene, and what was made of them for a view.
pub(in super::super) struct Kept<L> {
    method: &'static str,
    scene: Option<VirtualScene>,
    meshes: Vec<ReflectorMesh>,
    frame: Option<Frame<L>>,
}

/// What depends on the view and the mirrors, but not on what moves among them.
struct Frame<L> {
    view: View,
    order: u32,
    levels: Levels<L>,
}

impl<L: Locator> Kept<L> {
    /// Nothing yet, for the method with this name.
    pub(in super::super) fn new(method: &'static str) -> Self {
        Self { method, scene: None, meshes: Vec::new(), frame: None }
    }

    /// The mirrors as meshes, in the order of [`Reflector::index`].
    pub(in super::super) fn meshes(&self) -> &[ReflectorMesh] {
        &self.meshes
    }

    /// Takes a scene in, with edges of reflectors no longer than `longest_edge` (a share of their radius); says whether
    /// its mirrors are new.
    pub(in super::super) fn prepare(&mut self, scene: &Scene, longest_edge: f32) -> (Report, bool) {
        let mut report = VirtualScene::prepare(&mut self.scene, &mut self.frame, scene);
        let objects = scene.specular_objects();
        let new = self.frame.is_none() || self.meshes.len() != objects.len();
        if new {
            let mut watch = Stopwatch::new();
            self.meshes =
                parallel::map_collect(objects.len(), |index| ReflectorMesh::new(scene, objects[index], longest_edge));
            report.stages_ms.push(("reflectors", watch.lap_ms()));
        }
        (report, new)
    }

    /// Whether what is kept was made for the view and the order.
    ///
    /// # Errors
    /// [`RenderError::Limit`] when the scene has not been prepared.
    pub(in super::super) fn fits(&self, job: &Job<'_>) -> Result<bool, RenderError> {
        if !self.scene.as_ref().is_some_and(|prepared| prepared.fits(job.scene)) {
            return Err(self.unprepared());
        }
        Ok(self.frame.as_ref().is_some_and(|frame| frame.view == *job.view && frame.order == job.quality.order))
    }

    /// Builds the levels of a view; `make` is asked as by [`Levels::build`].
    pub(in super::super) fn build(&mut self, job: &Job<'_>, make: impl Fn(&Reflector<'_>) -> Option<L>) {
        let order = job.quality.order;
        let levels = Levels::build(job.scene, &self.meshes, job.view, order, EYE_IMAGE_SIZE, make);
        self.frame = Some(Frame { view: job.view.clone(), order, levels });
        if let Some(scene) = &mut self.scene {
            scene.forget_meshes();
        }
    }

    /// Draws the picture with what was built; `sizes` are the finest virtual edges' error and the smallest pieces, in
    /// pixels.
    ///
    /// # Errors
    /// [`RenderError::Limit`] when nothing was built, and those of the rasteriser.
    pub(in super::super) fn draw(
        &mut self,
        job: &Job<'_>,
        options: Options,
        [edge_error_px, piece_px]: [f32; 2],
        report: &mut Report,
        target: &mut Framebuffer,
    ) -> Result<(), RenderError> {
        let unprepared = self.unprepared();
        let (Some(scene), Some(frame)) = (&mut self.scene, &self.frame) else { return Err(unprepared) };
        report.bytes.insert("maps", frame.levels.byte_count());
        let projector = frame.projector(&self.meshes, scene, job, options);
        let quality = MeshQuality::new(job.view, edge_error_px, piece_px);
        scene.draw(job, &projector, &quality, None, report, target)
    }

    /// A projector by what was built.
    ///
    /// # Errors
    /// [`RenderError::Limit`] when nothing was built.
    pub(in super::super) fn projector<'a>(
        &'a self,
        job: &Job<'a>,
        options: Options,
    ) -> Result<VirtualObjects<'a, L>, RenderError> {
        let (Some(scene), Some(frame)) = (&self.scene, &self.frame) else { return Err(self.unprepared()) };
        Ok(frame.projector(&self.meshes, scene, job, options))
    }

    fn unprepared(&self) -> RenderError {
        RenderError::Limit { method: self.method, problem: "it has not been prepared for the scene".into() }
    }
}

impl<L: Locator> Frame<L> {
    fn projector<'a>(
        &'a self,
        meshes: &'a [ReflectorMesh],
        scene: &VirtualScene,
        job: &Job<'a>,
        options: Options,
    ) -> VirtualObjects<'a, L> {
        VirtualObjects {
            levels: &self.levels,
            meshes,
            surfaces: scene.surfaces(job.scene),
            eye: eye_of(job.view),
            picture: job.view.picture_from_world(),
            view: PreciseView::new(job.view),
            options,
        }
    }
}
