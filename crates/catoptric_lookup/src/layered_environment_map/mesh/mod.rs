//! The adaptive mesh: reflectors and lenses as triangles that are divided until rays through their corners leave alike
//! (Hakura, Snyder 2001, section 5).

pub(super) mod blend;
pub(super) mod visible;
pub(crate) mod welds;

use crate::layered_environment_map::settings::{Edges, LayeredEnvironmentMapSettings};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress, Stage};
use catoptric_core::scene::shade::Barycentrics;
use catoptric_core::scene::{PicturePoint, PictureTransform, Projection, Ray, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::two_path_tracer::{SpecularChain, TwoPathTracer};
use catoptric_engine::method::Job;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::raster::{self, DrawList, DrawTriangle};
use glam::{Vec2, Vec3};
use rustc_hash::FxHashMap;
use visible::VisibleTriangles;
use welds::Welds;

/// The group of triangles that are no part of the mesh.
pub(crate) const NO_LEAF: u32 = u32::MAX;

/// Divisions of a triangle, one after the other; more are only asked for where it reaches behind the eye. A bound on
/// time; chosen, not measured.
const MAX_LEVELS: u32 = 12;

/// Vertices that a thread traces at once. A size for threads; chosen, not measured.
const VERTICES_AT_ONCE: usize = 128;

/// A triangle of the mesh.
#[derive(Clone, Copy, Debug)]
pub struct PatchLeaf {
    /// Vertices of the mesh.
    pub vertices: [u32; 3],
    /// The triangle of the scene that it is a part of.
    pub source: u32,
    /// Barycentric coordinates of its corners in that triangle.
    pub corners: [Vec2; 3],
    /// Divisions, one after the other, that it comes from.
    pub(crate) level: u32,
}

/// Criteria of refinement.
#[derive(Clone, Copy, Debug)]
pub struct Criteria {
    /// Edges that are no longer than this, in pixels, are not divided.
    pub(crate) tau_px: f32,
    /// Directions are alike whose angle has at least this cosine.
    pub(crate) least_cosine: f32,
    /// The treatment of pixels where paths take different ways.
    pub(crate) edges: Edges,
}

impl Criteria {
    /// Criteria of settings.
    pub fn of(settings: &LayeredEnvironmentMapSettings) -> Self {
        Self { tau_px: settings.tau, least_cosine: settings.angle_deg.to_radians().cosine(), edges: settings.edges }
    }

    /// Returns true for rays with different events or leaving directions.
    pub fn differ(&self, a: &SpecularChain, b: &SpecularChain) -> bool {
        !same_way(a, b)
            || match (&a.leaving, &b.leaving) {
                (Some(a), Some(b)) => a.direction.dot(b.direction) < self.least_cosine,
                _ => false,
            }
    }
}

/// Returns true for paths with the same events and the same kind of end.
pub(crate) fn same_way(a: &SpecularChain, b: &SpecularChain) -> bool {
    let way = |path: &SpecularChain| (path.events, path.refractions, path.divides, path.leaving.is_some());
    way(a) == way(b)
}

/// The mesh of one view.
#[derive(Clone, Debug, Default)]
pub struct AdaptiveMesh {
    /// The place of every vertex in the picture.
    pub points: Vec<PicturePoint>,
    /// Paths of every vertex, by reflection and by refraction.
    pub paths: Vec<[SpecularChain; 2]>,
    /// The parts of patches, which are triangles.
    pub leaves: Vec<PatchLeaf>,
    /// Rays that were traced.
    pub ray_count: u64,
}

/// A vertex before it is traced.
#[derive(Clone, Copy)]
struct Vertex {
    /// A number that all vertices at this place have in common.
    place: u32,
    source: u32,
    at: Vec2,
}

/// The paths among the group of an object, if it is in one.
pub(crate) type PathsOf<'r, 'a> = dyn Fn(u32) -> Option<TwoPathTracer<'a>> + Sync + 'r;

/// Refines the mesh of a view.
struct Refiner<'r, 'a> {
    scene: &'r Scene,
    view: &'r View,
    transform: PictureTransform,
    paths: &'r PathsOf<'r, 'a>,
    criteria: Criteria,
    visible: &'r VisibleTriangles,
    vertices: Vec<Vertex>,
    mesh: AdaptiveMesh,
    /// Vertices between two vertices.
    between: FxHashMap<[u32; 2], u32>,
    /// Places between two places.
    middles: FxHashMap<[u32; 2], u32>,
    places: u32,
}

/// The wanted objects of a scene as lists to be drawn, those that are seen of its reflectors and lenses with paths as
/// the adaptive mesh: then the group of each triangle is that of its leaf, and else `NO_LEAF`.
///
/// # Errors
/// Errors of the rasteriser.
pub fn drawn(
    job: &Job<'_>,
    welds: &Welds,
    paths: &PathsOf<'_, '_>,
    criteria: Criteria,
    is_wanted: impl Fn(u32) -> bool,
) -> Result<(Vec<DrawList>, AdaptiveMesh), RenderError> {
    let Job { scene, view, quality, progress } = *job;
    let list_of = |is_lens: bool| {
        let is_listed = |object: &u32| is_wanted(*object) && paths(*object).is_some() == is_lens;
        raster::scene_draw_list(scene, view, |object| Some(object).filter(is_listed).map(|_| NO_LEAF))
    };
    let mut lists = vec![list_of(false), list_of(true)];
    let visible = VisibleTriangles::of(scene, view, quality.samples, &lists, 1)?;
    let mesh = refined(scene, view, welds, paths, criteria, &visible, progress)?;
    // Triangles in the mesh are drawn by it alone; other triangles of lenses are not visible, but for rounding.
    lists[1].triangles.retain(|triangle| !visible.shows(triangle.source));
    lists.push(mesh.draw_list(scene, criteria.edges));
    Ok((lists, mesh))
}

impl AdaptiveMesh {
    /// Returns true for triangles whose corners' paths have the same events.
    fn is_blended(&self, leaf: &PatchLeaf) -> bool {
        let [a, b, c] = leaf.vertices.map(|vertex| &self.paths[vertex as usize]);
        (0..2).all(|way| same_way(&a[way], &b[way]) && same_way(&b[way], &c[way]))
    }

    /// Draw list of the mesh.
    fn draw_list(&self, scene: &Scene, edges: Edges) -> DrawList {
        let triangle = |(number, leaf): (usize, &PatchLeaf)| {
            let object = scene.triangle_objects[leaf.source as usize];
            let alpha_tested = scene.is_alpha_tested(object);
            // A pixel shades a patch once, whatever the number of triangles in it.
            let patch = if self.is_blended(leaf) || edges != Edges::Traced { object + 1 } else { 0 };
            DrawTriangle { vertices: leaf.vertices, source: leaf.source, group: number as u32, patch, alpha_tested }
        };
        DrawList {
            vertices: self.points.clone(),
            triangles: self.leaves.iter().enumerate().map(triangle).collect(),
            corners: self.leaves.iter().map(|leaf| leaf.corners).collect(),
            ..DrawList::default()
        }
    }
}

/// The mesh of the visible parts of reflectors and lenses with paths.
fn refined(
    scene: &Scene,
    view: &View,
    welds: &Welds,
    paths: &PathsOf<'_, '_>,
    criteria: Criteria,
    visible: &VisibleTriangles,
    progress: &dyn Progress,
) -> Result<AdaptiveMesh, Cancelled> {
    // The number of rounds is not known yet.
    let stage = Stage::begin(progress, "refining the mesh", 0)?;
    let mut refiner = Refiner {
        scene,
        view,
        transform: view.picture_from_world(),
        paths,
        criteria,
        visible,
        vertices: Vec::new(),
        mesh: AdaptiveMesh::default(),
        between: FxHashMap::default(),
        middles: FxHashMap::default(),
        places: 2 * welds.places,
    };
    let mut active = refiner.start(welds);
    // A refined mesh has about four times as many vertices as a rule, and as many divided edges.
    refiner.between.reserve(2 * active.len());
    refiner.middles.reserve(2 * active.len());
    refiner.trace();
    let mut leaves = Vec::new();
    while !active.is_empty() {
        stage.advance(1)?;
        let cuts = parallel::map_collect(active.len(), |index| refiner.cuts(&active[index]));
        let mut next = Vec::new();
        for (leaf, cuts) in active.iter().zip(cuts) {
            match cuts {
                [false, false, false] => leaves.push(*leaf),
                cuts => refiner.divide(leaf, cuts, &mut next),
            }
        }
        refiner.trace();
        active = next;
    }
    // Edges that a neighbour has divided are divided here too. That divides no other edge.
    let cuts = parallel::map_collect(leaves.len(), |index| refiner.divided(&leaves[index]) != [false; 3]);
    let mut cuts = cuts.into_iter();
    refiner.mesh.leaves = leaves.extract_if(.., |_| cuts.next() == Some(false)).collect();
    while let Some(leaf) = leaves.pop() {
        match refiner.divided(&leaf) {
            [false, false, false] => refiner.mesh.leaves.push(leaf),
            cuts => refiner.divide(&leaf, cuts, &mut leaves),
        }
    }
    refiner.trace();
    Ok(refiner.mesh)
}

impl Refiner<'_, '_> {
    /// The triangles that are seen, as they are.
    fn start(&mut self, welds: &Welds) -> Vec<PatchLeaf> {
        let mut known: FxHashMap<u32, u32> = FxHashMap::default();
        let (scene, mut leaves) = (self.scene, Vec::new());
        for (index, object) in scene.objects.iter().enumerate() {
            if (self.paths)(index as u32).is_none() {
                continue;
            }
            for triangle in object.triangles.clone().filter(|triangle| self.visible.shows(*triangle)) {
                let corners = [Vec2::ZERO, Vec2::X, Vec2::Y];
                let side = self.side(triangle);
                let vertices = std::array::from_fn(|corner| {
                    let vertex = scene.triangles[triangle as usize][corner];
                    let weld = welds.of(vertex);
                    *known.entry(2 * weld.vertex + side).or_insert_with(|| {
                        let place = 2 * weld.place + side;
                        self.vertices.push(Vertex { place, source: triangle, at: corners[corner] });
                        self.vertices.len() as u32 - 1
                    })
                });
                leaves.push(PatchLeaf { vertices, source: triangle, corners, level: 0 });
            }
        }
        leaves
    }

    /// 0 where the outer side of a triangle is seen, else 1.
    fn side(&self, triangle: u32) -> u32 {
        let at = Barycentrics { value: Vec2::splat(1.0 / 3.0), ..Barycentrics::default() };
        let point = self.scene.surface_point(triangle, &at);
        u32::from(self.ray_to(point.position).direction.dot(point.geometric_normal) > 0.0)
    }

    /// The ray from the eye to a place.
    fn ray_to(&self, position: Vec3) -> Ray {
        match self.view.projection {
            Projection::Perspective { .. } => {
                let eye = self.view.eye();
                Ray { origin: eye, direction: (position - eye).try_normalize().unwrap_or(Vec3::NEG_Z) }
            }
            Projection::Orthographic { .. } => {
                let direction = -Vec3::from(self.view.world_from_view.matrix3.z_axis);
                Ray { origin: position - direction * (position - self.view.eye()).dot(direction), direction }
            }
        }
    }

    /// Traces all vertices that have no paths yet.
    fn trace(&mut self) {
        let mut mesh = std::mem::take(&mut self.mesh);
        let first = mesh.paths.len();
        mesh.points.resize(self.vertices.len(), PicturePoint::default());
        mesh.paths.resize(self.vertices.len(), Default::default());
        let waiting = &self.vertices[first..];
        parallel::for_each_chunk_mut(&mut mesh.points[first..], VERTICES_AT_ONCE, |number, points| {
            for (point, vertex) in points.iter_mut().zip(&waiting[number * VERTICES_AT_ONCE..]) {
                *point = self.transform.apply(self.scene.position_on(vertex.source, vertex.at));
            }
        });
        parallel::for_each_chunk_mut(&mut mesh.paths[first..], VERTICES_AT_ONCE, |number, paths| {
            for (paths, vertex) in paths.iter_mut().zip(&waiting[number * VERTICES_AT_ONCE..]) {
                *paths = self.traced(vertex);
            }
        });
        mesh.ray_count += mesh.paths[first..].iter().flatten().map(|path| u64::from(path.events)).sum::<u64>();
        self.mesh = mesh;
    }

    /// The paths by reflection and by refraction from a vertex.
    fn traced(&self, vertex: &Vertex) -> [SpecularChain; 2] {
        let scene = self.scene;
        let object = scene.triangle_objects[vertex.source as usize];
        let Some(paths) = (self.paths)(object) else { return Default::default() };
        let ray = self.ray_to(scene.position_on(vertex.source, vertex.at));
        let at = Barycentrics { value: vertex.at, ..Barycentrics::default() };
        let point = scene.drawn_point(vertex.source, &at, &ray);
        let reflected = paths.follow(ray.direction, point, BounceKind::Reflect);
        let refracted = match reflected.divides {
            true => paths.follow(ray.direction, point, BounceKind::Transmit),
            false => SpecularChain::default(),
        };
        [reflected, refracted]
    }

    /// The edges of a triangle that are to be divided, because rays through its corners leave differently and the edges
    /// are long; edge k is from corner k to the next.
    fn cuts(&self, leaf: &PatchLeaf) -> [bool; 3] {
        let [a, b, c] = leaf.vertices.map(|vertex| &self.mesh.paths[vertex as usize]);
        let differ =
            |a: &[SpecularChain; 2], b: &[SpecularChain; 2]| a.iter().zip(b).any(|(a, b)| self.criteria.differ(a, b));
        if leaf.level >= MAX_LEVELS || !(differ(a, b) || differ(b, c) || differ(c, a)) {
            return [false; 3];
        }
        let corners = leaf.vertices.map(|vertex| self.mesh.points[vertex as usize]);
        let long = self.long_edges(corners);
        if long == [false; 3] || !self.visible.shows_part(leaf.source, corners, self.view.near) {
            return [false; 3];
        }
        long
    }

    fn long_edges(&self, corners: [PicturePoint; 3]) -> [bool; 3] {
        std::array::from_fn(|edge| {
            let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
            let near = self.view.near;
            match (a.depth < near, b.depth < near) {
                (true, true) => false,
                (false, false) => (a.xy / a.w).distance(b.xy / b.w) > self.criteria.tau_px,
                _ => true,
            }
        })
    }

    /// The edges that have been divided.
    fn divided(&self, leaf: &PatchLeaf) -> [bool; 3] {
        let places = leaf.vertices.map(|vertex| self.vertices[vertex as usize].place);
        std::array::from_fn(|edge| self.middles.contains_key(&ordered(places[edge], places[(edge + 1) % 3])))
    }

    /// The vertex in the middle of an edge, which may be new.
    fn middle(&mut self, leaf: &PatchLeaf, edge: usize) -> (u32, Vec2) {
        let next = (edge + 1) % 3;
        let [a, b] = [leaf.vertices[edge], leaf.vertices[next]];
        let at = (leaf.corners[edge] + leaf.corners[next]) * 0.5;
        let (vertices, middles, places) = (&mut self.vertices, &mut self.middles, &mut self.places);
        let vertex = *self.between.entry(ordered(a, b)).or_insert_with(|| {
            let ends = ordered(vertices[a as usize].place, vertices[b as usize].place);
            let place = *middles.entry(ends).or_insert_with(|| {
                *places += 1;
                *places - 1
            });
            vertices.push(Vertex { place, source: leaf.source, at });
            vertices.len() as u32 - 1
        });
        (vertex, at)
    }

    /// Appends the parts of a triangle some of whose edges are divided: four, three or two.
    fn divide(&mut self, leaf: &PatchLeaf, cuts: [bool; 3], parts: &mut Vec<PatchLeaf>) {
        let mut put = |corners: [(u32, Vec2); 3]| {
            let (vertices, level) = (corners.map(|(vertex, _)| vertex), leaf.level + 1);
            parts.push(PatchLeaf { vertices, source: leaf.source, corners: corners.map(|(_, at)| at), level });
        };
        let corner = |corner: usize| (leaf.vertices[corner % 3], leaf.corners[corner % 3]);
        match cuts.iter().filter(|cut| **cut).count() {
            3 => {
                let middles: [_; 3] = std::array::from_fn(|edge| self.middle(leaf, edge));
                for edge in 0..3 {
                    put([corner(edge), middles[edge], middles[(edge + 2) % 3]]);
                }
                put(middles);
            }
            2 => {
                // The corner between the divided edges is cut off; the rest has four corners.
                let whole = cuts.iter().position(|cut| !cut).unwrap_or(0);
                let (after, before) = (self.middle(leaf, (whole + 1) % 3), self.middle(leaf, (whole + 2) % 3));
                put([corner(whole + 2), before, after]);
                put([corner(whole), corner(whole + 1), after]);
                put([corner(whole), after, before]);
            }
            1 => {
                let edge = cuts.iter().position(|cut| *cut).unwrap_or(0);
                let middle = self.middle(leaf, edge);
                put([corner(edge), middle, corner(edge + 2)]);
                put([middle, corner(edge + 1), corner(edge + 2)]);
            }
            _ => parts.push(*leaf),
        }
    }
}

fn ordered(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
