//! The life cycle of projection methods with virtual meshes, shared by all of them: data that depends on the mirrors,
//! on the view, and on the objects among the mirrors, and the parts of it that are kept from frame to frame.

use super::far_maps::MapsInView;
use super::overlays::ShownPixels;
use super::stages::Stages;
use super::virtual_mesh::{Ends, MeshQuality, SteadySource};
use super::virtual_scene::{MeshesOfView, MirrorState, VirtualGeometry, VirtualScene};
use super::work_limit::{ExactTiles, FrameWork, LazyTiles, WorkLimit};
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::{Progress, Silent};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::path_lists::PathLists;
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath, VertexProjector};
use catoptric_engine::method::{Frame, Job, Method, MethodInfo, Prepared, Quality, Report};
use catoptric_engine::raster::BlockMask;
use std::collections::HashSet;
use std::sync::{Arc, OnceLock};

/// The parts of a projection method that draws virtual meshes.
pub(crate) trait MeshProjection: Clone + Send + Sync + 'static {
    /// Data that depends on the reflectors and lenses alone.
    type Mirrors: Send + Sync;
    /// Data that depends on reflectors, lenses and the view, but not on objects that move among them.
    type ViewData: Send + Sync;
    /// The projector of one view.
    type Projector<'a>: VertexProjector + 'a;

    /// The overlays of its frames.
    const OVERLAYS: &'static [OverlayKind] = &[OverlayKind::Paths, OverlayKind::VirtualTriangles];

    /// The method.
    fn info(&self) -> &'static MethodInfo;

    /// Builds the data that depends on the mirrors; `old` is of the same mirrors and perhaps of another quality.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    fn mirrors(
        &self,
        scene: &Scene,
        quality: Quality,
        old: Option<&Self::Mirrors>,
        stages: &mut Stages<'_>,
    ) -> Result<Self::Mirrors, RenderError>;

    /// Takes the data that is still valid from mirrors of an earlier moment, which have moved since or changed their
    /// shape.
    fn take_moved(&self, _mirrors: &mut Self::Mirrors, _old: &Self::Mirrors, _now: (&Scene, &MirrorState)) {}

    /// Takes a bake for the mirrors, as they have just been built.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where the method uses none, and where it does not fit the scene.
    fn take_bake(
        &self,
        _mirrors: &mut Self::Mirrors,
        _scene: &Scene,
        _quality: Quality,
        bake: Arc<dyn Baked>,
    ) -> Result<(), RenderError> {
        self.info().refuse_bake(Some(bake))
    }

    /// True if data of the same view, mirrors and order is still right.
    ///
    /// # Errors
    /// As [`Self::view_data`].
    fn fits(&self, _context: &Context<'_, Self>, _data: &Self::ViewData) -> Result<bool, RenderError> {
        Ok(true)
    }

    /// Builds the data that depends on the view.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where a setting does not fit the scene, [`RenderError::Cancelled`].
    fn view_data(&self, context: &Context<'_, Self>, stages: &mut Stages<'_>) -> Result<Self::ViewData, RenderError>;

    /// True if nothing of a view's data was left out because there was too much to do.
    fn is_complete(&self, _data: &Self::ViewData) -> bool {
        true
    }

    /// Adds to a view's data the part that also depends on the objects among the mirrors.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    fn complete(
        &self,
        _context: &Context<'_, Self>,
        _data: &mut Self::ViewData,
        _stages: &mut Stages<'_>,
    ) -> Result<(), RenderError> {
        Ok(())
    }

    /// Removes the data that [`Self::complete`] has added: the objects have changed.
    fn forget_objects(&self, _data: &mut Self::ViewData) {}

    /// Counts and bytes of a view's data.
    fn describe(&self, data: &Self::ViewData, report: &mut Report);

    /// Takes from an earlier view's data the parts that the data of a new view may use again.
    fn take_over(&self, _data: &mut Self::ViewData, _old: Self::ViewData) {}

    /// The environment maps that take the place of projections.
    fn maps<'a>(&self, _data: &'a Self::ViewData) -> MapsInView<'a> {
        MapsInView::default()
    }

    /// The blocks of the picture where appearances in lenses that are seen directly are wrong.
    fn wrong_in_lenses<'a>(&self, _data: &'a Self::ViewData) -> Option<&'a BlockMask> {
        None
    }

    /// The work that a frame may take.
    fn work_limit(&self) -> WorkLimit;

    /// The fineness of virtual meshes in a view.
    fn mesh_quality(&self, view: &View) -> MeshQuality;

    /// An overlay of a kind that virtual meshes do not have, from the surfaces that pixels show and the paths that
    /// meshes draw.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    fn own_overlay(
        &self,
        _kind: OverlayKind,
        _context: &Context<'_, Self>,
        _data: &Self::ViewData,
        (_shown, _drawn): (&ShownPixels, &HashSet<SpecularPath>),
        _progress: &dyn Progress,
    ) -> Result<Option<Overlay>, RenderError> {
        Ok(None)
    }

    /// The parts of virtual meshes that can be kept while the eye moves a little, for methods that have such.
    fn steady<'a>(_projector: &'a Self::Projector<'_>) -> Option<&'a dyn SteadySource> {
        None
    }

    /// The projector of a view.
    fn projector<'a>(&'a self, context: &Context<'a, Self>, data: &'a Self::ViewData) -> Self::Projector<'a>;
}

/// The scene, mirrors and view that a step of the method works on.
pub(crate) struct Context<'a, M: MeshProjection> {
    pub(crate) scene: &'a Scene,
    pub(crate) virtual_scene: &'a VirtualScene,
    pub(crate) mirrors: &'a M::Mirrors,
    pub(crate) view: &'a View,
    /// Highest number of bounces of a path.
    pub(crate) order: u32,
    /// Work for building the paths of a view; code that only reads them builds none.
    pub(crate) work: u64,
    /// Paths that took too much work in an earlier frame: nothing is built for them.
    pub(crate) without: &'a PathBeginnings,
    /// True for pictures, in which something else draws the parts that are left out; points one by one need all paths.
    pub(crate) is_for_picture: bool,
    /// The fate of pieces on which appearances end.
    pub(crate) ends: Ends,
}

/// A projection method with its settings.
pub(crate) struct ProjectionMethod<M>(pub(crate) M);

/// The method prepared for a scene.
struct PreparedProjection<M: MeshProjection> {
    method: M,
    scene: Arc<Scene>,
    quality: Quality,
    virtual_scene: VirtualScene,
    tiles: LazyTiles,
    mirrors: M::Mirrors,
    /// Data of the last view.
    last: Option<LastView<M>>,
    /// The work of the last view's frames, until something moves.
    work: Option<(View, FrameWork)>,
    /// Something has moved since the last frame.
    has_moved: bool,
    report: Report,
}

struct LastView<M: MeshProjection> {
    view: View,
    order: u32,
    /// The work that there was for building its data.
    work: u64,
    /// Paths that are not tried.
    without: PathBeginnings,
    /// `None` if there is no other path.
    data: Option<M::ViewData>,
}

/// A frame: the prepared method for one view.
struct ProjectionFrame<'a, M: MeshProjection> {
    method: &'a M,
    scene: &'a Arc<Scene>,
    quality: Quality,
    virtual_scene: &'a VirtualScene,
    tiles: &'a LazyTiles,
    mirrors: &'a M::Mirrors,
    last: &'a LastView<M>,
    work: FrameWork,
    /// Data of the view for points one by one, if there is more of it than for pictures; made when it is needed.
    complete: OnceLock<Option<M::ViewData>>,
    report: Report,
}

impl<M: MeshProjection> Method for ProjectionMethod<M> {
    fn info(&self) -> &'static MethodInfo {
        self.0.info()
    }

    fn overlays(&self) -> &'static [OverlayKind] {
        M::OVERLAYS
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        if self.0.info().bake.is_none() {
            self.0.info().refuse_bake(bake.clone())?;
        }
        let mut stages = Stages::new(progress);
        let (virtual_scene, _) = VirtualScene::new(scene, None, &mut stages)?;
        let mut mirrors = self.0.mirrors(scene, quality, None, &mut stages)?;
        if let Some(bake) = bake {
            self.0.take_bake(&mut mirrors, scene, quality, bake)?;
        }
        let tiles = LazyTiles::new(self.0.work_limit(), (scene, quality), &mut stages)?;
        let (method, scene, report) = (self.0.clone(), scene.clone(), stages.report);
        Ok(Box::new(PreparedProjection {
            method,
            scene,
            quality,
            virtual_scene,
            tiles,
            mirrors,
            last: None,
            work: None,
            has_moved: false,
            report,
        }))
    }
}

impl<M: MeshProjection> Prepared for PreparedProjection<M> {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        let mut stages = Stages::new(progress);
        let (virtual_scene, same_mirrors) = VirtualScene::new(scene, Some(&self.virtual_scene), &mut stages)?;
        let mut mirrors = self.method.mirrors(scene, quality, same_mirrors.then_some(&self.mirrors), &mut stages)?;
        if !same_mirrors {
            self.method.take_moved(&mut mirrors, &self.mirrors, (scene, virtual_scene.mirror_state()));
        }
        let tiles = LazyTiles::of_moment(&self.tiles, (scene, quality), progress)?;
        // No step fails from here on.
        if same_mirrors {
            virtual_scene.take_meshes(&self.virtual_scene);
        } else {
            self.last = None;
        }
        if let Some(data) = self.last.as_mut().and_then(|last| last.data.as_mut()) {
            self.method.forget_objects(data);
        }
        virtual_scene.take_failed(&self.virtual_scene);
        (self.work, self.has_moved) = (None, true);
        (self.virtual_scene, self.tiles, self.mirrors) = (virtual_scene, tiles, mirrors);
        (self.scene, self.quality, self.report) = (scene.clone(), quality, stages.report);
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        let mut stages = Stages::new(progress);
        let Self { method, scene, quality, virtual_scene, tiles, mirrors, last, work: known_work, has_moved, .. } =
            self;
        let (method, scene, virtual_scene, tiles, mirrors, order) =
            (&*method, &*scene, &*virtual_scene, &*tiles, &*mirrors, quality.order);
        let work = match known_work.take().filter(|(known, _)| known == view) {
            Some((_, work)) => work,
            None => method.work_limit().of_frame(scene, view)?,
        };
        *known_work = Some((view.clone(), work));
        stages.lap("glance");
        let is_same = |last: &&LastView<M>| (&last.view, last.order, last.work) == (view, order, work.paths);
        let same = last.as_ref().filter(is_same);
        let without = match same.filter(|_| !*has_moved) {
            Some(last) => last.without.clone(),
            None => virtual_scene.begin_frame(view, work.meshes),
        };
        *has_moved = false;
        let (is_for_picture, paths) = (true, work.paths);
        let (without_paths, ends) = (&without, method.work_limit().ends());
        let context = Context {
            scene,
            virtual_scene,
            mirrors,
            view,
            order,
            work: paths,
            without: without_paths,
            is_for_picture,
            ends,
        };
        let keeps = match same.filter(|last| last.without == without).map(|last| &last.data) {
            Some(Some(data)) => method.fits(&context, data)?,
            Some(None) => true,
            None => false,
        };
        let current = match last.take_if(|_| keeps) {
            Some(kept) => kept,
            None => {
                let first = first_bounces(scene, view);
                let mut data = match !first.is_empty() && first.iter().all(|first| without.contains(first)) {
                    true => None,
                    false => Some(method.view_data(&context, &mut stages)?),
                };
                virtual_scene.forget_meshes();
                if let (Some(data), Some(old)) = (&mut data, last.take().and_then(|last| last.data)) {
                    method.take_over(data, old);
                }
                LastView { view: view.clone(), order, work: paths, without: without.clone(), data }
            }
        };
        let last = last.insert(current);
        stages.lap("build");
        if let Some(data) = &mut last.data {
            method.complete(&context, data, &mut stages)?;
            method.describe(data, &mut stages.report);
        }
        let (quality, complete, report) = (*quality, OnceLock::new(), stages.report);
        Ok(Box::new(ProjectionFrame {
            method,
            scene,
            quality,
            virtual_scene,
            tiles,
            mirrors,
            last,
            work,
            complete,
            report,
        }))
    }
}

/// The paths that begin at the reflectors and lenses that a view may show.
fn first_bounces(scene: &Scene, view: &View) -> PathBeginnings {
    let mut found = PathBeginnings::default();
    let seen = |object: &u32| view.may_show(scene.objects[*object as usize].bounds.corners());
    found.extend(scene.specular_objects().into_iter().filter(seen).map(|object| (Vec::new(), object)));
    found
}

impl<M: MeshProjection> ProjectionFrame<'_, M> {
    fn context<'b>(&'b self, work: u64, without: &'b PathBeginnings) -> Context<'b, M> {
        let Self { scene, virtual_scene, mirrors, last: LastView { view, order, .. }, .. } = self;
        let ends = Ends::Followed;
        Context { scene, virtual_scene, mirrors, view, order: *order, work, without, is_for_picture: false, ends }
    }

    /// The view's data with the parts that pictures leave out; `None` if making these fails.
    fn complete_data(&self) -> Option<M::ViewData> {
        let without = PathBeginnings::default();
        let context = self.context(FrameWork::PATHS_WITHOUT_PICTURE, &without);
        let mut stages = Stages::new(&Silent);
        let mut data = self.method.view_data(&context, &mut stages).ok()?;
        self.method.complete(&context, &mut data, &mut stages).ok()?;
        Some(data)
    }

    fn job<'b>(&'b self, progress: &'b dyn Progress) -> Job<'b> {
        Job { scene: self.scene, view: &self.last.view, quality: self.quality, progress }
    }

    /// The environment maps that take the place of projections.
    fn maps(&self) -> MapsInView<'_> {
        self.last.data.as_ref().map_or_else(MapsInView::default, |data| self.method.maps(data))
    }

    /// The geometry of the picture, and the tiles for the paths that it lacks.
    fn geometry(&self, progress: &dyn Progress) -> Result<(VirtualGeometry, ExactTiles<'_>), RenderError> {
        let Self { method, scene, virtual_scene, tiles, last: LastView { view, without, data, .. }, work, .. } = self;
        let tiles = ExactTiles { scene, tables: tiles, beyond: method.work_limit().beyond };
        let Some(data) = data else {
            return Ok((VirtualGeometry::all_left(first_bounces(scene, view)), tiles));
        };
        let ends = method.work_limit().ends();
        let projector = &method.projector(&Context { ends, ..self.context(0, without) }, data);
        let quality = MeshQuality { ends, ..method.mesh_quality(view) };
        let meshes = MeshesOfView { projector, quality, steady: M::steady(projector) };
        let whole = tiles.go_on().then_some(without);
        let instead = (method.maps(data), method.wrong_in_lenses(data));
        let found = virtual_scene.geometry(&self.job(progress), &meshes, (work.meshes, whole), instead)?;
        Ok((found, tiles))
    }
}

impl<M: MeshProjection> Frame for ProjectionFrame<'_, M> {
    fn report(&self) -> &Report {
        &self.report
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let (found, tiles) = self.geometry(progress)?;
        found.draw(&self.job(progress), &tiles, self.maps(), target)
    }

    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        if !M::OVERLAYS.contains(&kind) {
            return Ok(None);
        }
        let (found, tiles) = self.geometry(progress)?;
        let LastView { view, without, data, .. } = self.last;
        let own = |shown: &ShownPixels, drawn: &HashSet<SpecularPath>| match data {
            Some(data) => self.method.own_overlay(kind, &self.context(0, without), data, (shown, drawn), progress),
            None => Ok(Some(Overlay::new(kind, [view.width, view.height]))),
        };
        found.overlay(kind, &self.job(progress), &tiles, self.maps(), own)
    }

    fn path_lists(&self, progress: &dyn Progress) -> Result<Option<PathLists>, RenderError> {
        let maps = self.maps();
        if maps.whole.is_some() || maps.far.is_some() {
            let problem = "environment maps in place of projections are drawn on the CPU alone".into();
            return Err(RenderError::Limit { method: self.method.info().id, problem });
        }
        let (found, _) = self.geometry(progress)?;
        Ok(Some(found.path_lists(&self.job(progress))))
    }

    fn paths_left(&self, progress: &dyn Progress) -> Result<PathBeginnings, RenderError> {
        Ok(self.geometry(progress)?.0.paths_left)
    }

    fn projector(&self) -> Option<Box<dyn VertexProjector + '_>> {
        let LastView { without, data, .. } = self.last;
        let data = match data.as_ref().filter(|data| self.method.is_complete(data)) {
            Some(data) => data,
            None => self.complete.get_or_init(|| self.complete_data()).as_ref()?,
        };
        Some(Box::new(self.method.projector(&self.context(0, without), data)))
    }
}
