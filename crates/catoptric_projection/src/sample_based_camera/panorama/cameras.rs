//! Cameras for all directions about a point: cube ray maps (Popescu, Sacks, Mei 2006, section VI).

use super::cube::{self, FACES};
use crate::find::ray_map::{Specular, ViewField};
use crate::sample_based_camera::cameras::{CameraDemand, Cameras};
use crate::sample_based_camera::fitting::describe;
use crate::sample_based_camera::rays::grid::RayGrid;
use crate::sample_based_camera::rays::path_rays::DensePathRays;
use crate::sample_based_camera::rays::sampler::RaySampler;
use crate::sample_based_camera::settings::{CameraKind, MARGIN_CELLS, MAX_RAYS, SampleBasedCameraSettings};
use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{PreciseView, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use catoptric_engine::method::{Report, Settings, within};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::path::manifold::{MeshTopologies, SpecularSurfaces};
use glam::Vec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The usual work for fitting the cameras of one face. Chosen, not measured.
const FACE_WORK: u64 = 20_000_000;

/// A scene's mirrors and lenses, made ready once for panoramic cameras at any number of places.
pub struct PanoramicMirrors<'a> {
    pub(super) scene: &'a Scene,
    pub(super) tracer: Arc<Tracer>,
    pub(super) topologies: MeshTopologies,
    pub(super) surfaces: SpecularSurfaces<'a>,
}

impl<'a> PanoramicMirrors<'a> {
    /// Prepares the mirrors of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        let tracer = Arc::new(Tracer::build(scene, |object| scene.role_of(object).is_specular()));
        let topologies = MeshTopologies::of(scene);
        let surfaces = SpecularSurfaces::with_topologies(scene, &topologies);
        Self { scene, tracer, topologies, surfaces }
    }

    /// The mirrors of a scene, from a tracer and topologies that are ready already.
    pub(in super::super) fn of(scene: &'a Scene, tracer: Arc<Tracer>, topologies: &MeshTopologies) -> Self {
        let surfaces = SpecularSurfaces::with_topologies(scene, topologies);
        Self { scene, tracer, topologies: topologies.clone(), surfaces }
    }
}

impl std::fmt::Debug for PanoramicMirrors<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("PanoramicMirrors").field("scene", &self.scene.name).finish_non_exhaustive()
    }
}

/// Settings of panoramic cameras.
///
/// Accuracy is counted in pixels of a face, a picture of 90 degrees by 90 degrees. In its middle a pixel is `2 /
/// size_px` radians. Towards its border pixels are smaller: at `(u, v)`, both from -1 to 1, with `r2 = u * u + v * v`,
/// that divided by `sqrt(1 + r2)` across the way to the middle and by `1 + r2` along it. So in a corner they are 0.58
/// and 0.33 times as large. No direction is less accurate than in the middle of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct PanoramaSettings {
    /// Pixels a side of each of the six faces, from 1.
    pub size_px: u32,
    /// A ray every so many pixels, 1 to 64; no more than 2,048 rays a side.
    pub downsampling: u32,
    /// The maximum number of bounces of a path, up to [`MAX_BOUNCES`]; with 0 there is no path at all.
    pub order: u32,
    /// Kind of the leaves.
    pub camera: CameraKind,
    /// Leaves see the points of their rays at most this far from where they belong, in pixels, from 0.01 to the spacing
    /// of the rays.
    pub accuracy_px: f32,
    /// The accuracy for paths of one reflection, whose appearances a solver makes exact soon.
    pub mirror_accuracy_px: f32,
    /// Pinholes: rays are split by a plane unless its sides together have more than this many times the rays, 1 to 2; 2
    /// is the paper's rule.
    pub max_shared: f32,
    /// The least spacing, in pixels, of rays that are traced between these where no camera is accurate; from 0.03.
    pub finest_ray_px: f32,
    /// Steps of the solver that makes appearances exact, 0 to 100; 0 leaves them as the cameras have them.
    pub polish: u32,
    /// Objects (reflectors and lenses) at which paths end, because they show environment maps.
    pub environment_mapped: Vec<u32>,
    /// Objects at which paths may begin, counted from the eye; all if none. Other objects still hide these, and paths
    /// may go on at them.
    pub first: Option<Vec<u32>>,
    /// Work for fitting the cameras of one face where rays have to be traced between these, in units of about 100 ns
    /// of one core.
    pub work: u64,
    /// The box in which cameras are accurate; the scene's if none.
    pub bounds: Option<Aabb>,
}

impl Default for PanoramaSettings {
    /// A ray every third of a degree or so, a bounce, a tenth of a pixel: at most 0.4 milliradians.
    fn default() -> Self {
        let SampleBasedCameraSettings { downsampling, camera, accuracy_px, max_shared, finest_ray_px, polish, .. } =
            Default::default();
        Self {
            size_px: 512,
            downsampling,
            order: 1,
            camera,
            accuracy_px,
            mirror_accuracy_px: accuracy_px,
            max_shared,
            finest_ray_px,
            polish,
            environment_mapped: Vec::new(),
            first: None,
            work: FACE_WORK,
            bounds: None,
        }
    }
}

impl PanoramaSettings {
    fn check(&self, scene: &Scene) -> Result<(), RenderError> {
        let wrong = |problem: String| RenderError::Setting { method: SampleBasedCameraSettings::METHOD, problem };
        within("downsampling", self.downsampling as f32, 1.0, 64.0).map_err(wrong)?;
        within("size_px", self.size_px as f32, 1.0, (MAX_RAYS * self.downsampling) as f32).map_err(wrong)?;
        within("accuracy_px", self.accuracy_px, 0.01, self.downsampling as f32).map_err(wrong)?;
        within("mirror_accuracy_px", self.mirror_accuracy_px, 0.01, self.downsampling as f32).map_err(wrong)?;
        within("max_shared", self.max_shared, 1.0, 2.0).map_err(wrong)?;
        within("finest_ray_px", self.finest_ray_px, 0.03, 1e6).map_err(wrong)?;
        within("polish", self.polish as f32, 0.0, 100.0).map_err(wrong)?;
        within("order", self.order as f32, 0.0, MAX_BOUNCES as f32).map_err(wrong)?;
        if let Some(bounds) = self.bounds
            && !(bounds.min.is_finite() && bounds.max.is_finite() && !bounds.is_empty())
        {
            return Err(wrong(format!("bounds = {bounds:?} is no finite box")));
        }
        let is_specular = |object: u32| (object as usize) < scene.objects.len() && scene.role_of(object).is_specular();
        let mut named = self.environment_mapped.iter().chain(self.first.iter().flatten());
        match named.find(|&&object| !is_specular(object)) {
            Some(object) => Err(wrong(format!("object {object} is neither a reflector nor a lens"))),
            None => Ok(()),
        }
    }

    /// The accuracy of a path's cameras.
    pub(super) fn accuracy_of(&self, path: &SpecularPath) -> f32 {
        match path.bounces[..] {
            [Bounce { kind: BounceKind::Reflect, .. }] => self.mirror_accuracy_px,
            _ => self.accuracy_px,
        }
    }

    pub(super) fn spacing_px(&self) -> f32 {
        self.downsampling as f32
    }

    pub(super) fn margin_px(&self) -> f32 {
        MARGIN_CELLS * self.spacing_px()
    }
}

/// The ray map and cameras of one face.
#[derive(Clone, Debug)]
pub(super) struct PanoramaFace {
    /// Index of one of the six.
    pub(super) number: usize,
    pub(super) grid: RayGrid,
    /// The cameras of each group of the grid.
    pub(super) cameras: Vec<Cameras>,
    /// The group of each path of all faces in this face.
    pub(super) group_of_path: Vec<Option<u32>>,
    /// The indices of refraction before and behind the bounce, for groups whose path has only one.
    pub(super) media: Vec<Option<[f32; 2]>>,
}

/// The indices of refraction before and behind the bounce, for groups whose path has only one.
fn media(grid: &RayGrid, eye: Vec3) -> Vec<Option<[f32; 2]>> {
    let media = grid.groups.iter().map(|group| {
        let ray = group.rays.first().filter(|_| group.path.bounces.len() == 1)?;
        let before = ray.length / ray.first.distance(eye.as_dvec3());
        before.is_finite().then_some([before as f32, ray.medium as f32])
    });
    media.collect()
}

/// The number of each path's group in a face.
pub(super) fn group_of_path(paths: &[SpecularPath], grid: &RayGrid) -> Vec<Option<u32>> {
    let group_of = |path: &SpecularPath| grid.groups.iter().position(|group| group.path == *path);
    paths.iter().map(|path| group_of(path).map(|group| group as u32)).collect()
}

/// Appearances of scene points in mirrors, in any direction from one point: sample-based cameras over the six faces of
/// a cube about it (Popescu, Sacks, Mei 2006, section VI: a panoramic camera, built from a cube ray map).
///
/// They hold no reference to the scene, whose mirrors must not change as long as they are used; objects among the
/// mirrors may move within the scene's box as it was when they were built.
///
/// ```
/// use catoptric::methods::projection::sample_based_camera::{PanoramaSettings, PanoramicCameras, PanoramicMirrors};
/// use catoptric::progress::Silent;
/// use catoptric_scenes::builtin;
/// use glam::Vec3;
///
/// let scene = builtin::load("sphere_room", &[("surface", "analytic")]).unwrap().pose(&Default::default()).unwrap();
/// let mirrors = PanoramicMirrors::new(&scene);
/// let settings = PanoramaSettings { size_px: 128, ..PanoramaSettings::default() };
/// let eye = Vec3::new(-0.4, 1.8, 1.6);
/// let cameras = PanoramicCameras::new(&mirrors, eye, &settings, &Silent).unwrap();
/// let projector = cameras.projector(&mirrors).unwrap();
/// let mut found = Vec::new();
/// projector.project(Vec3::new(1.35, 1.15, 0.75), &mut found);
/// // A ball shows every point once.
/// let [seen] = found[..] else { panic!("{found:?}") };
/// assert_eq!(cameras.paths()[seen.path as usize].names(&scene), "sphere");
/// assert!(((seen.reflection_point - eye).normalize() - seen.direction).length() < 1e-5);
/// assert!((seen.reflection_point.distance(Vec3::new(0.0, 1.3, 0.0)) - 0.8).abs() < 1e-3);
/// ```
#[derive(Clone, Debug)]
pub struct PanoramicCameras {
    pub(super) eye: Vec3,
    pub(super) near: f32,
    /// Objects of the scene.
    pub(super) object_count: usize,
    pub(super) settings: PanoramaSettings,
    pub(super) paths: Vec<SpecularPath>,
    /// The faces in which there is a path.
    pub(super) faces: Vec<PanoramaFace>,
}

impl PanoramicCameras {
    /// Follows rays from `eye` (in scene units, anywhere, inside mirrors too) in all directions and builds cameras over
    /// them, on all cores. Faces without a mirror cost nothing. Where there are no mirrors, or with order 0, there are
    /// no [paths](Self::paths), and points appear nowhere.
    ///
    /// Reflections smaller than the spacing of the rays can be missed.
    ///
    /// # Errors
    /// [`RenderError::Limit`] when the eye is not finite, [`RenderError::Setting`] when a setting is outside its range
    /// or names an object that is neither reflector nor lens; [`RenderError::Cancelled`].
    pub fn new(
        mirrors: &PanoramicMirrors<'_>,
        eye: Vec3,
        settings: &PanoramaSettings,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let scene = mirrors.scene;
        settings.check(scene)?;
        if !eye.is_finite() {
            let problem = format!("panoramic cameras about {eye}, which is not finite");
            return Err(RenderError::Limit { method: SampleBasedCameraSettings::METHOD, problem });
        }
        let mut mapped = vec![false; scene.objects.len()];
        settings.environment_mapped.iter().for_each(|&object| mapped[object as usize] = true);
        let is_first = |object: u32| {
            !mapped[object as usize] && settings.first.as_ref().is_none_or(|first| first.contains(&object))
        };
        let first: Vec<u32> = scene.specular_objects().into_iter().filter(|&object| is_first(object)).collect();
        let margin = settings.margin_px() * 2.0 / settings.size_px as f32;
        let shows = |face: &usize| {
            let mut first = first.iter().map(|&object| &scene.objects[object as usize].bounds);
            settings.order > 0 && first.any(|bounds| cube::shows(*face, margin, eye, bounds))
        };
        let numbers: Vec<usize> = (0..FACES).filter(shows).collect();
        let (near, bounds) = (scene.near(), settings.bounds.unwrap_or(scene.bounds));
        let PanoramicMirrors { tracer, surfaces, .. } = mirrors;
        let specular = Specular { scene, tracer, surfaces, order: settings.order };
        let accuracy_px = settings.accuracy_px.into();
        let PanoramaSettings { camera, max_shared, finest_ray_px, .. } = *settings;
        let demand =
            CameraDemand { camera, accuracy_px, max_shared, finest_ray_px, traced_a_ray: 0, leaves_out: false };
        let demand = (demand, |path: &SpecularPath| (settings.accuracy_of(path), false));
        let seen = |index: usize| -> Result<(RayGrid, Vec<Cameras>), Cancelled> {
            let view = face_view(numbers[index], eye, near, settings);
            let field = ViewField::new(&view, settings.margin_px());
            let sampler = RaySampler::new(&specular, &field, settings.spacing_px(), &mapped);
            let mut grid = RayGrid::new(&sampler, progress)?;
            grid.groups.retain(|group| group.path.bounces.first().is_some_and(|bounce| is_first(bounce.object)));
            let cameras = grid.cameras(&sampler, &PreciseView::new(&view), bounds, demand, settings.work, progress)?;
            Ok((grid, cameras))
        };
        let seen: Vec<(RayGrid, Vec<Cameras>)> =
            parallel::map_collect(numbers.len(), seen).into_iter().collect::<Result<_, _>>()?;
        let paths: BTreeSet<&SpecularPath> = seen.iter().flat_map(|(grid, _)| &grid.groups).map(|g| &g.path).collect();
        let paths: Vec<SpecularPath> = paths.into_iter().cloned().collect();
        let faces = numbers.into_iter().zip(seen).map(|(number, (grid, cameras))| {
            let (group_of_path, media) = (group_of_path(&paths, &grid), media(&grid, eye));
            PanoramaFace { number, grid, cameras, group_of_path, media }
        });
        let faces = faces.collect();
        let (object_count, settings) = (scene.objects.len(), settings.clone());
        Ok(Self { eye, near, object_count, settings, paths, faces })
    }

    /// The point from which is seen.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The paths that occur in any direction, sorted; a path's parents are among them.
    pub fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    /// Counts as in the method's own report: `ray_map_rays`, `rays_traced`, `leaves`, `ray_lists`,
    /// `rays_in_lists`, `pieces`, and `faces` with mirrors; `cameras` in bytes.
    pub fn report(&self) -> Report {
        let mut report = Report::default();
        report.counts.insert("faces", self.faces.len() as u64);
        report.counts.insert("rays_traced", self.faces.iter().map(|face| face.grid.traced).sum());
        describe(self.faces.iter().map(|face| (&face.grid, &face.cameras[..])), &mut report);
        report
    }

    /// These cameras without the data that only polish and the drawing of leaves need: most of the rays' memory.
    pub(in super::super) fn compact(mut self) -> Self {
        for face in &mut self.faces {
            face.grid.groups.iter_mut().for_each(DensePathRays::forget_rays);
            face.cameras.iter_mut().for_each(Cameras::forget_rays);
        }
        self
    }

    /// Bytes of the rays and of the cameras over them.
    pub fn byte_count(&self) -> u64 {
        let groups = || self.faces.iter().flat_map(|face| &face.grid.groups);
        let rays: usize = groups().map(DensePathRays::byte_count).sum();
        let cameras = self.faces.iter().flat_map(|face| &face.cameras).map(|cameras| cameras.counts().bytes);
        rays as u64 + cameras.sum::<u64>()
    }

    pub(super) fn view(&self, face: usize) -> View {
        face_view(face, self.eye, self.near, &self.settings)
    }
}

fn face_view(face: usize, eye: Vec3, near: f32, settings: &PanoramaSettings) -> View {
    cube::view(face, eye, settings.size_px, near)
}
