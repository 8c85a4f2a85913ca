//! What every projection method with virtual meshes keeps: mirrors made ready, welded objects, meshes of earlier frames.

use super::drawing::{PathGeometry, draw_paths_with};
use super::projector::{SpecularPath, VertexProjector};
use super::virtual_mesh::{MeshQuality, VirtualMesh, VirtualObject, WeldedObject, virtual_mesh};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::lookup::environment_map::ReflectorMaps;
use crate::methods::{Job, Report};
use crate::optics::bundle::BounceKind;
use crate::scene::{Role, Scene};
use crate::surface::PlacedSurface;
use crate::surface::site::{MeshTopologies, SpecularSurfaces};
use crate::surface::tracer::Tracer;
use glam::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// A reflector appears in itself only where the ray between is longer than this share of its size: beside the point
/// itself, what is not polished sees the surface in itself.
const OWN_REFLECTED: f32 = 0.02;

/// The same for lenses through which it is seen from within: at their rims they are thin.
const OWN_TRANSMITTED: f32 = 0.002;

/// What depends on the scene alone, and the virtual meshes of the last view.
pub struct VirtualScene {
    mirrors: Mirrors,
    tracer: Arc<Tracer>,
    topologies: MeshTopologies,
    welded: Vec<Arc<WeldedObject>>,
    meshes: HashMap<(u32, u32), (Arc<WeldedObject>, VirtualMesh)>,
}

/// Everything that projections depend on, beside the view.
#[derive(Clone, Debug, Default, PartialEq)]
struct Mirrors {
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

impl Mirrors {
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

type KeyedMesh = ((u32, u32), (Arc<WeldedObject>, VirtualMesh));

impl VirtualScene {
    /// Puts a scene in the place of the one that was prepared before. What is still true of that one is kept: all,
    /// meshes included, if its mirrors are the same; if not, `frame`, what was made of them for a view, is forgotten.
    pub fn prepare<F>(slot: &mut Option<Self>, frame: &mut Option<F>, scene: &Scene) -> Report {
        let mut report = Report::default();
        let (prepared, same_mirrors) = Self::prepared(scene, slot.take(), &mut report);
        if !same_mirrors {
            *frame = None;
        }
        *slot = Some(prepared);
        report
    }

    fn prepared(scene: &Scene, old: Option<Self>, report: &mut Report) -> (Self, bool) {
        let mut watch = Stopwatch::new();
        let mirrors = Mirrors::of(scene);
        let old = old.filter(|old| old.mirrors == mirrors);
        let same_mirrors = old.is_some();
        let mut prepared = match old {
            Some(old) => old,
            None => {
                let tracer = Arc::new(Tracer::build(scene, |object| scene.role_of(object).is_specular()));
                report.stages_ms.push(("bvh", watch.lap_ms()));
                let topologies = MeshTopologies::of(scene);
                report.stages_ms.push(("topology", watch.lap_ms()));
                Self { mirrors, tracer, topologies, welded: Vec::new(), meshes: HashMap::new() }
            }
        };
        let weld = |index: usize| {
            let welded = WeldedObject::new(scene, &scene.objects[index]);
            match prepared.welded.get(index).filter(|old| ***old == welded) {
                Some(same) => same.clone(),
                None => Arc::new(welded),
            }
        };
        prepared.welded = crate::parallel::map_collect(scene.objects.len(), weld);
        report.stages_ms.push(("weld", watch.lap_ms()));
        (prepared, same_mirrors)
    }

    /// Whether it was made of a scene with as many objects.
    pub fn fits(&self, scene: &Scene) -> bool {
        self.welded.len() == scene.objects.len()
    }

    /// The mirrors, made ready for solvers.
    pub fn surfaces<'a>(&self, scene: &'a Scene) -> SpecularSurfaces<'a> {
        SpecularSurfaces::with_topologies(scene, &self.topologies)
    }

    /// The hierarchy over reflectors and lenses alone.
    pub fn tracer(&self) -> &Arc<Tracer> {
        &self.tracer
    }

    /// Forgets all virtual meshes: the view has changed.
    pub fn forget_meshes(&mut self) {
        self.meshes.clear();
    }

    /// Draws the picture: makes the virtual meshes that are not kept, with the projector, and has them drawn. Reflectors
    /// with environment maps show these.
    ///
    /// # Errors
    /// Those of the rasteriser.
    pub(super) fn draw<P: VertexProjector + ?Sized>(
        &mut self,
        job: &Job<'_>,
        projector: &P,
        quality: &MeshQuality,
        maps: Option<&ReflectorMaps>,
        report: &mut Report,
        target: &mut Framebuffer,
    ) -> Result<(), RenderError> {
        let mut watch = Stopwatch::new();
        let made = self.new_meshes(job, projector, quality);
        let paths: Vec<SpecularPath> = projector.paths().to_vec();
        let mut projected = 0;
        for (key, entry) in made {
            projected += entry.1.points_projected;
            self.meshes.insert(key, entry);
        }
        let geometry: Vec<PathGeometry> = paths
            .into_iter()
            .enumerate()
            .map(|(path, sequence)| {
                let mut geometry = PathGeometry { path: sequence, ..PathGeometry::default() };
                for object in 0..job.scene.objects.len() as u32 {
                    if let Some((_, mesh)) = self.meshes.get(&(path as u32, object)) {
                        mesh.append_to(&mut geometry.vertices, &mut geometry.triangles, &mut geometry.corners);
                    }
                }
                geometry
            })
            .collect();
        report.stages_ms.push(("project", watch.lap_ms()));
        report.counts.insert("vertices_projected", projected);
        report.counts.insert("virtual_triangles", geometry.iter().map(|path| path.triangles.len() as u64).sum());
        report.counts.insert("paths", geometry.len() as u64);
        let unfinished: u64 = self.meshes.values().map(|(_, mesh)| mesh.unfinished).sum();
        if unfinished > 0 {
            report.fallbacks.insert("undivided_pieces", unfinished);
        }
        report.add_raster(&draw_paths_with(job, geometry, maps, target)?);
        Ok(())
    }

    /// The virtual meshes that are not kept from an earlier frame.
    fn new_meshes<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        projector: &P,
        quality: &MeshQuality,
    ) -> Vec<KeyedMesh> {
        let mut made = Vec::new();
        for (path, sequence) in projector.paths().iter().enumerate() {
            let Some(last) = sequence.bounces.last() else { continue };
            for (index, object) in job.scene.objects.iter().enumerate() {
                let own = last.object == index as u32;
                let reflected = last.kind == BounceKind::Reflect;
                let share = if reflected { OWN_REFLECTED } else { OWN_TRANSMITTED };
                let convex = object.surface.as_ref().is_some_and(PlacedSurface::is_convex);
                if own && convex && reflected && !object.inside {
                    continue; // rays that leave a convex mirror never come back
                }
                let (key, welded) = ((path as u32, index as u32), &self.welded[index]);
                if self.meshes.get(&key).is_some_and(|(old, _)| Arc::ptr_eq(old, welded)) {
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
                made.push((key, (welded.clone(), virtual_mesh(projector, &virtual_object, quality))));
            }
        }
        made
    }
}
