//! Cameras at the eye, built for every view.

use super::cameras::{CameraDemand, Cameras};
use super::fitting::describe;
use super::hybrid::MappedReflectors;
use super::leaves;
use super::project::CameraProjector;
use super::rays::grid::RayGrid;
use super::rays::path_rays::DensePathRays;
use super::rays::sampler::RaySampler;
use super::settings::{SampleBasedCameraSettings, margin_px};
use crate::draw::MapsInView;
use crate::draw::overlays::ShownPixels;
use crate::draw::prepared::{Context, MeshProjection};
use crate::draw::stages::{Stages, mirror_tracer};
use crate::draw::virtual_mesh::{Ends, MeshQuality};
use crate::draw::work_limit::{BeyondWork, WorkLimit};
use crate::find::lens_check::{TOLERANCE_PX, wrong_in_lenses};
use crate::find::ray_map::{Specular, ViewField, eye_of};
use catoptric_core::math::Aabb;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{PreciseView, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::method::{MethodInfo, Quality, Report};
use catoptric_engine::raster::BlockMask;
use std::collections::HashSet;
use std::sync::Arc;

/// The method with its settings.
#[derive(Clone)]
pub(super) struct SampleBasedCamera {
    pub(super) info: &'static MethodInfo,
    pub(super) settings: SampleBasedCameraSettings,
}

/// The cameras of a view.
pub(super) struct ViewCameras {
    /// The scene's box when they were built.
    bounds: Aabb,
    pub(super) grid: RayGrid,
    /// The cameras of each group of the grid.
    cameras: Vec<Cameras>,
    /// Paths that have none, because there is too much to do for them.
    left_out: Vec<SpecularPath>,
    /// Blocks of the picture where appearances in lenses that are seen directly are wrong.
    wrong_in_lenses: BlockMask,
    environment: MappedReflectors,
}

impl MeshProjection for SampleBasedCamera {
    type Mirrors = Arc<Tracer>;
    type ViewData = ViewCameras;
    type Projector<'a> = CameraProjector<'a>;

    const OVERLAYS: &'static [OverlayKind] = &[OverlayKind::Paths, OverlayKind::VirtualTriangles, OverlayKind::Leaves];

    fn info(&self) -> &'static MethodInfo {
        self.info
    }

    fn mirrors(
        &self,
        scene: &Scene,
        _: Quality,
        old: Option<&Arc<Tracer>>,
        stages: &mut Stages<'_>,
    ) -> Result<Arc<Tracer>, RenderError> {
        mirror_tracer(scene, old, stages)
    }

    fn take_bake(&self, _: &mut Arc<Tracer>, _: &Scene, _: Quality, _: Arc<dyn Baked>) -> Result<(), RenderError> {
        let problem = "mode = \"runtime\" uses no baked files: set mode=morph, or leave them out".into();
        Err(RenderError::Limit { method: self.info.id, problem })
    }

    fn fits(&self, context: &Context<'_, Self>, data: &ViewCameras) -> Result<bool, RenderError> {
        let bounds = context.scene.bounds;
        let field = ViewField::new(context.view, margin_px(&self.settings));
        // Rays are tested as far as the scene reached when the cameras were built.
        Ok(data.environment.fits(&self.settings, context.scene, &field)? && data.bounds.union(bounds) == data.bounds)
    }

    fn view_data(&self, context: &Context<'_, Self>, stages: &mut Stages<'_>) -> Result<ViewCameras, RenderError> {
        let Context { scene, virtual_scene, mirrors, view, order, work, .. } = *context;
        let field = ViewField::new(view, margin_px(&self.settings));
        let environment = MappedReflectors::new(&self.settings, scene, &field)?;
        let surfaces = &virtual_scene.surfaces(scene);
        let specular = Specular { scene, tracer: mirrors, surfaces, order };
        let sampler = RaySampler::new(&specular, &field, self.settings.downsampling as f32, &environment.mapped);
        let mut grid = RayGrid::new(&sampler, stages.progress)?;
        stages.lap("ray_map");
        let SampleBasedCameraSettings { camera, accuracy_px, max_shared, finest_ray_px, .. } = self.settings;
        let leaves_out = context.is_for_picture && self.settings.beyond_work == BeyondWork::Tiles;
        let (accuracy, traced_a_ray) = (f64::from(accuracy_px), 0);
        let demand =
            CameraDemand { camera, accuracy_px: accuracy, max_shared, finest_ray_px, traced_a_ray, leaves_out };
        let in_part = |path: &SpecularPath| virtual_scene.ends_on(path, context.ends) == Ends::LeftOut;
        let demand = (demand, |path: &SpecularPath| (accuracy_px, in_part(path)));
        let bounds = scene.bounds;
        let mut left_out = if leaves_out { grid.drop_expensive(work, context.without) } else { Vec::new() };
        let mut cameras = grid.cameras(&sampler, &PreciseView::new(view), bounds, demand, work, stages.progress)?;
        if leaves_out {
            left_out.extend(grid.drop_inaccurate(&mut cameras));
        }
        stages.report.counts.insert("rays_traced", grid.traced);
        let mut data =
            ViewCameras { bounds, grid, cameras, left_out, wrong_in_lenses: BlockMask::default(), environment };
        if context.is_for_picture {
            let tolerance_px = TOLERANCE_PX.max(2.0 * accuracy_px);
            let projector = self.projector(context, &data);
            let wrong = wrong_in_lenses(&projector, &specular, view, tolerance_px, stages.progress)?;
            data.wrong_in_lenses = wrong.blocks;
            data.left_out.extend(wrong.paths);
        }
        Ok(data)
    }

    fn is_complete(&self, data: &ViewCameras) -> bool {
        data.left_out.is_empty() && data.cameras.iter().all(|cameras| cameras.left_out().is_empty())
    }

    /// Captures the environment maps.
    fn complete(
        &self,
        context: &Context<'_, Self>,
        data: &mut ViewCameras,
        stages: &mut Stages<'_>,
    ) -> Result<(), RenderError> {
        data.environment.complete(&self.settings, (context.scene, context.order), stages)
    }

    fn forget_objects(&self, data: &mut ViewCameras) {
        data.environment.forget();
    }

    fn describe(&self, data: &ViewCameras, report: &mut Report) {
        report.counts.entry("rays_traced").or_insert(0);
        describe(std::iter::once((&data.grid, &data.cameras[..])), report);
        data.environment.describe(report);
    }

    fn maps<'a>(&self, data: &'a ViewCameras) -> MapsInView<'a> {
        data.environment.in_view()
    }

    fn wrong_in_lenses<'a>(&self, data: &'a ViewCameras) -> Option<&'a BlockMask> {
        Some(&data.wrong_in_lenses)
    }

    fn work_limit(&self) -> WorkLimit {
        self.settings.work_limit()
    }

    fn mesh_quality(&self, view: &View) -> MeshQuality {
        MeshQuality::new(view, self.settings.edge_error_px, self.settings.piece_px)
    }

    fn own_overlay(
        &self,
        kind: OverlayKind,
        context: &Context<'_, Self>,
        data: &ViewCameras,
        (shown, drawn): (&ShownPixels, &HashSet<SpecularPath>),
        progress: &dyn Progress,
    ) -> Result<Option<Overlay>, RenderError> {
        if kind != OverlayKind::Leaves {
            return Ok(None);
        }
        let projector = self.projector(context, data);
        Ok(Some(leaves::overlay(&projector, self.settings.camera, (shown, drawn), progress)?))
    }

    fn projector<'a>(&'a self, context: &Context<'a, Self>, data: &'a ViewCameras) -> CameraProjector<'a> {
        let Context { scene, virtual_scene, mirrors, view, .. } = *context;
        let sizes = scene.objects.iter().map(|object| f64::from(object.bounds.diagonal()));
        let (picture, spacing_px) = ([view.width, view.height], data.grid.spacing_px);
        let holes = |group: &DensePathRays, cameras: &Cameras| {
            group.blocks_without(cameras.left_out(), picture, (spacing_px, margin_px(&self.settings)))
        };
        let groups = data.grid.groups.iter();
        CameraProjector {
            grid: &data.grid,
            cameras: &data.cameras,
            left_out: &data.left_out,
            holes: match context.ends {
                Ends::LeftOut => groups.zip(&data.cameras).map(|(group, cameras)| holes(group, cameras)).collect(),
                Ends::Followed => Vec::new(),
            },
            paths: data.grid.groups.iter().map(|group| group.path.clone()).collect(),
            eye: eye_of(view),
            view: PreciseView::new(view),
            field: ViewField::new(view, margin_px(&self.settings)),
            scene,
            tracer: mirrors.clone(),
            surfaces: virtual_scene.surfaces(scene),
            margin_px: margin_px(&self.settings).into(),
            accuracies_px: vec![self.settings.accuracy_px; data.grid.groups.len()],
            polish: self.settings.polish,
            sizes: sizes.collect(),
        }
    }
}
