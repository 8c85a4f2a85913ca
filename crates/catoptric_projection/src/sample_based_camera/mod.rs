//! Sample-based cameras: trees of small cameras, fitted to a dense map of reflected rays, project scene points.
//!
//! See this folder's `README.md`.

mod cameras;
mod hybrid;
pub(crate) mod layout;
mod leaves;
mod limits;
pub(crate) mod morph;
pub(crate) mod panorama;
mod project;
pub(crate) mod rays;
mod settings;

use hybrid::MappedReflectors;
pub use morph::nodes_around;
pub use panorama::{PanoramaSettings, PanoramicCameras, PanoramicMirrors, PanoramicProjection, PanoramicProjector};
pub use rays::visible_pieces::{PiecesOfPixels, visible_pieces};
pub use settings::{Ambiguous, Blend, CameraKind, Mode, Preset, SampleBasedCameraSettings};

use crate::draw::MapsInView;
use crate::draw::overlays::ShownPixels;
use crate::draw::prepared::{Context, MeshProjection, ProjectionMethod, Stages, mirror_tracer};
use crate::draw::virtual_mesh::{Ends, MeshQuality};
use crate::draw::work_limit::{BeyondWork, WorkLimit};
use crate::find::lens_check::{TOLERANCE_PX, wrong_in_lenses};
use crate::find::ray_map::{Specular, ViewField, eye_of};
use cameras::{CameraBuilder, CameraDemand, Cameras, Counts};
use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{PreciseView, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath};
use catoptric_engine::method::{About, Family, MethodInfo, Quality, Report, Settings};
use catoptric_engine::raster::BlockMask;
use morph::{Morphing, NodesWork};
use project::CameraProjector;
use rays::grid::RayGrid;
use rays::path_rays::DensePathRays;
use rays::sampler::RaySampler;
use std::collections::HashSet;
use std::sync::Arc;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "sample_based_camera",
    family: Family::Projection,
    summary: "trees of small cameras, fitted to a dense map of reflected rays within an accuracy, \
        show where vertices appear",
    paper: "Popescu, Sacks, Mei 2006, Sample-based cameras for fast accurate reflections",
    assumptions: "reflections smaller than the spacing of the ray map can be missed",
    about: About {
        readme: include_str!("README.md"),
        draws: "every object as a virtual mesh in each mirror or lens that shows it; what takes too much work by tiles",
        costs: "a dense map of rays and its cameras for every view (mode=morph: kept at the nodes of a grid, which \
            can be baked); around caustics first pictures take seconds",
        cannot: "reflections smaller than the spacing of the map, and narrow parts of large triangles in corners of \
            flat mirrors, can be missed",
        useful: &["preset", "accuracy_px", "mode", "downsampling"],
    },
    cpu: true,
    gpu: true,
    bake: Some(|table, scene, quality| {
        Ok(Box::new(NodesWork::new(SampleBasedCameraSettings::from_table(table)?, scene, quality)?))
    }),
    settings: SampleBasedCameraSettings::describe,
    effective: SampleBasedCameraSettings::effective,
    limits: &limits::LIMITS,
    create: |table| {
        let settings = SampleBasedCameraSettings::from_table(table)?;
        Ok(match settings.mode {
            Mode::Runtime => Box::new(ProjectionMethod(SampleBasedCamera(settings))),
            Mode::Morph => Box::new(ProjectionMethod(Morphing::new(settings)?)),
        })
    },
};

/// Cells of the ray map around the picture: what appears there belongs to triangles that reach into it. Chosen, not
/// measured.
const MARGIN_CELLS: f32 = 4.0;

/// Fitting cameras takes about so much work for each ray of the map. Measured on meshes of files.
const WORK_A_RAY: u64 = 30;

/// And so much for each ray that is traced between them, to fit cameras where they are too few.
const WORK_A_TRACED_RAY: u64 = 17;

/// The method with its settings.
#[derive(Clone)]
struct SampleBasedCamera(SampleBasedCameraSettings);

/// The cameras of a view.
struct ViewCameras {
    /// The scene's box when they were built.
    bounds: Aabb,
    grid: RayGrid,
    /// The cameras of each group of the grid.
    cameras: Vec<Cameras>,
    /// Paths that have none, because there is too much to do for them.
    left_out: Vec<SpecularPath>,
    /// Blocks of the picture where appearances in lenses that are seen directly are wrong.
    wrong_in_lenses: BlockMask,
    environment: MappedReflectors,
}

impl RayGrid {
    /// Drops the groups of paths that are not wanted, and those that there is not enough work for, those of long paths
    /// first, and returns their paths.
    fn drop_expensive(&mut self, work: u64, without: &PathBeginnings) -> Vec<SpecularPath> {
        let mut by_length: Vec<usize> = (0..self.groups.len()).collect();
        by_length.sort_by_key(|&group| self.groups[group].path.bounces.len());
        let (mut remaining, mut is_kept) = (work, vec![false; self.groups.len()]);
        for group in by_length {
            if without.hold(&self.groups[group].path) {
                continue;
            }
            let needed = WORK_A_RAY * self.groups[group].rays.len() as u64;
            if needed > remaining {
                // Longer ones are not drawn without it.
                break;
            }
            remaining -= needed;
            is_kept[group] = true;
        }
        let mut kept = is_kept.into_iter();
        let groups = std::mem::take(&mut self.groups);
        let (kept, dropped): (Vec<_>, Vec<_>) = groups.into_iter().partition(|_| kept.next().unwrap_or_default());
        self.groups = kept;
        dropped.into_iter().map(|group| group.path).collect()
    }

    /// Drops the groups more of whose blocks have no accurate camera than have one, and returns their paths.
    fn drop_inaccurate(&mut self, cameras: &mut Vec<Cameras>) -> Vec<SpecularPath> {
        let is_accurate = |cameras: &Cameras| {
            let counts = cameras.counts();
            counts.unrefined_blocks <= counts.leaves
        };
        let groups = std::mem::take(&mut self.groups).into_iter().zip(std::mem::take(cameras));
        let (kept, dropped): (Vec<_>, Vec<_>) = groups.partition(|(_, cameras)| is_accurate(cameras));
        (self.groups, *cameras) = kept.into_iter().unzip();
        dropped.into_iter().map(|(group, _)| group.path).collect()
    }

    /// The cameras of each group, as accurate as its path's are to be, or none where they are left out; rays that they
    /// need are added to these, with the work that is left then.
    fn cameras(
        &mut self,
        sampler: &RaySampler<'_>,
        view: &PreciseView,
        bounds: Aabb,
        (demand, of_path): (CameraDemand, impl Fn(&SpecularPath) -> (f32, bool) + Sync),
        work: u64,
        progress: &dyn Progress,
    ) -> Result<Vec<Cameras>, Cancelled> {
        let count: u64 = self.groups.iter().map(|group| group.rays.len() as u64).sum();
        let traced = work.saturating_sub(WORK_A_RAY * count) / WORK_A_TRACED_RAY;
        let demand = CameraDemand { traced_a_ray: (traced / count.max(1)).max(1), ..demand };
        let built = parallel::map_stage(progress, "fitting cameras", self.groups.len(), |group| {
            let group = &self.groups[group];
            let (accuracy_px, leaves_out) = of_path(&group.path);
            let demand = CameraDemand { accuracy_px: accuracy_px.into(), leaves_out, ..demand };
            CameraBuilder { group, view, bounds, sampler, demand }.cameras()
        })?;
        let with_rays = built.into_iter().zip(&mut self.groups);
        let cameras = with_rays.map(|((mut cameras, added), group)| {
            self.traced += added.traced;
            if !added.rays.is_empty() {
                cameras.renumber(&group.add(added.rays));
            }
            cameras
        });
        Ok(cameras.collect())
    }
}

/// Adds the counts and bytes of some grids of rays with their cameras.
fn describe<'a>(grids: impl Iterator<Item = (&'a RayGrid, &'a [Cameras])> + Clone, report: &mut Report) {
    let counts: Vec<Counts> = grids.clone().flat_map(|(_, cameras)| cameras).map(Cameras::counts).collect();
    let groups = || grids.clone().flat_map(|(grid, _)| &grid.groups);
    let sum = |count: fn(&Counts) -> u64| counts.iter().map(count).sum::<u64>();
    report.counts.insert("ray_map_rays", groups().map(|group| group.count() as u64).sum());
    report.counts.insert("leaves", sum(|counts| counts.leaves));
    report.counts.insert("ray_lists", sum(|counts| counts.ray_lists));
    report.counts.insert("rays_in_lists", sum(|counts| counts.rays_in_lists));
    let left = [
        ("unrefined_blocks", sum(|counts| counts.unrefined_blocks)),
        ("unsplit_lists", sum(|counts| counts.unsplit_lists)),
    ];
    report.fallbacks.extend(left.into_iter().filter(|(_, count)| *count > 0));
    report.counts.insert("pieces", groups().map(|group| u64::from(group.piece_count)).sum());
    report.bytes.insert("cameras", sum(|counts| counts.bytes));
}

fn margin_px(settings: &SampleBasedCameraSettings) -> f32 {
    MARGIN_CELLS * settings.downsampling as f32
}

impl MeshProjection for SampleBasedCamera {
    type Mirrors = Arc<Tracer>;
    type ViewData = ViewCameras;
    type Projector<'a> = CameraProjector<'a>;

    const INFO: &'static MethodInfo = &INFO;
    const OVERLAYS: &'static [OverlayKind] = &[OverlayKind::Paths, OverlayKind::VirtualTriangles, OverlayKind::Leaves];

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
        Err(RenderError::Limit { method: INFO.id, problem })
    }

    fn fits(&self, context: &Context<'_, Self>, data: &ViewCameras) -> Result<bool, RenderError> {
        let bounds = context.scene.bounds;
        let field = ViewField::new(context.view, margin_px(&self.0));
        // Rays are tested as far as the scene reached when the cameras were built.
        Ok(data.environment.fits(&self.0, context.scene, &field)? && data.bounds.union(bounds) == data.bounds)
    }

    fn view_data(&self, context: &Context<'_, Self>, stages: &mut Stages<'_>) -> Result<ViewCameras, RenderError> {
        let Context { scene, virtual_scene, mirrors, view, order, work, .. } = *context;
        let field = ViewField::new(view, margin_px(&self.0));
        let environment = MappedReflectors::new(&self.0, scene, &field)?;
        let surfaces = &virtual_scene.surfaces(scene);
        let specular = Specular { scene, tracer: mirrors, surfaces, order };
        let sampler = RaySampler::new(&specular, &field, self.0.downsampling as f32, &environment.mapped);
        let mut grid = RayGrid::new(&sampler, stages.progress)?;
        stages.lap("ray_map");
        let SampleBasedCameraSettings { camera, accuracy_px, max_shared, finest_ray_px, .. } = self.0;
        let leaves_out = context.is_for_picture && self.0.beyond_work == BeyondWork::Tiles;
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
        data.environment.complete(&self.0, (context.scene, context.order), stages)
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
        self.0.work_limit()
    }

    fn mesh_quality(&self, view: &View) -> MeshQuality {
        MeshQuality::new(view, self.0.edge_error_px, self.0.piece_px)
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
        Ok(Some(leaves::overlay(&projector, self.0.camera, (shown, drawn), progress)?))
    }

    fn projector<'a>(&'a self, context: &Context<'a, Self>, data: &'a ViewCameras) -> CameraProjector<'a> {
        let Context { scene, virtual_scene, mirrors, view, .. } = *context;
        let sizes = scene.objects.iter().map(|object| f64::from(object.bounds.diagonal()));
        let (picture, spacing_px) = ([view.width, view.height], data.grid.spacing_px);
        let holes = |group: &DensePathRays, cameras: &Cameras| {
            group.blocks_without(cameras.left_out(), picture, (spacing_px, margin_px(&self.0)))
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
            field: ViewField::new(view, margin_px(&self.0)),
            scene,
            tracer: mirrors.clone(),
            surfaces: virtual_scene.surfaces(scene),
            margin_px: margin_px(&self.0).into(),
            accuracies_px: vec![self.0.accuracy_px; data.grid.groups.len()],
            polish: self.0.polish,
            sizes: sizes.collect(),
        }
    }
}
