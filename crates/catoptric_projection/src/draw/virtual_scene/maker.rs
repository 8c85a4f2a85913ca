//! The making of virtual meshes: which objects on which paths, and how finely.

use super::kept_meshes::{FirstMesh, KeptMesh, MadeMeshes, PathObject};
use super::scene::VirtualScene;
use crate::draw::far_maps::MapsInView;
use crate::draw::virtual_mesh::{Allowance, MeshQuality, SteadySource, VirtualMesh, VirtualObject, virtual_mesh};
use crate::find::lens_check::OWN_TRANSMITTED;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_engine::method::Job;
use catoptric_engine::method::projector::{MAX_BOUNCES, PathBeginning, VertexProjector};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use std::sync::Arc;

/// A reflector appears in itself only where the ray between is longer than this share of its size: beside the point
/// itself, unpolished appearances show the surface in itself. Chosen, not measured.
const OWN_REFLECTED: f32 = 0.02;

/// Mirrors and glass on paths of the highest order are drawn black: only their outlines are seen, whose errors may be
/// this many times those of others. Chosen, not measured.
const BLACK: f32 = 2.0;

/// Makes the meshes of one view.
pub(super) struct MeshMaker<'a, P: VertexProjector + ?Sized> {
    pub(super) scene: &'a VirtualScene,
    pub(super) job: &'a Job<'a>,
    pub(super) projector: &'a P,
    pub(super) quality: &'a MeshQuality,
    pub(super) steady: Option<&'a dyn SteadySource>,
}

impl<P: VertexProjector + ?Sized> MeshMaker<'_, P> {
    /// Makes the mesh of an object on a path.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn make(
        &self,
        key: PathObject,
        allowance: Allowance,
        stage: &Stage<'_>,
    ) -> Result<VirtualMesh, Cancelled> {
        let object = self.virtual_object(key);
        virtual_mesh((self.projector, self.steady), &object, &self.quality_of(key), allowance, stage)
    }

    /// The fineness of the mesh of an object on a path.
    pub(super) fn quality_of(&self, key: PathObject) -> MeshQuality {
        let is_black = self.job.scene.role_of(key.1).is_specular() && self.length(key) >= self.job.quality.order;
        let quality = if is_black { self.quality.coarser(BLACK) } else { *self.quality };
        let path = &self.projector.paths()[key.0 as usize];
        MeshQuality { ends: self.scene.ends_on(path, quality.ends), ..quality }
    }

    /// The first mesh of an object on a path: one kept from an earlier frame if it would be the same, or a new one.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn first_mesh(
        &self,
        key: PathObject,
        allowance: Allowance,
        made: &mut MadeMeshes,
        stage: &Stage<'_>,
    ) -> Result<FirstMesh, Cancelled> {
        let (welded, quality) = (&self.scene.welded[key.1 as usize], self.quality_of(key));
        let kept = self.scene.locked_meshes().get(&key).and_then(|kept| {
            let is_same = Arc::ptr_eq(&kept.welded, welded) && kept.quality == quality;
            (is_same && kept.first.holds_with(allowance.work())).then_some(kept.first)
        });
        if let Some(first) = kept {
            stage.advance(self.steps(key))?;
            return Ok(first);
        }
        let mesh = self.make(key, allowance, stage)?;
        made.count(&mesh);
        let first = FirstMesh::of(&mesh);
        self.scene.locked_meshes().insert(key, KeptMesh { quality, welded: welded.clone(), mesh, first });
        Ok(first)
    }

    /// The steps of a stage that a mesh takes.
    pub(super) fn steps(&self, (_, object): PathObject) -> u64 {
        VirtualObject::steps(&self.scene.welded[object as usize]) as u64
    }

    /// The number of bounces of a path.
    pub(super) fn length(&self, (path, _): PathObject) -> u32 {
        self.projector.paths()[path as usize].bounces.len() as u32
    }

    /// Short paths come first, and on these objects with a colour of their own: mirrors are drawn black, or are the
    /// ground of longer paths.
    pub(super) fn kind(&self, key: PathObject) -> (u32, bool) {
        (self.length(key), self.job.scene.role_of(key.1).is_specular())
    }

    /// The paths and objects that may appear on them, by their kind, without those that maps of far objects show.
    pub(super) fn pairs(&self, maps: MapsInView<'_>) -> Vec<PathObject> {
        let (scene, view) = (self.job.scene, self.job.view);
        let mut pairs = Vec::new();
        for (path, sequence) in self.projector.paths().iter().enumerate() {
            let Some(last) = sequence.bounces.last() else { continue };
            for (index, object) in scene.objects.iter().enumerate() {
                let is_convex = || self.scene.is_convex(scene, index as u32);
                let from_without = || !object.inside && !view.may_start_within(&object.bounds);
                let own = last.object == index as u32 && last.kind == BounceKind::Reflect;
                let passes = |bounce: &&Bounce| bounce.object == index as u32 && bounce.kind == BounceKind::Transmit;
                let is_within = || sequence.bounces.iter().filter(passes).count() % 2 == 1;
                if own && !is_within() && (self.quality.is_plain || is_convex() && from_without()) {
                    continue; // rays that leave a convex mirror never come back; those within a lens do
                }
                if maps.far.is_some_and(|far| far.shows(last.object, index as u32)) {
                    continue;
                }
                pairs.push((path as u32, index as u32));
            }
        }
        pairs.sort_by_key(|&key| (self.kind(key), key));
        pairs
    }

    /// The mirrors and lenses that show on paths of the most bounces that are projected, where the order asks for more:
    /// of those paths that are `drawn`.
    pub(super) fn beginnings_of_longer_paths(
        &self,
        pairs: &[PathObject],
        drawn: impl Fn(u32) -> bool,
    ) -> Vec<PathBeginning> {
        let longest = MAX_BOUNCES as u32;
        if self.job.quality.order <= longest {
            return Vec::new();
        }
        let meshes = self.scene.locked_meshes();
        let shows = |key: &PathObject| meshes.get(key).is_some_and(|kept| !kept.mesh.triangles.is_empty());
        let goes_on = |key: &&PathObject| {
            let specular = self.job.scene.role_of(key.1).is_specular();
            specular && self.length(**key) == longest && drawn(key.0) && shows(key)
        };
        let beginning = |key: &PathObject| (self.projector.paths()[key.0 as usize].bounces.clone(), key.1);
        pairs.iter().filter(goes_on).map(beginning).collect()
    }

    /// An object on a path.
    fn virtual_object(&self, (path, index): PathObject) -> VirtualObject {
        let scene = self.job.scene;
        let object = &scene.objects[index as usize];
        let last = self.projector.paths()[path as usize].bounces.last();
        let share = match last {
            Some(last) if last.object != index => 0.0,
            Some(last) if last.kind == BounceKind::Transmit => OWN_TRANSMITTED,
            _ => OWN_REFLECTED,
        };
        VirtualObject {
            object: index,
            welded: self.scene.welded[index as usize].clone(),
            first_triangle: object.triangles.start,
            alpha_tested: scene.is_alpha_tested(index),
            path,
            least_segment: share * object.bounds.diagonal(),
            last_reflector: last.map_or(object.bounds, |last| scene.objects[last.object as usize].bounds),
            scene_size: scene.bounds.diagonal(),
        }
    }
}
