//! The work that a frame of a method with virtual meshes may take, and the drawing of paths beyond it.

use super::drawing::draw_paths_with;
use super::far_maps::MapsInView;
use super::lists::{EndsOfPaths, PathGeometry, draw_lists, leave_lenses_to_rays};
use super::multiperspective::{TileModel, TiledScene, follows_lenses, spreads_light};
use super::overlays::ShownPixels;
use super::stages::Stages;
use super::virtual_mesh::Ends;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::{Job, Quality, Report, declare_choices};
use catoptric_engine::raster::{self, DrawList, Fragment, FragmentShader, scene_draw_list};
use glam::Vec3;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// Smaller pictures have as much work as one of this many pixels: vertices have to be found however few pixels they
/// cover.
const LEAST_PIXELS: u64 = 720 * 480;

/// The approximate number of pixels in which the shares of a picture are sampled.
const GLANCE_PIXELS: u32 = 4800;

/// Shares of the reference's time for a picture: for an empty picture, for pixels that show the scene, and in addition
/// for those that show reflectors and lenses. About as measured of built-in scenes and files.
const EMPTY_SHARE: f64 = 0.25;
const SCENE_SHARE: f64 = 0.75;
const SPECULAR_SHARE: f64 = 1.0;

/// The default limit: with it frames take up to about one and a half times the reference's of 16 samples a pixel, on
/// built-in scenes and files.
pub(crate) const WORK_A_PIXEL: f32 = 24.0;

/// The limit of presets that draw all paths themselves: enough on most scenes.
pub(crate) const WORK_ALONE: f32 = 150.0;

declare_choices! {
    /// The way to draw paths that are not done within the work of a frame.
    pub enum BeyondWork {
        /// Tiles, as the method `multiperspective` does: exactly.
        Tiles = "tiles",
        /// The same method, coarser or in part.
        Coarse = "coarse",
    }
}

/// The limit of a frame's work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorkLimit {
    /// Units of about 100 ns of one core, for every pixel.
    pub(crate) a_pixel: f32,
    pub(crate) beyond: BeyondWork,
}

/// The work of one frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FrameWork {
    /// Limit for building the paths of a view, in units of about 100 ns of one core.
    pub(crate) paths: u64,
    /// Limit for virtual meshes, in the same units.
    pub(crate) meshes: u64,
}

impl FrameWork {
    /// The limit for building the paths of a view that points are projected on one by one, not for a picture: some
    /// seconds of one core. Chosen, not measured.
    pub(super) const PATHS_WITHOUT_PICTURE: u64 = 40_000_000;
}

impl WorkLimit {
    /// The fate of pieces on which appearances end: where tiles draw the rest, these are left to them.
    pub(super) fn ends(&self) -> Ends {
        match self.beyond {
            BeyondWork::Tiles => Ends::LeftOut,
            BeyondWork::Coarse => Ends::Followed,
        }
    }

    /// The limits of work for a picture of a scene, about in proportion to the reference's time for it.
    ///
    /// # Errors
    /// The errors of the rasteriser.
    pub(super) fn of_frame(&self, scene: &Scene, view: &View) -> Result<FrameWork, RenderError> {
        let pixels = (u64::from(view.width) * u64::from(view.height)).max(LEAST_PIXELS);
        let glance = Glance::of(scene, view)?;
        let shares = EMPTY_SHARE + SCENE_SHARE * glance.scene + SPECULAR_SHARE * glance.specular;
        let meshes = in_steps((pixels as f64 * f64::from(self.a_pixel) * shares) as u64);
        // Meshes take longer than paths.
        Ok(FrameWork { paths: meshes / 2, meshes })
    }
}

/// The nearest of steps, four from a power of two to the next: little changes of a scene do not change the work, so
/// that data built with it is kept.
pub fn in_steps(work: u64) -> u64 {
    let step = (work / 4).checked_ilog2().map_or(1, |log2| 1 << log2);
    (work + step / 2) / step * step
}

/// Shares of a picture.
struct Glance {
    /// The share that shows the scene.
    scene: f64,
    /// The share that shows reflectors and lenses.
    specular: f64,
}

impl Glance {
    fn of(scene: &Scene, view: &View) -> Result<Self, RenderError> {
        let pixels = (u64::from(view.width) * u64::from(view.height)) as f64;
        let smaller = (f64::from(GLANCE_PIXELS) / pixels).sqrt().min(1.0);
        let side = |pixels: u32| ((f64::from(pixels) * smaller).ceil() as u32).max(1);
        let small = View { width: side(view.width), height: side(view.height), ..view.clone() };
        let [seen, specular] = [(); 2].map(|()| AtomicU64::new(0));
        let lists = [scene_draw_list(scene, &small, |object| Some(u32::from(scene.role_of(object).is_specular())))];
        raster::for_each_seen(&small, 1, &lists, 0, &Unshaded, |_, triangle| {
            seen.fetch_add(1, Ordering::Relaxed);
            specular.fetch_add(triangle.group.into(), Ordering::Relaxed);
        })?;
        let share = |count: AtomicU64| count.into_inner() as f64 / (f64::from(small.width) * f64::from(small.height));
        Ok(Self { scene: share(seen), specular: share(specular) })
    }
}

/// Shader of a pass that counts pixels.
struct Unshaded;

impl FragmentShader for Unshaded {
    fn shade(&self, _: &Fragment<'_>) -> Vec3 {
        Vec3::ZERO
    }
}

/// The bundles of tiles may miss their rays by this much: the default of `multiperspective`.
const TILE_ACCURACY_PX: f32 = 0.5;

/// Tiles that draw the paths that meshes do not, and the light of rough mirrors.
pub(crate) struct ExactTiles<'a> {
    pub(super) scene: &'a Arc<Scene>,
    pub(super) tables: &'a LazyTiles,
    pub(super) beyond: BeyondWork,
}

impl ExactTiles<'_> {
    /// True if paths that meshes do not draw are left to tiles.
    pub(super) fn go_on(&self) -> bool {
        self.beyond == BeyondWork::Tiles
    }

    /// Draws geometry of paths; with `ends` that go on, tiles draw the rest, where no path goes on.
    ///
    /// Rough mirrors are always drawn as by tiles.
    ///
    /// # Errors
    /// As [`catoptric_engine::raster::draw`].
    pub(super) fn draw(
        &self,
        job: &Job<'_>,
        geometry: Vec<PathGeometry>,
        ends: &EndsOfPaths,
        maps: MapsInView<'_>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let mut report = Report::default();
        let by_tiles = *ends != EndsOfPaths::Environment;
        if !by_tiles && !spreads_light(job.scene) {
            return Ok(draw_paths_with(job, geometry, maps, target)?.1);
        }
        let tables = self.tables.get(self.scene, &mut report, job.progress)?;
        let mut lists = draw_lists(job, geometry, maps.whole, ends);
        if by_tiles && self.tables.follows_lenses {
            leave_lenses_to_rays(job.scene, &mut lists);
        }
        let model = TileModel { accuracy_px: TILE_ACCURACY_PX, by_rays: false, turns_normals: false };
        report.add(tables.draw(job, &lists, by_tiles.then_some(model), maps, target)?);
        Ok(report)
    }

    /// The surfaces that pixels show of lists, and by tiles where no list goes on.
    ///
    /// # Errors
    /// As [`catoptric_engine::raster::draw`].
    pub(super) fn shown(
        &self,
        job: &Job<'_>,
        lists: &[DrawList],
        maps: MapsInView<'_>,
    ) -> Result<ShownPixels, RenderError> {
        let tables = self.tables.get(self.scene, &mut Report::default(), job.progress)?;
        let model = TileModel { accuracy_px: TILE_ACCURACY_PX, by_rays: false, turns_normals: false };
        tables.shown(job, lists, model, maps)
    }
}

/// Scenes of more triangles have the tables of tiles made while they are prepared: no frame waits for them, which it
/// would for over a tenth of a second. Chosen, not measured.
const MANY_TRIANGLES: usize = 100_000;

/// The tables of tiles, made when they are first needed, or before.
pub(crate) struct LazyTiles {
    made: OnceLock<TiledScene>,
    /// Rays follow lenses in place of tiles.
    follows_lenses: bool,
}

impl LazyTiles {
    /// The tables for tiles of a scene whose paths go on within a limit of work; made at once if that will take long.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(super) fn new(
        limit: WorkLimit,
        (scene, quality): (&Arc<Scene>, Quality),
        stages: &mut Stages<'_>,
    ) -> Result<Self, RenderError> {
        let tables = Self { made: OnceLock::new(), follows_lenses: follows_lenses(scene, quality) };
        if limit.beyond == BeyondWork::Tiles && scene.triangles.len() > MANY_TRIANGLES {
            tables.get(scene, &mut stages.report, stages.progress)?;
        }
        Ok(tables)
    }

    /// The tables of a scene at another moment: made from those of the old moment, if tables were needed there.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(super) fn of_moment(
        old: &Self,
        (scene, quality): (&Arc<Scene>, Quality),
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let tables = Self { made: OnceLock::new(), follows_lenses: follows_lenses(scene, quality) };
        if let Some(old) = old.made.get() {
            let _ = tables.made.set(tables.make(scene, Some(old), &mut Report::default(), progress)?);
        }
        Ok(tables)
    }

    fn make(
        &self,
        scene: &Arc<Scene>,
        old: Option<&TiledScene>,
        report: &mut Report,
        progress: &dyn Progress,
    ) -> Result<TiledScene, RenderError> {
        let mut tiled = TiledScene::new(scene, old, report, progress)?;
        if self.follows_lenses {
            tiled.follow_lenses();
        }
        Ok(tiled)
    }

    /// The tables of the scene.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(super) fn get(
        &self,
        scene: &Arc<Scene>,
        report: &mut Report,
        progress: &dyn Progress,
    ) -> Result<&TiledScene, RenderError> {
        if let Some(made) = self.made.get() {
            return Ok(made);
        }
        let tiled = self.make(scene, None, report, progress)?;
        Ok(self.made.get_or_init(|| tiled))
    }
}
