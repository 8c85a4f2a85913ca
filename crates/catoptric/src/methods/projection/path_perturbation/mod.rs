//! Perturbation of specular paths: a sparse set of traced rays, expanded to second order, tells where everything
//! appears.
//!
//! See this folder's `README.md`.

mod project;
mod settings;

pub use settings::{Candidates, ExpansionOrder, PathPerturbationSettings};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::math::Aabb;
use crate::methods::projection::drawing::{PathGeometry, draw_paths};
use crate::methods::projection::ray_map::{RayMap, Sampling, Specular, ViewField, eye_of};
use crate::methods::projection::virtual_mesh::{
    MeshQuality, PictureScale, VirtualMesh, VirtualObject, WeldedObject, virtual_mesh,
};
use crate::methods::projection::{SpecularPath, VertexProjector};
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::optics::bundle::BounceKind;
use crate::progress::Progress;
use crate::scene::{PreciseView, Scene, View};
use crate::surface::PlacedSurface;
use crate::surface::site::{MeshTopologies, SpecularSurfaces};
use crate::surface::tracer::Tracer;
use glam::Vec3;
use project::{Perturber, rule};
use std::collections::HashMap;
use std::sync::Arc;

/// What the perturbation method is.
pub static INFO: MethodInfo = MethodInfo {
    id: "path_perturbation",
    family: Family::Projection,
    summary: "a sparse set of traced specular paths, perturbed to second order, and polished, shows where vertices appear",
    paper: "Chen, Arvo 2000, Perturbation methods for interactive specular reflections",
    assumptions: "reflectors and lenses are smooth; reflections smaller than the finest sample spacing can be missed",
    cpu: true,
    gpu: false,
    bake: false,
    settings: PathPerturbationSettings::describe,
    create: |table| Ok(Box::new(PathPerturbation::new(PathPerturbationSettings::from_table(table)?))),
};

/// A reflector appears in itself only where the ray between is longer than this share of its size.
const OWN_SEGMENT: f32 = 0.002;

/// The least edge error and size of pieces without polish.
const COARSE_PX: (f32, f32) = (1.0, 3.0);

/// No more pieces than this are made of one object on one path, as a rule.
const MAX_PIECES: usize = 200_000;

/// The method with what it keeps from frame to frame.
struct PathPerturbation {
    settings: PathPerturbationSettings,
    scene: Option<Prepared>,
    frame: Option<Frame>,
}

/// What depends on the scene alone.
struct Prepared {
    mirrors: Mirrors,
    tracer: Tracer,
    topologies: MeshTopologies,
    welded: Vec<Arc<WeldedObject>>,
}

/// Everything that the ray map depends on, beside the view.
#[derive(Clone, Debug, Default, PartialEq)]
struct Mirrors {
    objects: Vec<MirrorShape>,
    indices: Vec<f32>,
    object_count: usize,
}

/// The shape of one reflector or lens: its surface, or its mesh where it has none.
#[derive(Clone, Debug, PartialEq)]
struct MirrorShape {
    object: u32,
    surface: Option<PlacedSurface>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

/// What depends on the view and the mirrors, but not on what moves among them.
struct Frame {
    view: View,
    order: u32,
    map: RayMap,
    meshes: HashMap<(u32, u32), (Arc<WeldedObject>, VirtualMesh)>,
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
                surface: object.surface.clone(),
                positions: scene.positions[vertices.clone()].to_vec(),
                normals: scene.normals[vertices].to_vec(),
            }
        });
        let indices = objects.iter().map(|&index| scene.material_of(index).ior);
        Self { objects: kept.collect(), indices: indices.collect(), object_count: scene.objects.len() }
    }
}

impl PathPerturbation {
    fn new(settings: PathPerturbationSettings) -> Self {
        Self { settings, scene: None, frame: None }
    }

    /// The mirrors of the scene that was prepared, made ready for solvers.
    fn surfaces<'a>(&self, scene: &'a Scene) -> Result<SpecularSurfaces<'a>, RenderError> {
        let prepared = self.scene.as_ref().ok_or_else(unprepared)?;
        Ok(SpecularSurfaces::with_topologies(scene, &prepared.topologies))
    }

    /// What appears just outside the picture belongs to triangles that reach into it.
    fn margin_px(&self) -> f32 {
        2.0 * self.settings.spacing_px
    }

    /// Builds the ray map where the kept one does not fit the view.
    fn build(&mut self, job: &Job<'_>, surfaces: &SpecularSurfaces<'_>) -> Result<u64, RenderError> {
        let Some(prepared) = &self.scene else { return Err(unprepared()) };
        if prepared.welded.len() != job.scene.objects.len() {
            return Err(unprepared());
        }
        let order = job.quality.order;
        if self.frame.as_ref().is_some_and(|frame| frame.view == *job.view && frame.order == order) {
            return Ok(0);
        }
        let settings = &self.settings;
        let sampling = Sampling {
            spacing_px: settings.spacing_px,
            finest_px: settings.finest_px,
            accuracy_px: settings.accuracy_px,
            max_cells: settings.max_samples as usize,
        };
        let specular = Specular { scene: job.scene, tracer: &prepared.tracer, surfaces, order };
        let field = ViewField::new(job.view, self.margin_px());
        let map = RayMap::build(&specular, &field, &sampling, &around(&job.scene.bounds), rule(settings));
        let traced = map.rays_traced;
        self.frame = Some(Frame { view: job.view.clone(), order, map, meshes: HashMap::new() });
        Ok(traced)
    }

    fn perturber<'a>(&'a self, job: &Job<'_>, surfaces: SpecularSurfaces<'a>) -> Result<Perturber<'a>, RenderError> {
        let frame = self.frame.as_ref().ok_or_else(unprepared)?;
        let sizes = job.scene.objects.iter().map(|object| f64::from(object.bounds.diagonal()));
        Ok(Perturber {
            map: &frame.map,
            surfaces,
            paths: frame.map.groups.iter().map(|group| group.path.clone()).collect(),
            eye: eye_of(job.view),
            view: PreciseView::new(job.view),
            settings: &self.settings,
            margin_px: self.margin_px().into(),
            sizes: sizes.collect(),
        })
    }
}

fn unprepared() -> RenderError {
    RenderError::Limit { method: INFO.id, problem: "it has not been prepared for the scene".into() }
}

/// A box a little larger than the scene's.
fn around(bounds: &Aabb) -> Aabb {
    let margin = Vec3::splat(bounds.diagonal() * 0.01);
    Aabb { min: bounds.min - margin, max: bounds.max + margin }
}

impl ReflectionMethod for PathPerturbation {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, _quality: Quality, _progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mirrors = Mirrors::of(scene);
        let kept = self.scene.take().filter(|prepared| prepared.mirrors == mirrors);
        let mut report = Report::default();
        let (tracer, topologies, old) = match kept {
            Some(prepared) => (prepared.tracer, prepared.topologies, prepared.welded),
            None => {
                self.frame = None;
                let tracer = Tracer::build(scene, |object| scene.role_of(object).is_specular());
                report.stages_ms.push(("bvh", watch.lap_ms()));
                let topologies = MeshTopologies::of(scene);
                report.stages_ms.push(("topology", watch.lap_ms()));
                (tracer, topologies, Vec::new())
            }
        };
        let weld = |index: usize| {
            let welded = WeldedObject::new(scene, &scene.objects[index]);
            match old.get(index).filter(|old| ***old == welded) {
                Some(same) => same.clone(),
                None => Arc::new(welded),
            }
        };
        let welded = crate::parallel::map_collect(scene.objects.len(), weld);
        report.stages_ms.push(("weld", watch.lap_ms()));
        self.scene = Some(Prepared { mirrors, tracer, topologies, welded });
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        let surfaces = self.surfaces(job.scene)?;
        let traced = self.build(job, &surfaces)?;
        report.counts.insert("rays_traced", traced);
        report.stages_ms.push(("build", watch.lap_ms()));

        let perturber = self.perturber(job, surfaces)?;
        let made = self.new_meshes(job, &perturber)?;
        let paths: Vec<SpecularPath> = perturber.paths().to_vec();
        drop(perturber);
        let frame = self.frame.as_mut().ok_or_else(unprepared)?;
        let mut projected = 0;
        for (key, entry) in made {
            projected += entry.1.points_projected;
            frame.meshes.insert(key, entry);
        }
        let geometry: Vec<PathGeometry> = paths
            .into_iter()
            .enumerate()
            .map(|(path, sequence)| {
                let mut geometry = PathGeometry { path: sequence, ..PathGeometry::default() };
                for object in 0..job.scene.objects.len() as u32 {
                    if let Some((_, mesh)) = frame.meshes.get(&(path as u32, object)) {
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
        report.counts.insert("sample_rays", frame.map.samples as u64);
        report.bytes.insert("ray_map", frame.map.byte_count());
        let unfinished: u64 = frame.meshes.values().map(|(_, mesh)| mesh.unfinished).sum();
        if unfinished > 0 {
            report.fallbacks.insert("undivided_pieces", unfinished);
        }
        report.add_raster(&draw_paths(job, geometry, target)?);
        Ok(report)
    }

    fn projector<'a>(&'a mut self, job: &Job<'a>) -> Result<Option<Box<dyn VertexProjector + 'a>>, RenderError> {
        let surfaces = self.surfaces(job.scene)?;
        self.build(job, &surfaces)?;
        Ok(Some(Box::new(self.perturber(job, surfaces)?)))
    }
}

type KeyedMesh = ((u32, u32), (Arc<WeldedObject>, VirtualMesh));

impl PathPerturbation {
    /// The virtual meshes that are not kept from an earlier frame.
    fn new_meshes(&self, job: &Job<'_>, perturber: &Perturber<'_>) -> Result<Vec<KeyedMesh>, RenderError> {
        let (Some(prepared), Some(frame)) = (&self.scene, &self.frame) else { return Err(unprepared()) };
        // What expansions alone say of neighbouring points differs by more than the finest pieces.
        let (edge_error_px, piece_px) = if self.settings.polish == 0 { COARSE_PX } else { (0.0, 0.0) };
        let quality = MeshQuality {
            edge_error_px: self.settings.edge_error_px.max(edge_error_px),
            piece_px: self.settings.piece_px.max(piece_px),
            picture: PictureScale::new(job.view),
            max_pieces: MAX_PIECES,
        };
        let mut made = Vec::new();
        for (path, sequence) in perturber.paths().iter().enumerate() {
            let Some(last) = sequence.bounces.last() else { continue };
            for (index, object) in job.scene.objects.iter().enumerate() {
                let own = last.object == index as u32;
                let convex = object.surface.as_ref().is_some_and(PlacedSurface::is_convex);
                if own && convex && last.kind == BounceKind::Reflect && !object.inside {
                    continue; // rays that leave a convex mirror never come back
                }
                let (key, welded) = ((path as u32, index as u32), &prepared.welded[index]);
                if frame.meshes.get(&key).is_some_and(|(old, _)| Arc::ptr_eq(old, welded)) {
                    continue;
                }
                let virtual_object = VirtualObject {
                    welded,
                    first_triangle: object.triangles.start,
                    alpha_tested: job.scene.is_alpha_tested(index as u32),
                    path: path as u32,
                    least_segment: if own { OWN_SEGMENT * object.bounds.diagonal() } else { 0.0 },
                    last_reflector: job.scene.objects[last.object as usize].bounds,
                    scene_size: job.scene.bounds.diagonal(),
                };
                made.push((key, (welded.clone(), virtual_mesh(perturber, &virtual_object, &quality))));
            }
        }
        Ok(made)
    }
}
