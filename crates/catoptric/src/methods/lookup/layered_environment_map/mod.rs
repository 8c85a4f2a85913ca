//! Layered environment maps: paths among reflectors and lenses are traced alone, and what is around them is looked up in
//! layers.
//!
//! See this folder's `README.md`.

mod capture;
mod groups;
mod layers;
mod maps;
mod mesh;
mod settings;
mod shader;
mod shell;
mod surroundings;
mod texels;
mod viewpoints;
mod visible;
mod welds;

pub use settings::{LayeredEnvironmentMapSettings, Shells, Transfer};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::lookup::greedy::{First, GreedyPaths};
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::parallel;
use crate::progress::Progress;
use crate::raster::{self, DrawList, DrawTriangle};
use crate::scene::{Role, Scene};
use crate::surface::tracer::Tracer;
use glam::Vec2;
use groups::LensGroup;
use layers::{Meeting, Stratum, strata};
use maps::LayeredMap;
use mesh::{AdaptiveMesh, Criteria, refined};
use shader::{LensShader, NO_LEAF};
use std::sync::atomic::AtomicU64;
use surroundings::{Strata, Surroundings};
use visible::VisibleTriangles;
use welds::Welds;

/// What layered environment maps are.
pub static INFO: MethodInfo = MethodInfo {
    id: "layered_environment_map",
    family: Family::Lookup,
    summary: "reflectors and lenses traced alone at an adaptive mesh's vertices; around them layers of textured shells",
    paper: "Hakura, Snyder 2001, Realistic reflections and refractions on graphics hardware with hybrid rendering and layered \
            environment maps",
    assumptions: "what is around a group of reflectors lies on a few simple shells; two paths a pixel",
    cpu: true,
    gpu: false,
    bake: None,
    settings: LayeredEnvironmentMapSettings::describe,
    in_force: LayeredEnvironmentMapSettings::in_force,
    create: |table| {
        let settings = LayeredEnvironmentMapSettings::from_table(table)?;
        Ok(Box::new(LayeredEnvironmentMap { settings, prepared: None }))
    },
};

/// Viewpoints on the circle that layers are made for.
const VIEWPOINTS: u32 = 45;

/// Pixels a side of the pictures from viewpoints that say where layers are.
const CLUSTER_SIZE: u32 = 40;

struct LayeredEnvironmentMap {
    settings: LayeredEnvironmentMapSettings,
    prepared: Option<Prepared>,
}

/// What depends on the scene alone.
struct Prepared {
    groups: Vec<LensGroup>,
    /// Of every object its group's number.
    group_of: Vec<Option<u32>>,
    /// Of every group.
    maps: Vec<LayeredMap>,
    welds: Welds,
    /// Highest number of specular events of a path.
    order: u32,
}

impl ReflectionMethod for LayeredEnvironmentMap {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, quality: Quality, progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        let groups = LensGroup::all(scene);
        let mut group_of = vec![None; scene.objects.len()];
        for (number, group) in groups.iter().enumerate() {
            group.objects.iter().for_each(|object| group_of[*object as usize] = Some(number as u32));
        }
        report.stages_ms.push(("bvh", watch.lap_ms()));
        let mut maps = Vec::with_capacity(groups.len());
        if quality.order > 0 && !groups.is_empty() {
            let everything = Tracer::build(scene, |_| true);
            for group in &groups {
                maps.push(self.map(scene, &everything, group, quality.order, progress));
            }
        }
        report.stages_ms.push(("capture", watch.lap_ms()));
        report.counts.insert("lens_groups", groups.len() as u64);
        report.counts.insert("layers", maps.iter().map(|map| map.layers.len() as u64).sum());
        report.bytes.insert("layers", maps.iter().map(LayeredMap::byte_count).sum());
        let welds = Welds::new(scene);
        self.prepared = Some(Prepared { groups, group_of, maps, welds, order: quality.order });
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let prepared = self.prepared.as_ref().filter(|known| known.group_of.len() == job.scene.objects.len());
        let Some(prepared) = prepared else {
            let problem = "it has not been prepared for the scene".into();
            return Err(RenderError::Limit { method: INFO.id, problem });
        };
        prepared.draw(&self.settings, job, target)
    }
}

impl LayeredEnvironmentMap {
    /// The layers about a group, captured from its centre.
    fn map(
        &self,
        scene: &Scene,
        everything: &Tracer,
        group: &LensGroup,
        order: u32,
        progress: &dyn Progress,
    ) -> LayeredMap {
        let LayeredEnvironmentMapSettings { layers, shells, size, capture_samples, .. } = self.settings;
        let around = Surroundings::new(scene, group);
        let found = group_strata(scene, group, &around, order, layers, shells);
        let strata = Strata::new(&around, everything, &found, order - 1);
        let rows: u32 = found.iter().map(|stratum| capture::layout_of(stratum, size).faces() * size).sum();
        progress.begin("capturing layers", u64::from(rows));
        let layer = |(number, stratum): (usize, &Stratum)| {
            capture::projected(&strata, number, stratum, group.center(), size, capture_samples, progress)
        };
        let layers = found.iter().enumerate().map(layer).collect();
        progress.end();
        LayeredMap { center: group.center(), layers }
    }
}

/// The layers about a group: of what rays through it meet that come from all viewpoints.
fn group_strata(
    scene: &Scene,
    group: &LensGroup,
    around: &Surroundings<'_>,
    order: u32,
    layers: u32,
    shells: Shells,
) -> Vec<Stratum> {
    let paths = GreedyPaths { scene, tracer: &group.tracer, order };
    let eyes = viewpoints::circle(scene, group, VIEWPOINTS);
    let rays_a_view = 2 * CLUSTER_SIZE * CLUSTER_SIZE;
    let meetings = parallel::map_collect(eyes.len(), |number| {
        let view = viewpoints::picture_of(scene, group, eyes[number], CLUSTER_SIZE);
        let mut meetings: Vec<Meeting> = Vec::new();
        let mut ray_number = number as u32 * rays_a_view;
        for pixel in 0..CLUSTER_SIZE * CLUSTER_SIZE {
            let ray = view.ray((pixel % CLUSTER_SIZE) as f32 + 0.5, (pixel / CLUSTER_SIZE) as f32 + 0.5);
            let Some(hit) = group.tracer.first_hit(scene, &ray, 0.0) else { continue };
            let encounter = group.tracer.encounter(scene, &ray, &hit, None);
            let is_lens = scene.role_of(encounter.point.object) == Role::Lens;
            for first in First::BOTH.into_iter().take(if is_lens { 2 } else { 1 }) {
                if let Some(leaving) = paths.follow(ray.direction, encounter, first).leaving {
                    around.meet(ray_number, &leaving, &mut meetings);
                    ray_number += 1;
                }
            }
        }
        meetings
    })
    .concat();
    let met: std::collections::HashSet<u32> = meetings.iter().map(|meeting| meeting.object).collect();
    let others =
        (0..scene.objects.len() as u32).filter(|object| !met.contains(object) && !group.objects.contains(object));
    let distance = |object: u32| (object, scene.objects[object as usize].bounds.center().distance(group.center()));
    let others: Vec<(u32, f32)> = others.map(distance).collect();
    strata(&meetings, &others, layers, shells)
}

impl Prepared {
    fn draw(
        &self,
        settings: &LayeredEnvironmentMapSettings,
        job: &Job<'_>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let (scene, view, samples) = (job.scene, job.view, job.quality.samples);
        let mut report = Report::default();
        let mut watch = Stopwatch::new();
        let group = |object: u32| self.group_of[object as usize].filter(|_| self.order > 0);
        let paths = |object: u32| {
            let tracer = &self.groups[group(object)? as usize].tracer;
            Some(GreedyPaths { scene, tracer, order: self.order })
        };
        let lenses = |object: u32| Some((paths(object)?, self.maps.get(group(object)? as usize)?));
        let mut lists = vec![raster::scene_draw_list(scene, view, |_| Some(NO_LEAF))];
        let mesh = match settings.transfer {
            Transfer::Exact => AdaptiveMesh::default(),
            Transfer::Adaptive => {
                let (visible, _) = VisibleTriangles::of(scene, view, samples, &lists)?;
                report.stages_ms.push(("visible", watch.lap_ms()));
                let least_cosine = settings.angle_deg.to_radians().cos();
                let criteria = Criteria { tau_px: settings.tau, least_cosine };
                let mesh = refined(scene, view, &self.welds, &paths, criteria, &visible);
                // What is in the mesh is drawn as that alone; other triangles of lenses are not seen, but for rounding.
                lists[0].triangles.retain(|triangle| {
                    paths(scene.triangle_objects[triangle.source as usize]).is_none() || !visible.shows(triangle.source)
                });
                lists.push(draw_list(&mesh, scene));
                report.stages_ms.push(("tessellate_and_trace", watch.lap_ms()));
                mesh
            }
        };
        let ray_count = AtomicU64::new(0);
        let shader = LensShader { scene, rays: view.rays(), lenses: &lenses, mesh: &mesh, ray_count: &ray_count };
        report.add_raster(&raster::draw(view, samples, &lists, &shader, target)?);
        report.counts.insert("mesh_vertices", mesh.points.len() as u64);
        report.counts.insert("mesh_triangles", mesh.leaves.len() as u64);
        report.counts.insert("rays_traced", mesh.ray_count + ray_count.into_inner());
        Ok(report)
    }
}

/// The mesh as triangles to be drawn.
fn draw_list(mesh: &AdaptiveMesh, scene: &Scene) -> DrawList {
    let triangle = |(number, leaf): (usize, &mesh::Leaf)| {
        let object = scene.triangle_objects[leaf.source as usize];
        let alpha_tested = scene.is_alpha_tested(object);
        DrawTriangle { vertices: leaf.vertices, source: leaf.source, group: number as u32, patch: 0, alpha_tested }
    };
    let corners = |leaf: &mesh::Leaf| -> [Vec2; 3] { leaf.corners };
    DrawList {
        vertices: mesh.points.clone(),
        triangles: mesh.leaves.iter().enumerate().map(triangle).collect(),
        corners: mesh.leaves.iter().map(corners).collect(),
        ..DrawList::default()
    }
}
