//! Every way to draw reflections, behind one interface, in one table: [`all`].

pub mod bake;
pub mod lookup;
pub mod projection;
pub mod reference;
mod settings;

pub use settings::{SettingInfo, Settings};
pub(crate) use settings::{from_table_with_presets, within};

use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projection::finder::PathSearch;
use crate::methods::projection::{ProjectedPaths, VertexProjector};
use crate::progress::Progress;
use crate::raster::RasterReport;
use crate::scene::{Scene, View};
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// How a method finds reflections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The ray-traced truth.
    Reference,
    /// Scene points are projected to where they appear; moved geometry is drawn.
    Projection,
    /// Reflected rays fetch radiance.
    Lookup,
}

impl Family {
    /// The family's name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Projection => "projection",
            Self::Lookup => "lookup",
        }
    }
}

/// What a method is and can do.
#[derive(Debug)]
pub struct MethodInfo {
    /// The name in the program: that of the method's folder.
    pub id: &'static str,
    /// Which half of the problem it solves.
    pub family: Family,
    /// One line for tables.
    pub summary: &'static str,
    /// Author, year and title of the source.
    pub paper: &'static str,
    /// What must hold for its pictures to be right.
    pub assumptions: &'static str,
    /// Runs on the CPU.
    pub cpu: bool,
    /// Runs on the GPU.
    pub gpu: bool,
    /// What it precomputes for long, if anything.
    pub bake: Option<bake::MakeBakeWork>,
    /// Its settings with their defaults.
    pub settings: fn() -> Vec<SettingInfo>,
    /// All settings with the values that a table of some of them leads to, presets included.
    pub in_force: fn(&toml::Table) -> Result<toml::Table, RenderError>,
    /// Makes the method from a table of settings; unknown names and values that are not allowed are errors.
    pub create: fn(&toml::Table) -> Result<Box<dyn ReflectionMethod>, RenderError>,
}

/// How well a picture is to be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Antialiasing samples a pixel, at least 1.
    pub samples: u32,
    /// Highest number of specular events on a path; what lies beyond is black.
    pub order: u32,
}

/// One picture to be drawn.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The scene; the same that the method was prepared for.
    pub scene: &'a Scene,
    /// What is to be seen.
    pub view: &'a View,
    /// How well.
    pub quality: Quality,
    /// Who is told how far it has come.
    pub progress: &'a dyn Progress,
}

/// What a method has to say about its work.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Time of each stage in milliseconds, in order.
    pub stages_ms: Vec<(&'static str, f64)>,
    /// Counted things: rays, triangles, vertices...
    pub counts: BTreeMap<&'static str, u64>,
    /// How often something could not be done and what was drawn instead.
    pub fallbacks: BTreeMap<&'static str, u64>,
    /// Memory of the method's own tables.
    pub bytes: BTreeMap<&'static str, u64>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl Report {
    /// Takes over what the rasteriser says.
    pub fn add_raster(&mut self, raster: &RasterReport) {
        self.stages_ms.push(("raster_setup", raster.setup_ms));
        self.stages_ms.push(("raster_and_shade", raster.tiles_ms));
        self.counts.insert("triangles_drawn", raster.triangles);
        self.counts.insert("triangles_clipped", raster.clipped);
        self.counts.insert("fragments", raster.fragments);
    }
}

/// A way to draw reflections, with its settings.
pub trait ReflectionMethod: Send {
    /// What the method is.
    fn info(&self) -> &'static MethodInfo;

    /// Builds what depends on the scene alone, not on the view. Must be called before [`Self::render`], and again
    /// whenever the scene or the quality changes.
    fn prepare(&mut self, scene: &Scene, quality: Quality, progress: &dyn Progress) -> Result<Report, RenderError>;

    /// Takes what was precomputed for the scene and the settings ([`MethodInfo::bake`]), in place of what [`Self::prepare`] would
    /// do in its stead. Must be called before that.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where the method precomputes nothing.
    fn take_bake(&mut self, baked: Arc<dyn bake::Baked>) -> Result<(), RenderError> {
        drop(baked);
        Err(RenderError::Limit { method: self.info().id, problem: "it uses no baked files".into() })
    }

    /// Builds what depends on the view too and not on what moves among the mirrors, as [`Self::render`] does first where
    /// it is missing, and says what that took. Nothing for methods that keep nothing of the kind.
    ///
    /// # Errors
    /// As [`Self::render`].
    fn prepare_view(&mut self, job: &Job<'_>) -> Result<Report, RenderError> {
        let _ = job;
        Ok(Report::default())
    }

    /// Draws one picture into `target`, which has the view's size.
    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError>;

    /// What says where scene points appear in this view; none for methods that do not project points.
    ///
    /// # Errors
    /// As [`Self::render`].
    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        let _ = job;
        Ok(None)
    }

    /// What finds the paths of one to `job.quality.order` bounces on these objects from an eye (the view's, perhaps
    /// with more digits) to scene points; none for methods that do not project points.
    ///
    /// Unless a method knows better, the appearances that its projector finds in the view are completed to paths.
    ///
    /// # Errors
    /// As [`Self::render`].
    fn path_search<'a>(
        &'a mut self,
        job: &Job<'a>,
        eye: DVec3,
        objects: &[u32],
    ) -> Result<Option<Box<dyn PathSearch + 'a>>, RenderError> {
        let _ = eye;
        let (scene, view, order) = (job.scene, job.view, job.quality.order);
        let complete = |projector| -> Box<dyn PathSearch + 'a> {
            Box::new(ProjectedPaths::new(scene, view, projector, order, objects))
        };
        Ok(self.projector(job)?.map(complete))
    }
}

/// All methods, the reference first.
pub fn all() -> &'static [&'static MethodInfo] {
    static ALL: [&MethodInfo; 9] = [
        &reference::INFO,
        &lookup::environment_map::INFO,
        &lookup::light_field::INFO,
        &lookup::layered_environment_map::INFO,
        &projection::planar_mirror::INFO,
        &projection::path_perturbation::INFO,
        &projection::sample_based_camera::INFO,
        &projection::explosion_map::INFO,
        &projection::reflector_search::INFO,
    ];
    &ALL
}

/// The method with this id and these settings.
pub fn create(id: &str, settings: &toml::Table) -> Result<Box<dyn ReflectionMethod>, RenderError> {
    (find(id)?.create)(settings)
}

/// What the method with this id is.
pub fn find(id: &str) -> Result<&'static MethodInfo, RenderError> {
    all().iter().copied().find(|info| info.id == id).ok_or_else(|| RenderError::UnknownMethod {
        id: id.into(),
        known: all().iter().map(|info| info.id).collect::<Vec<_>>().join(", "),
    })
}
