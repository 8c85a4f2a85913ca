//! Perturbation of specular paths: appearances from a sparse set of traced rays, expanded to second order.
//!
//! See this folder's `README.md`.

mod far_objects;
mod limits;
mod project;
mod settings;

pub use settings::{Candidates, ExpansionOrder, PathPerturbationSettings, Preset};

use crate::draw::MapsInView;
use crate::draw::far_maps::FarMaps;
use crate::draw::prepared::{Context, MeshProjection, ProjectionMethod};
use crate::draw::stages::{Stages, mirror_tracer};
use crate::draw::virtual_mesh::{Ends, MeshQuality};
use crate::draw::work_limit::WorkLimit;
use crate::find::lens_check::{COARSE_TOLERANCE_PX, TOLERANCE_PX, WrongInLenses, wrong_in_lenses};
use crate::find::ray_map::{PathRays, RayMap, Sampling, Specular, ViewField, eye_of};
use catoptric_core::math::Aabb;
use catoptric_core::scene::{PreciseView, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::method::{About, Family, MethodInfo, Quality, Report, Settings};
use catoptric_engine::raster::BlockMask;
use far_objects::{FarBounds, FarObjects};
use glam::Vec3;
use project::{Perturber, rule};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "path_perturbation",
    family: Family::Projection,
    summary: "a sparse set of traced specular paths, perturbed to second order, and polished, shows \
        where vertices appear",
    paper: "Chen, Arvo 2000, Perturbation methods for interactive specular reflections",
    assumptions: "reflectors and lenses are smooth; reflections smaller than the finest sample spacing can be missed",
    about: About {
        readme: include_str!("README.md"),
        draws: "every object as a virtual mesh in each mirror or lens that shows it; what takes too much work by tiles",
        costs: "a map of traced rays and the virtual meshes for every view: a first picture can take as long as the \
            reference with 16 samples",
        cannot: "reflections smaller than finest_px can be missed, and appearances can end a little before a fold",
        useful: &["spacing_px", "polish", "expansion", "accuracy_px"],
    },
    cpu: true,
    gpu: true,
    bake: None,
    settings: PathPerturbationSettings::describe,
    effective: PathPerturbationSettings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new(ProjectionMethod(PathPerturbation(PathPerturbationSettings::from_table(table)?)))),
};

/// The least edge error and size of pieces without polish. Chosen, not measured.
const COARSE_PX: (f32, f32) = (1.0, 3.0);

/// The method with its settings.
#[derive(Clone)]
struct PathPerturbation(PathPerturbationSettings);

/// The rays of a view, and the objects that are far from its reflectors.
struct ViewRays {
    map: RayMap,
    wrong: WrongInLenses,
    /// `None` until they are captured, and if no maps are wanted.
    far: Option<FarInView>,
    /// Maps of an earlier view or moment.
    old: Option<FarMaps>,
}

/// The maps of far objects in a view.
struct FarInView {
    maps: FarMaps,
    /// Objects that are far, but projected all the same.
    kept: u64,
    reflectors_left: u64,
}

/// Appearances just outside the picture belong to triangles that reach into it.
fn margin_px(settings: &PathPerturbationSettings) -> f32 {
    2.0 * settings.spacing_px
}

/// A box a little larger than the scene's.
fn around(bounds: &Aabb) -> Aabb {
    let margin = Vec3::splat(bounds.diagonal() * 0.01);
    Aabb { min: bounds.min - margin, max: bounds.max + margin }
}

impl MeshProjection for PathPerturbation {
    type Mirrors = Arc<Tracer>;
    type ViewData = ViewRays;
    type Projector<'a> = Perturber<'a>;

    fn info(&self) -> &'static MethodInfo {
        &INFO
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

    fn view_data(&self, context: &Context<'_, Self>, stages: &mut Stages<'_>) -> Result<ViewRays, RenderError> {
        let Self(settings) = self;
        let sampling = Sampling {
            spacing_px: settings.spacing_px,
            finest_px: settings.finest_px,
            accuracy_px: settings.accuracy_px,
            max_cells: settings.max_samples as usize,
        };
        let Context { scene, virtual_scene, mirrors, view, order, .. } = *context;
        let surfaces = &virtual_scene.surfaces(scene);
        let specular = Specular { scene, tracer: mirrors, surfaces, order };
        let field = ViewField::new(view, margin_px(settings));
        let map = RayMap::build(&specular, &field, &sampling, &around(&scene.bounds), rule(settings), stages.progress)?;
        stages.report.counts.insert("rays_traced", map.rays_traced);
        let mut data = ViewRays { map, wrong: WrongInLenses::default(), far: None, old: None };
        if context.is_for_picture {
            let tolerance_px = if settings.polish == 0 { COARSE_TOLERANCE_PX } else { TOLERANCE_PX };
            let projector = self.projector(context, &data);
            data.wrong = wrong_in_lenses(&projector, &specular, view, tolerance_px, stages.progress)?;
        }
        Ok(data)
    }

    /// Finds the far objects and captures their maps.
    fn complete(
        &self,
        context: &Context<'_, Self>,
        data: &mut ViewRays,
        stages: &mut Stages<'_>,
    ) -> Result<(), RenderError> {
        let PathPerturbationSettings { far_px, far_size, .. } = self.0;
        if far_px <= 0.0 || data.far.is_some() {
            return Ok(());
        }
        let scene = context.scene;
        let texel = FRAC_PI_2 / f64::from(FarMaps::affordable_size(scene, far_size));
        let FarObjects { of, kept, reflectors_left } =
            FarBounds { error_px: far_px.into(), texel }.far_objects(scene, &data.map);
        let maps = FarMaps::capture(scene, &of, far_size, data.old.take(), stages.progress)?;
        stages.report.counts.insert("captured_faces", maps.captured_faces());
        data.far = Some(FarInView { maps, kept, reflectors_left });
        stages.lap("capture");
        Ok(())
    }

    fn forget_objects(&self, data: &mut ViewRays) {
        if let Some(far) = data.far.take() {
            data.old = Some(far.maps);
        }
    }

    fn take_over(&self, data: &mut ViewRays, old: ViewRays) {
        data.old = old.far.map(|far| far.maps).or(old.old);
    }

    fn maps<'a>(&self, data: &'a ViewRays) -> MapsInView<'a> {
        MapsInView { whole: None, far: data.far.as_ref().map(|far| &far.maps) }
    }

    fn describe(&self, ViewRays { map, far, .. }: &ViewRays, report: &mut Report) {
        if let Some(FarInView { maps, kept, reflectors_left }) = far {
            report.counts.entry("captured_faces").or_insert(0);
            report.counts.insert("far_objects_projected", *kept);
            maps.describe(report);
            report.add_fallback("far_maps_left_out", *reflectors_left);
        }
        report.counts.entry("rays_traced").or_insert(0);
        report.counts.insert("sample_rays", map.samples as u64);
        report.bytes.insert("ray_map", map.byte_count());
        report.add_fallback("samples_left_coarse", map.left_coarse);
    }

    fn wrong_in_lenses<'a>(&self, data: &'a ViewRays) -> Option<&'a BlockMask> {
        Some(&data.wrong.blocks)
    }

    fn work_limit(&self) -> WorkLimit {
        self.0.work_limit()
    }

    fn mesh_quality(&self, view: &View) -> MeshQuality {
        // Expansions of neighbouring points differ by more than the finest pieces.
        let (edge_error_px, piece_px) = if self.0.polish == 0 { COARSE_PX } else { (0.0, 0.0) };
        let (edge_error_px, piece_px) = (self.0.edge_error_px.max(edge_error_px), self.0.piece_px.max(piece_px));
        // Expansions that lead far do not predict each other.
        MeshQuality { is_plain: self.0.draws_any_reach(), ..MeshQuality::new(view, edge_error_px, piece_px) }
    }

    fn projector<'a>(&'a self, context: &Context<'a, Self>, data: &'a ViewRays) -> Perturber<'a> {
        let map = &data.map;
        let Context { scene, virtual_scene, view, .. } = *context;
        let sizes = scene.objects.iter().map(|object| f64::from(object.bounds.diagonal()));
        let paths: Vec<SpecularPath> = map.groups.iter().map(|group| group.path.clone()).collect();
        let ends: Vec<Ends> = paths.iter().map(|path| virtual_scene.ends_on(path, context.ends)).collect();
        let holes = |(group, ends): (&PathRays, &Ends)| match ends {
            Ends::LeftOut => map.rough_blocks(group, margin_px(&self.0), [view.width, view.height]),
            Ends::Followed => BlockMask::default(),
        };
        Perturber {
            map,
            left_out: &data.wrong.paths,
            surfaces: virtual_scene.surfaces(scene),
            holes: map.groups.iter().zip(&ends).map(holes).collect(),
            paths,
            ends,
            eye: eye_of(view),
            view: PreciseView::new(view),
            settings: &self.0,
            margin_px: margin_px(&self.0).into(),
            sizes: sizes.collect(),
        }
    }
}
