//! State of every projection method with virtual meshes: mirrors made ready, welded objects, meshes of earlier
//! frames.

use super::prepared::Stages;
use super::virtual_mesh::{MeshQuality, VirtualMesh, VirtualObject, WeldedObject, virtual_mesh};
use super::{MapsInView, PathGeometry, draw_paths_with};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projector::{SpecularPath, VertexProjector};
use crate::methods::{Job, Report};
use crate::optics::path::bundle::BounceKind;
use crate::optics::path::manifold::{MeshTopologies, SpecularSurfaces};
use crate::parallel;
use crate::progress::{Cancelled, Stage};
use crate::scene::{Role, Scene};
use crate::surface::PlacedSurface;
use glam::Vec3;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A reflector appears in itself only where the ray between is longer than this share of its size: beside the point
/// itself, unpolished appearances show the surface in itself. Chosen, not measured.
const OWN_REFLECTED: f32 = 0.02;

/// The same for lenses through which it is seen from within: at their rims they are thin. Chosen, not measured.
const OWN_TRANSMITTED: f32 = 0.002;

/// Work that the virtual meshes of one frame may take: some seconds of one core. What can't be drawn in that is drawn
/// coarser, and counted. Chosen, not measured.
const FRAME_WORK: u64 = 60_000_000;

/// Mirrors and glass on paths of the highest order are drawn black: nothing but their outlines is seen, which may be
/// off by this many times what others may be. Chosen, not measured.
const BLACK: f32 = 2.0;

/// Objects on a path may first take this many times an even share of what is there for those of their kind: most need
/// less. Chosen, not measured.
const EVEN_SHARES: u64 = 2;

/// Of the work that is left in the end an object on a path may take one part of so many, or an even share if that is
/// more. Chosen, not measured.
const LARGEST_SHARE: u64 = 3;

/// Meshes are made again if they may take so many times what they were first allowed. Chosen, not measured.
const MUCH_MORE: u64 = 2;

/// Data that depend on the scene alone, and the virtual meshes of the last view.
pub struct VirtualScene {
    mirrors: MirrorState,
    topologies: MeshTopologies,
    welded: Vec<Arc<WeldedObject>>,
    meshes: Mutex<KeyedMeshes>,
}

/// Shapes and indices of refraction that projections depend on, beside the view.
#[derive(Clone, Debug, Default, PartialEq)]
struct MirrorState {
    objects: Vec<MirrorShape>,
    indices: Vec<f32>,
    object_count: usize,
}

/// One reflector or lens: what it does to light, and its surface, or its mesh where it has none.
#[derive(Clone, Debug, PartialEq)]
struct MirrorShape {
    object: u32,
    role: Role,
    inside: bool,
    surface: Option<PlacedSurface>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl MirrorState {
    fn of(scene: &Scene) -> Self {
        let objects = scene.specular_objects();
        let kept = objects.iter().map(|&index| {
            let object = &scene.objects[index as usize];
            let vertices = object.vertices.start as usize..object.vertices.end as usize;
            let vertices = if object.surface.is_none() { vertices } else { 0..0 };
            MirrorShape {
                object: index,
                role: scene.role_of(index),
                inside: object.inside,
                surface: object.surface.clone(),
                positions: scene.positions[vertices.clone()].to_vec(),
                normals: scene.normals[vertices].to_vec(),
            }
        });
        let indices = objects.iter().map(|&index| scene.material_of(index).ior);
        Self { objects: kept.collect(), indices: indices.collect(), object_count: scene.objects.len() }
    }
}

/// Virtual meshes by path and object.
type KeyedMeshes = HashMap<(u32, u32), KeptMesh>;

/// A virtual mesh that later frames may use.
struct KeptMesh {
    /// What it was made of.
    welded: Arc<WeldedObject>,
    mesh: VirtualMesh,
    /// What it first was allowed and took, before there was work left to make it again.
    first: FirstMesh,
}

#[derive(Clone, Copy)]
struct FirstMesh {
    allowed: u64,
    work: u64,
    needed: Option<u64>,
    is_coarse: bool,
}

impl FirstMesh {
    fn of(mesh: &VirtualMesh) -> Self {
        let is_coarse = mesh.unfinished + mesh.extrapolated > 0;
        Self { allowed: mesh.allowed, work: mesh.work, needed: mesh.needed, is_coarse }
    }

    /// True if it would be the same with this much work allowed.
    fn holds_with(&self, allowed: u64) -> bool {
        allowed == self.allowed || self.needed.is_some_and(|needed| allowed >= needed)
    }
}

impl VirtualScene {
    /// Prepares a scene and returns whether its mirrors are those of `old`: what is still true of that one is kept, but
    /// for its meshes ([`Self::take_meshes`]).
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(in crate::methods::projection) fn new(
        scene: &Scene,
        old: Option<&Self>,
        stages: &mut Stages<'_>,
    ) -> Result<(Self, bool), Cancelled> {
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
        let old_welded = same.map_or(&[][..], |old| &old.welded);
        let welded = parallel::map_stage(stages.progress, "welding", scene.objects.len(), |index| {
            let welded = WeldedObject::new(scene, &scene.objects[index]);
            match old_welded.get(index).filter(|old| ***old == welded) {
                Some(same) => same.clone(),
                None => Arc::new(welded),
            }
        })?;
        stages.lap("weld");
        Ok((Self { mirrors, topologies, welded, meshes: Mutex::default() }, same.is_some()))
    }

    /// Takes the virtual meshes of an earlier scene with the same mirrors.
    pub(in crate::methods::projection) fn take_meshes(&self, old: &Self) {
        *self.locked_meshes() = std::mem::take(&mut *old.locked_meshes());
    }

    fn locked_meshes(&self) -> MutexGuard<'_, KeyedMeshes> {
        self.meshes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The mirrors, made ready for solvers.
    pub fn surfaces<'a>(&self, scene: &'a Scene) -> SpecularSurfaces<'a> {
        SpecularSurfaces::with_topologies(scene, &self.topologies)
    }

    /// Forgets all virtual meshes: the view has changed.
    pub(in crate::methods::projection) fn forget_meshes(&self) {
        self.locked_meshes().clear();
    }

    /// Draws the picture: makes the virtual meshes that are missing and rasterises them. Reflectors with environment
    /// maps show these, and maps of far objects take the place of their virtual meshes.
    ///
    /// # Errors
    /// Those of the rasteriser.
    pub(in crate::methods::projection) fn draw<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        projector: &P,
        quality: &MeshQuality,
        maps: MapsInView<'_>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let mut report = Report::default();
        let mut watch = Stopwatch::new();
        let (projected, left_out) = self.add_missing_meshes(job, projector, quality, maps)?;
        let meshes = self.locked_meshes();
        let geometry = |(path, sequence): (usize, &SpecularPath)| {
            let mut geometry = PathGeometry { path: sequence.clone(), ..PathGeometry::default() };
            for object in 0..job.scene.objects.len() as u32 {
                if let Some(kept) = meshes.get(&(path as u32, object)) {
                    kept.mesh.append_to(&mut geometry.vertices, &mut geometry.triangles, &mut geometry.corners);
                }
            }
            geometry
        };
        let geometry: Vec<PathGeometry> = projector.paths().iter().enumerate().map(geometry).collect();
        let unfinished: u64 = meshes.values().map(|kept| kept.mesh.unfinished).sum();
        let appearances_left_out: u64 = meshes.values().map(|kept| kept.mesh.left_out).sum();
        let extrapolated: u64 = meshes.values().map(|kept| kept.mesh.extrapolated).sum();
        report.counts.insert("work", meshes.values().map(|kept| kept.mesh.work).sum());
        drop(meshes);
        report.stages_ms.push(("project", watch.lap_ms()));
        report.counts.insert("vertices_projected", projected);
        report.counts.insert("virtual_triangles", geometry.iter().map(|path| path.triangles.len() as u64).sum());
        report.counts.insert("paths", geometry.len() as u64);
        report.add_fallback("undivided_pieces", unfinished);
        report.add_fallback("objects_left_out", left_out);
        report.add_fallback("extrapolated_points", extrapolated);
        report.add_fallback("appearances_left_out", appearances_left_out);
        projector.add_fallbacks(&mut report);
        report.add_raster(&draw_paths_with(job, geometry, maps, target)?);
        Ok(report)
    }

    /// Makes the virtual meshes that are not kept from an earlier frame; returns the number of points projected, and of
    /// objects on paths that there was no work left for.
    ///
    /// All of them are made with about even shares of the work, then those that are coarse again with what is left.
    fn add_missing_meshes<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        projector: &P,
        quality: &MeshQuality,
        maps: MapsInView<'_>,
    ) -> Result<(u64, u64), Cancelled> {
        let pairs = self.pairs(job, projector, maps);
        if maps.far.is_some() {
            // What has become far since an earlier frame is not drawn twice.
            let wanted: HashSet<(u32, u32)> = pairs.iter().copied().collect();
            self.locked_meshes().retain(|key, _| wanted.contains(key));
        }
        let steps_of = |(_, object): (u32, u32)| VirtualObject::steps(&self.welded[object as usize]);
        let stage = Stage::begin(job.progress, "projecting", pairs.iter().map(|key| steps_of(*key)).sum())?;
        let (mut projected, mut remaining, mut left_out) = (0, FRAME_WORK, 0);
        let make = |key: (u32, u32), allowed: u64, stage: &Stage<'_>| {
            let object = self.virtual_object(job.scene, projector, key);
            let is_black = job.scene.role_of(key.1).is_specular() && self.length(projector, key) >= job.quality.order;
            let quality = if is_black { quality.coarser(BLACK) } else { *quality };
            virtual_mesh(projector, &object, &quality, allowed, stage)
        };
        let mut coarse = Vec::new();
        // Each kind leaves a half for those after it.
        let kinds: Vec<&[(u32, u32)]> =
            pairs.chunk_by(|a, b| self.kind(job, projector, *a) == self.kind(job, projector, *b)).collect();
        for (kind, pairs) in kinds.iter().enumerate() {
            let mut of_kind = if kind + 1 < kinds.len() { remaining / 2 } else { remaining };
            for (number, &key) in pairs.iter().enumerate() {
                let allowed = (EVEN_SHARES * of_kind / (pairs.len() - number) as u64).min(of_kind);
                let welded = &self.welded[key.1 as usize];
                if allowed == 0 {
                    self.locked_meshes().remove(&key);
                    left_out += 1;
                    continue;
                }
                let kept = self.locked_meshes().get(&key).and_then(|kept| {
                    (Arc::ptr_eq(&kept.welded, welded) && kept.first.holds_with(allowed)).then_some(kept.first)
                });
                let first = match kept {
                    Some(first) => {
                        stage.advance(steps_of(key) as u64)?;
                        first
                    }
                    None => {
                        let mesh = make(key, allowed, &stage)?;
                        projected += mesh.points_projected;
                        let first = FirstMesh::of(&mesh);
                        self.locked_meshes().insert(key, KeptMesh { welded: welded.clone(), mesh, first });
                        first
                    }
                };
                if first.is_coarse {
                    coarse.push((key, first.allowed));
                }
                of_kind = of_kind.saturating_sub(first.work);
                remaining = remaining.saturating_sub(first.work);
            }
        }
        let steps = coarse.iter().map(|(key, _)| steps_of(*key)).sum();
        let stage = Stage::begin(job.progress, "projecting again", steps)?;
        for (number, &(key, first_allowed)) in coarse.iter().enumerate() {
            let more = remaining / ((coarse.len() - number) as u64).min(LARGEST_SHARE);
            let is_again = more >= MUCH_MORE * first_allowed;
            let allowed = if is_again { more } else { first_allowed };
            let kept = self.locked_meshes().get(&key).map(|kept| (kept.mesh.holds_with(allowed), kept.mesh.work));
            let work = match kept {
                Some((true, work)) => {
                    stage.advance(steps_of(key) as u64)?;
                    work
                }
                _ => {
                    let mesh = make(key, allowed, &stage)?;
                    projected += mesh.points_projected;
                    let work = mesh.work;
                    if let Some(kept) = self.locked_meshes().get_mut(&key) {
                        kept.mesh = mesh;
                    }
                    work
                }
            };
            if is_again {
                remaining = remaining.saturating_sub(work);
            }
        }
        Ok((projected, left_out))
    }

    fn length<P: VertexProjector + ?Sized>(&self, projector: &P, (path, _): (u32, u32)) -> u32 {
        projector.paths()[path as usize].bounces.len() as u32
    }

    /// Short paths come first, and on these what has a colour of its own: mirrors are drawn black, or are the ground of
    /// longer paths.
    fn kind<P: VertexProjector + ?Sized>(&self, job: &Job<'_>, projector: &P, key: (u32, u32)) -> (u32, bool) {
        (self.length(projector, key), job.scene.role_of(key.1).is_specular())
    }

    /// The paths and objects that may appear on them, by their kind, without those that maps of far objects show.
    fn pairs<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        projector: &P,
        maps: MapsInView<'_>,
    ) -> Vec<(u32, u32)> {
        let scene = job.scene;
        let mut pairs = Vec::new();
        for (path, sequence) in projector.paths().iter().enumerate() {
            let Some(last) = sequence.bounces.last() else { continue };
            for (index, object) in scene.objects.iter().enumerate() {
                let is_convex = || match &object.surface {
                    Some(surface) => surface.is_convex(),
                    None => self.topologies.is_convex(index as u32),
                };
                let from_without = || !object.inside && !job.view.may_start_within(&object.bounds);
                let own = last.object == index as u32 && last.kind == BounceKind::Reflect;
                if own && is_convex() && from_without() {
                    continue; // rays that leave a convex mirror never come back
                }
                if maps.far.is_some_and(|far| far.shows(last.object, index as u32)) {
                    continue;
                }
                pairs.push((path as u32, index as u32));
            }
        }
        pairs.sort_by_key(|&key| (self.kind(job, projector, key), key));
        pairs
    }

    /// An object on a path.
    fn virtual_object<'a, P: VertexProjector + ?Sized>(
        &'a self,
        scene: &Scene,
        projector: &P,
        (path, index): (u32, u32),
    ) -> VirtualObject<'a> {
        let object = &scene.objects[index as usize];
        let last = projector.paths()[path as usize].bounces.last();
        let share = match last {
            Some(last) if last.object != index => 0.0,
            Some(last) if last.kind == BounceKind::Transmit => OWN_TRANSMITTED,
            _ => OWN_REFLECTED,
        };
        VirtualObject {
            welded: &self.welded[index as usize],
            first_triangle: object.triangles.start,
            alpha_tested: scene.is_alpha_tested(index),
            path,
            least_segment: share * object.bounds.diagonal(),
            last_reflector: last.map_or(object.bounds, |last| scene.objects[last.object as usize].bounds),
            scene_size: scene.bounds.diagonal(),
        }
    }
}
