//! State of every projection method with virtual meshes: mirrors made ready, welded objects, meshes of earlier
//! frames.

use super::prepared::Stages;
use super::virtual_mesh::{MeshQuality, VirtualMesh, VirtualObject, WeldedObject, virtual_mesh};
use super::{PathGeometry, draw_paths_with};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::projector::{SpecularPath, VertexProjector};
use crate::methods::reflector_maps::ReflectorMaps;
use crate::methods::{Job, Report};
use crate::optics::path::bundle::BounceKind;
use crate::optics::path::manifold::{MeshTopologies, SpecularSurfaces};
use crate::parallel;
use crate::progress::{Cancelled, Stage};
use crate::scene::{Role, Scene};
use crate::surface::PlacedSurface;
use glam::Vec3;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A reflector appears in itself only where the ray between is longer than this share of its size: beside the point
/// itself, unpolished appearances show the surface in itself. Chosen, not measured.
const OWN_REFLECTED: f32 = 0.02;

/// The same for lenses through which it is seen from within: at their rims they are thin. Chosen, not measured.
const OWN_TRANSMITTED: f32 = 0.002;

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

/// Virtual meshes by path and object, with the objects that they were made of.
type KeyedMeshes = HashMap<(u32, u32), (Arc<WeldedObject>, VirtualMesh)>;

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
    /// maps show these.
    ///
    /// # Errors
    /// Those of the rasteriser.
    pub(in crate::methods::projection) fn draw<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        projector: &P,
        quality: &MeshQuality,
        maps: Option<&ReflectorMaps>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let mut report = Report::default();
        let mut watch = Stopwatch::new();
        let projected = self.add_missing_meshes(job, projector, quality)?;
        let meshes = self.locked_meshes();
        let geometry = |(path, sequence): (usize, &SpecularPath)| {
            let mut geometry = PathGeometry { path: sequence.clone(), ..PathGeometry::default() };
            for object in 0..job.scene.objects.len() as u32 {
                if let Some((_, mesh)) = meshes.get(&(path as u32, object)) {
                    mesh.append_to(&mut geometry.vertices, &mut geometry.triangles, &mut geometry.corners);
                }
            }
            geometry
        };
        let geometry: Vec<PathGeometry> = projector.paths().iter().enumerate().map(geometry).collect();
        let unfinished: u64 = meshes.values().map(|(_, mesh)| mesh.unfinished).sum();
        drop(meshes);
        report.stages_ms.push(("project", watch.lap_ms()));
        report.counts.insert("vertices_projected", projected);
        report.counts.insert("virtual_triangles", geometry.iter().map(|path| path.triangles.len() as u64).sum());
        report.counts.insert("paths", geometry.len() as u64);
        if unfinished > 0 {
            report.fallbacks.insert("undivided_pieces", unfinished);
        }
        projector.add_fallbacks(&mut report);
        report.add_raster(&draw_paths_with(job, geometry, maps, target)?);
        Ok(report)
    }

    /// Makes the virtual meshes that are not kept from an earlier frame; returns the number of points projected.
    fn add_missing_meshes<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        projector: &P,
        quality: &MeshQuality,
    ) -> Result<u64, Cancelled> {
        let mut projected = 0;
        let stage = Stage::begin(job.progress, "projecting", projector.paths().len() * job.scene.objects.len())?;
        for (path, sequence) in projector.paths().iter().enumerate() {
            let Some(last) = sequence.bounces.last() else { continue };
            for (index, object) in job.scene.objects.iter().enumerate() {
                stage.advance(1)?;
                let own = last.object == index as u32;
                let reflected = last.kind == BounceKind::Reflect;
                let share = if reflected { OWN_REFLECTED } else { OWN_TRANSMITTED };
                let convex = object.surface.as_ref().is_some_and(PlacedSurface::is_convex);
                if own && convex && reflected && !object.inside {
                    continue; // rays that leave a convex mirror never come back
                }
                let (key, welded) = ((path as u32, index as u32), &self.welded[index]);
                if self.locked_meshes().get(&key).is_some_and(|(old, _)| Arc::ptr_eq(old, welded)) {
                    continue;
                }
                let virtual_object = VirtualObject {
                    welded,
                    first_triangle: object.triangles.start,
                    alpha_tested: job.scene.is_alpha_tested(index as u32),
                    path: path as u32,
                    least_segment: if own { share * object.bounds.diagonal() } else { 0.0 },
                    last_reflector: job.scene.objects[last.object as usize].bounds,
                    scene_size: job.scene.bounds.diagonal(),
                };
                let mesh = virtual_mesh(projector, &virtual_object, quality, &stage)?;
                projected += mesh.points_projected;
                self.locked_meshes().insert(key, (welded.clone(), mesh));
            }
        }
        Ok(projected)
    }
}
