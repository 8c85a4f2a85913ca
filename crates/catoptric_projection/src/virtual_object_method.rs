//! The life cycle of methods of virtual objects: one implementation for all of them.

use crate::draw::prepared::{Context, MeshProjection};
use crate::draw::stages::{Stages, mirror_tracer};
use crate::draw::virtual_mesh::MeshQuality;
use crate::draw::work_limit::{BeyondWork, WorkLimit};
use crate::find::lens_check::{COARSE_TOLERANCE_PX, TOLERANCE_PX, has_lens, wrong_in_lenses};
use crate::find::ray_map::{Specular, eye_of};
use crate::find::virtual_objects::{Locator, Options, PathLimits, PathTree, Recursion, Reflector};
use crate::find::virtual_objects::{ReflectorMesh, VirtualObjects};
use catoptric_core::parallel;
use catoptric_core::scene::{PreciseView, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::{MethodInfo, Quality, Report};
use catoptric_engine::raster::BlockMask;
use std::sync::Arc;

/// Edges of reflectors longer than this share of their radius are halved: corrections need small triangles.
pub(crate) const LONGEST_EDGE: f32 = 0.125;

/// Texels a side of the picture that detects hidden appearances.
const EYE_IMAGE_SIZE: u32 = 256;

/// The parts of a method of virtual objects.
pub(crate) trait VirtualObjectMethod: Clone + Send + Sync + 'static {
    /// Finds points in one reflector.
    type Locator: Locator + 'static;
    /// Data of each reflector that no view changes.
    type Pictures: Send + Sync;

    /// The method.
    const INFO: &'static MethodInfo;

    /// Edges of reflectors longer than this share of their radius are halved.
    fn longest_edge(&self) -> f32 {
        LONGEST_EDGE
    }

    /// Builds the data that does not depend on the view, for paths of up to `order` bounces; `old` is of the same
    /// reflectors.
    fn pictures(&self, meshes: &[ReflectorMesh], order: u32, old: Option<&Self::Pictures>) -> Self::Pictures;

    /// Returns a function that makes the locators of the rays of a view; it returns `None` where nothing can appear by
    /// the rays.
    fn locators<'a>(
        &'a self,
        scene: &'a Scene,
        reflectors: &'a Reflectors<Self>,
        view: &'a View,
    ) -> impl Fn(&Reflector<'_>) -> Option<Self::Locator> + 'a;

    /// The making of appearances.
    fn options(&self) -> Options;

    /// The work that a frame may take.
    fn work_limit(&self) -> WorkLimit;

    /// The finest virtual edges' error and the smallest pieces, both in pixels.
    fn sizes_px(&self) -> [f32; 2];
}

/// The reflectors of a scene as meshes.
pub(crate) struct Reflectors<M: VirtualObjectMethod> {
    /// The mesh of each specular object, in the order of [`Reflector::index`].
    pub(crate) meshes: Arc<Vec<ReflectorMesh>>,
    pub(crate) pictures: M::Pictures,
    /// The hierarchy over reflectors and lenses, if there are lenses.
    tracer: Option<Arc<Tracer>>,
}

impl<M: VirtualObjectMethod> MeshProjection for M {
    type Mirrors = Reflectors<M>;
    type ViewData = PathTree<M::Locator>;
    type Projector<'a> = VirtualObjects<'a, M::Locator>;

    fn info(&self) -> &'static MethodInfo {
        M::INFO
    }

    fn mirrors(
        &self,
        scene: &Scene,
        quality: Quality,
        old: Option<&Reflectors<M>>,
        stages: &mut Stages<'_>,
    ) -> Result<Reflectors<M>, RenderError> {
        let meshes = match old {
            Some(old) => old.meshes.clone(),
            None => {
                let objects = scene.specular_objects();
                let mesh = |index: usize| ReflectorMesh::new(scene, objects[index], self.longest_edge());
                Arc::new(parallel::map_stage(stages.progress, "dividing reflectors", objects.len(), mesh)?)
            }
        };
        stages.lap("reflectors");
        let pictures = self.pictures(&meshes, quality.order, old.map(|old| &old.pictures));
        stages.lap("pictures");
        let tracer = match old {
            Some(old) => old.tracer.clone(),
            None if has_lens(scene) => Some(mirror_tracer(scene, None, stages)?),
            None => None,
        };
        Ok(Reflectors { meshes, pictures, tracer })
    }

    fn view_data(
        &self,
        context: &Context<'_, Self>,
        stages: &mut Stages<'_>,
    ) -> Result<PathTree<M::Locator>, RenderError> {
        let Context { scene, mirrors, view, order, work, without, .. } = *context;
        let make = self.locators(scene, mirrors, view);
        let limits = PathLimits { order, work, without };
        let mut tree = PathTree::build(scene, &mirrors.meshes, view, limits, EYE_IMAGE_SIZE, make, stages.progress)?;
        let tracer = mirrors.tracer.as_ref().filter(|_| context.is_for_picture);
        if let Some(tracer) = tracer {
            let projector = MeshProjection::projector(self, context, &tree);
            let specular = Specular { scene, tracer, surfaces: &projector.surfaces, order };
            let Options { recursion, polish } = projector.options;
            let tolerance_px = match recursion {
                Recursion::VirtualPoints if polish == 0 => COARSE_TOLERANCE_PX,
                _ => TOLERANCE_PX,
            };
            let wrong = wrong_in_lenses(&projector, &specular, view, tolerance_px, stages.progress)?;
            tree.wrong_in_lenses = wrong.blocks;
            tree.left_out.extend(wrong.paths);
        }
        Ok(tree)
    }

    fn wrong_in_lenses<'a>(&self, tree: &'a PathTree<M::Locator>) -> Option<&'a BlockMask> {
        Some(&tree.wrong_in_lenses)
    }

    fn is_complete(&self, data: &PathTree<M::Locator>) -> bool {
        data.left_out.is_empty()
    }

    fn describe(&self, data: &PathTree<M::Locator>, report: &mut Report) {
        report.bytes.insert("maps", data.byte_count());
        if VirtualObjectMethod::work_limit(self).beyond == BeyondWork::Coarse {
            report.add_fallback("paths_left_out", data.left_out.len() as u64);
        }
        report.add_fallback("coarser_maps", data.coarser_maps());
    }

    fn work_limit(&self) -> WorkLimit {
        VirtualObjectMethod::work_limit(self)
    }

    fn mesh_quality(&self, view: &View) -> MeshQuality {
        let [edge_error_px, piece_px] = self.sizes_px();
        MeshQuality::new(view, edge_error_px, piece_px)
    }

    fn projector<'a>(
        &'a self,
        context: &Context<'a, Self>,
        tree: &'a PathTree<M::Locator>,
    ) -> VirtualObjects<'a, M::Locator> {
        let Context { scene, virtual_scene, mirrors, view, .. } = *context;
        VirtualObjects {
            tree,
            meshes: &mirrors.meshes,
            surfaces: virtual_scene.surfaces(scene),
            eye: eye_of(view),
            picture: view.picture_from_world(),
            view: PreciseView::new(view),
            options: self.options(),
        }
    }
}
