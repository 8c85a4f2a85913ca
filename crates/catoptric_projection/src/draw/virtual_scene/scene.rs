//! A scene with its mirrors made ready, its welded objects, and the virtual meshes of the last view.

use super::failed_paths::FailedPaths;
use super::kept_meshes::KeyedMeshes;
use super::mirror_state::MirrorState;
use crate::draw::flat_mirrors::has_flat_faces;
use crate::draw::stages::Stages;
use crate::draw::virtual_mesh::{Ends, WeldedObject};
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::path::manifold::{MeshTopologies, SpecularSurfaces};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Data that depend on the scene alone, and the virtual meshes of the last view.
pub struct VirtualScene {
    mirrors: MirrorState,
    topologies: MeshTopologies,
    /// True for objects that are mirrors or lenses and convex, or have only flat faces.
    is_plain: Vec<bool>,
    pub(super) welded: Vec<Arc<WeldedObject>>,
    meshes: Mutex<KeyedMeshes>,
    failed: Mutex<FailedPaths>,
}

impl VirtualScene {
    /// Prepares a scene. Returns true if its mirrors are those of `old`, whose valid data is kept, but for its meshes
    /// ([`Self::take_meshes`]).
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

    /// Takes the failures of paths from an earlier moment of a scene, unless it has other objects.
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

    /// The paths that have failed so far.
    pub(super) fn locked_failed(&self) -> MutexGuard<'_, FailedPaths> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The virtual meshes of the last view.
    pub(super) fn locked_meshes(&self) -> MutexGuard<'_, KeyedMeshes> {
        self.meshes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The mirrors as they are.
    pub(crate) fn mirror_state(&self) -> &MirrorState {
        &self.mirrors
    }

    /// The topologies of the mirrors' meshes.
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
}

/// True if a reflector or lens is convex.
fn is_convex(scene: &Scene, topologies: &MeshTopologies, object: u32) -> bool {
    match &scene.objects[object as usize].surface {
        Some(surface) => surface.is_convex(),
        None => topologies.is_convex(object),
    }
}
