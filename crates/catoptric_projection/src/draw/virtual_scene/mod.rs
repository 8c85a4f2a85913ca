//! State of every projection method with virtual meshes: mirrors made ready, welded objects, meshes of earlier
//! frames.

mod drawing;
mod failed_paths;
mod in_shares;
mod maker;
mod mirror_state;
pub(crate) mod rigid_motion;
mod whole_paths;

pub(crate) use mirror_state::MirrorState;

use super::flat_mirrors::has_flat_faces;
use super::lists::EndsOfPaths;
use super::prepared::Stages;
use super::virtual_mesh::{Ends, MeshQuality, SteadySource, VirtualMesh, WeldedObject};
use super::{MapsInView, PathGeometry};
use catoptric_core::clock::Stopwatch;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath, VertexProjector};
use catoptric_engine::method::{Job, Report};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::path::manifold::{MeshTopologies, SpecularSurfaces};
use catoptric_engine::raster::BlockMask;
use failed_paths::{FailedPaths, WholePaths};
use maker::{FirstMesh, MeshMaker, PathObject};
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Data that depend on the scene alone, and the virtual meshes of the last view.
pub struct VirtualScene {
    mirrors: MirrorState,
    topologies: MeshTopologies,
    /// For every object, true if it is a mirror or lens that is convex or has flat faces alone.
    is_plain: Vec<bool>,
    welded: Vec<Arc<WeldedObject>>,
    meshes: Mutex<KeyedMeshes>,
    failed: Mutex<FailedPaths>,
}

/// Virtual meshes by path and object.
type KeyedMeshes = HashMap<PathObject, KeptMesh>;

/// A virtual mesh that later frames may use.
struct KeptMesh {
    /// How fine it was to be.
    quality: MeshQuality,
    /// What it was made of.
    welded: Arc<WeldedObject>,
    mesh: VirtualMesh,
    first: FirstMesh,
}

/// What virtual meshes of a view are made with.
pub(crate) struct MeshesOfView<'a, P: ?Sized> {
    pub(crate) projector: &'a P,
    pub(crate) quality: MeshQuality,
    /// Who knows what of them stays from view to view.
    pub(crate) steady: Option<&'a dyn SteadySource>,
}

/// The virtual meshes of a view, path by path.
pub(crate) struct VirtualGeometry {
    pub(crate) paths: Vec<PathGeometry>,
    /// Paths that are left to something else.
    pub(crate) paths_left: PathBeginnings,
    /// The number of those of more bounces than projected paths have: left too, or not drawn.
    paths_too_long: u64,
    /// True if appearances in lenses were found wrong.
    has_wrong_lenses: bool,
    /// What is seen where no path goes on.
    pub(super) ends: EndsOfPaths,
    pub(crate) report: Report,
}

/// What the making of meshes leaves beside them.
#[derive(Default)]
struct MadeMeshes {
    points_projected: u64,
    /// Vertices that were blended from what is kept, and how long that took.
    steady_points: u64,
    blend_ms: f64,
    /// The number of objects on paths that have no mesh, because there was no work left for it.
    left_out: u64,
}

impl MadeMeshes {
    /// Counts a mesh that has just been made.
    fn count(&mut self, mesh: &VirtualMesh) {
        self.points_projected += mesh.points_projected;
        self.steady_points += mesh.steady_points;
        self.blend_ms += mesh.blend_ms;
    }
}

impl VirtualScene {
    /// Prepares a scene and returns whether its mirrors are those of `old`: what is still true of that one is kept, but
    /// for its meshes ([`Self::take_meshes`]).
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(crate) fn new(scene: &Scene, old: Option<&Self>, stages: &mut Stages<'_>) -> Result<(Self, bool), Cancelled> {
        let mirrors = MirrorState::of(scene);
        let same = old.filter(|old| old.mirrors == mirrors);
        let topologies = match same {
            Some(old) => old.topologies.clone(),
            None => {
                Stage::begin(stages.progress, "finding neighbours", 0)?;
                let topologies = MeshTopologies::of(scene);
                stages.lap("topology");
                topologies
            }
        };
        let is_plain = (0..scene.objects.len() as u32).map(|object| {
            scene.role_of(object).is_specular()
                && (is_convex(scene, &topologies, object) || has_flat_faces(scene, object))
        });
        let is_plain = is_plain.collect();
        let old_welded = same.map_or(&[][..], |old| &old.welded);
        let welded = parallel::map_stage(stages.progress, "welding", scene.objects.len(), |index| {
            let welded = WeldedObject::new(scene, &scene.objects[index]);
            match old_welded.get(index).filter(|old| ***old == welded) {
                Some(same) => same.clone(),
                None => Arc::new(welded),
            }
        })?;
        stages.lap("weld");
        let (meshes, failed) = (Mutex::default(), Mutex::default());
        Ok((Self { mirrors, topologies, is_plain, welded, meshes, failed }, same.is_some()))
    }

    /// Takes the virtual meshes of an earlier scene with the same mirrors.
    pub(crate) fn take_meshes(&self, old: &Self) {
        *self.locked_meshes() = std::mem::take(&mut *old.locked_meshes());
    }

    /// Takes from an earlier moment of a scene what is known of paths that have failed, unless it has other objects.
    pub(crate) fn take_failed(&self, old: &Self) {
        if self.welded.len() == old.welded.len() {
            let mut failed = std::mem::take(&mut *old.locked_failed());
            failed.outdate();
            *self.locked_failed() = failed;
        }
    }

    /// Begins a frame of a view with so much work, and returns the paths that it does not try, as they have failed.
    pub(crate) fn begin_frame(&self, view: &View, work: u64) -> PathBeginnings {
        self.locked_failed().begin_frame(view, work)
    }

    fn locked_failed(&self) -> MutexGuard<'_, FailedPaths> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn locked_meshes(&self) -> MutexGuard<'_, KeyedMeshes> {
        self.meshes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The mirrors as they are.
    pub(crate) fn mirror_state(&self) -> &MirrorState {
        &self.mirrors
    }

    /// What is known of the mirrors' meshes.
    pub(crate) fn topologies(&self) -> &MeshTopologies {
        &self.topologies
    }

    /// The mirrors, made ready for solvers.
    pub fn surfaces<'a>(&self, scene: &'a Scene) -> SpecularSurfaces<'a> {
        SpecularSurfaces::with_topologies(scene, &self.topologies)
    }

    /// True if a reflector or lens is convex.
    pub(crate) fn is_convex(&self, scene: &Scene, object: u32) -> bool {
        is_convex(scene, &self.topologies, object)
    }

    /// The fate of pieces on which appearances end, on a path: in flat and convex mirrors all points appear once at
    /// the most, and end at silhouettes alone, so these are drawn whatever is wanted.
    pub(crate) fn ends_on(&self, path: &SpecularPath, wanted: Ends) -> Ends {
        let is_plain = |bounce: &Bounce| bounce.kind == BounceKind::Reflect && self.is_plain[bounce.object as usize];
        if path.bounces.iter().all(is_plain) { Ends::Followed } else { wanted }
    }

    /// Forgets all virtual meshes: the view has changed.
    pub(crate) fn forget_meshes(&self) {
        self.locked_meshes().clear();
    }

    /// The geometry of a view's paths, and what was left out of it. Makes the virtual meshes that are missing, with
    /// about as much work; if paths are to be whole, those that take more are left out, and those that are given are
    /// not tried.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(crate) fn geometry<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        MeshesOfView { projector, quality, steady }: &MeshesOfView<'_, P>,
        (work, whole): (u64, Option<&PathBeginnings>),
        (maps, wrong_in_lenses): (MapsInView<'_>, Option<&BlockMask>),
    ) -> Result<VirtualGeometry, Cancelled> {
        let mut report = Report::default();
        let mut watch = Stopwatch::new();
        let projector = *projector;
        let maker = MeshMaker { scene: self, job, projector, quality, steady: *steady };
        let pairs = maker.pairs(maps);
        if maps.far.is_some() {
            // What has become far since an earlier frame is not drawn twice.
            let wanted: HashSet<PathObject> = pairs.iter().copied().collect();
            self.locked_meshes().retain(|key, _| wanted.contains(key));
        }
        let mut is_drawn = vec![true; projector.paths().len()];
        let mut paths_left = PathBeginnings::default();
        let made = if let Some(without) = whole {
            let (made, WholePaths { undone, not_tried, tries }) = maker.add_whole(&pairs, (work, without))?;
            self.locked_failed().note(&tries, (job.scene, job.view), work);
            for (drawn, path) in is_drawn.iter_mut().zip(projector.paths()) {
                *drawn = !undone.hold(path);
            }
            report.counts.insert("paths_not_tried_again", not_tried);
            paths_left = undone;
            made
        } else {
            maker.add_in_shares(&pairs, work)?
        };
        let meshes = self.locked_meshes();
        let geometry = |(path, sequence): (usize, &SpecularPath)| {
            let holes = projector.holes(path as u32).cloned().unwrap_or_default();
            let mut geometry = PathGeometry { path: sequence.clone(), holes, ..PathGeometry::default() };
            for object in 0..job.scene.objects.len() as u32 {
                if let Some(kept) = meshes.get(&(path as u32, object)) {
                    geometry.holes.add(&kept.mesh.holes);
                    kept.mesh.append_to(&mut geometry.vertices, &mut geometry.triangles, &mut geometry.corners);
                }
            }
            geometry
        };
        let drawn_paths = projector.paths().iter().enumerate().filter(|(path, _)| is_drawn[*path]);
        let paths: Vec<PathGeometry> = drawn_paths.map(geometry).collect();
        let drawn = || meshes.iter().filter(|((path, _), _)| is_drawn[*path as usize]).map(|(_, kept)| &kept.mesh);
        report.counts.insert("work", meshes.values().map(|kept| kept.mesh.work).sum());
        report.counts.insert("vertices_projected", made.points_projected);
        report.counts.insert("virtual_triangles", paths.iter().map(|path| path.triangles.len() as u64).sum());
        report.counts.insert("paths", paths.len() as u64);
        report.add_fallback("undivided_pieces", drawn().map(|mesh| mesh.unfinished).sum());
        report.add_fallback("extrapolated_points", drawn().map(|mesh| mesh.extrapolated).sum());
        report.add_fallback("appearances_left_out", drawn().map(|mesh| mesh.left_out).sum());
        report.add_fallback("objects_left_out", made.left_out);
        drop(meshes);
        let too_long = maker.beginnings_of_longer_paths(&pairs, |path| is_drawn[path as usize]);
        let paths_too_long = too_long.len() as u64;
        if whole.is_some() {
            paths_left.extend(too_long);
        } else {
            report.add_fallback("paths_too_long", paths_too_long);
        }
        projector.add_fallbacks(&mut report);
        report.stages_ms.push(("project", watch.lap_ms() - made.blend_ms));
        if made.steady_points > 0 {
            report.stages_ms.push(("blend", made.blend_ms));
            report.counts.insert("steady_vertices", made.steady_points);
        }
        report.add_fallback("paths_drawn_by_tiles", paths_left.len() as u64);
        let has_holes = paths.iter().any(|path| !path.holes.is_empty());
        let by_tiles = whole.is_some();
        let wrong_in_lenses = wrong_in_lenses.cloned().unwrap_or_default();
        let has_wrong_lenses = !wrong_in_lenses.is_empty();
        let of_blocks = if by_tiles { "lens_blocks_drawn_by_tiles" } else { "wrong_lens_blocks" };
        report.add_fallback(of_blocks, wrong_in_lenses.count());
        let ends = match by_tiles && (has_holes || !paths_left.is_empty() || has_wrong_lenses) {
            true => EndsOfPaths::GoOn(wrong_in_lenses),
            false => EndsOfPaths::Environment,
        };
        Ok(VirtualGeometry { paths, paths_left, paths_too_long, has_wrong_lenses, ends, report })
    }
}

/// True if a reflector or lens is convex.
fn is_convex(scene: &Scene, topologies: &MeshTopologies, object: u32) -> bool {
    match &scene.objects[object as usize].surface {
        Some(surface) => surface.is_convex(),
        None => topologies.is_convex(object),
    }
}
