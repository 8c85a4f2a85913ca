//! Reflectors as meshes of vertices with normals, for virtual objects: formulas and meshes alike.

mod extrusion;
pub(crate) mod facets;

pub(crate) use extrusion::Extrusion;

use super::piece::CORNERS;
use catoptric_core::scene::{Role, Scene};
use catoptric_core::surface::mesh::adjacency::{NO_NEIGHBOUR, neighbours};
use catoptric_core::surface::mesh::convexity::MeshShape;
use catoptric_core::surface::mesh::weld::WeldedVertices;
use catoptric_engine::optics::path::manifold::{ManifoldVertex, welded_vertices};
use facets::normal_errors;
use glam::{DVec3, Vec2, Vec3};
use rustc_hash::FxHashSet;
use std::collections::{HashMap, HashSet};

/// The ball about a reflector is this much larger than it. Chosen, not measured.
const HOLDING: f32 = 1.01;

/// Meshes of more smooth pieces than this are taken for one. A bound on memory; chosen, not measured.
const MAX_PIECES: u32 = 16;

/// Meshes smaller than this many steps between neighbouring numbers has no shape. Chosen, not measured.
const SHAPELESS: f32 = 64.0;

/// Edges are halved at most this often. A bound on memory; chosen, not measured.
const MAX_HALVINGS: u32 = 10;

/// Meshes of more triangles are not divided: maps of each triangle take kilobytes.
const MOST_HALVED: usize = 32_000;

/// A reflector or lens.
#[derive(Clone, Debug)]
pub struct ReflectorMesh {
    pub(crate) object: u32,
    /// Places of the vertices.
    pub positions: Vec<Vec3>,
    /// Unit normals on the outer side.
    pub normals: Vec<Vec3>,
    /// Vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The part of a triangle of the scene that each triangle covers.
    sources: Vec<TrianglePart>,
    /// Across the edge opposite to each corner; [`NO_NEIGHBOUR`] at borders and creases.
    pub neighbours: Vec<[u32; 3]>,
    /// Largest angle between the normals interpolated in each triangle and the surface's, in radians.
    pub(super) normal_errors: Vec<f32>,
    /// Smooth piece of each triangle.
    pub pieces: Vec<u8>,
    /// The number of pieces.
    pub piece_count: u32,
    /// True if it has no border.
    pub closed: bool,
    /// True if it is a closed mirror whose normals point inwards: its side that is seen from without is the inner one
    /// by these.
    pub(crate) inside_out: bool,
    /// True if it is closed, of one piece, and bulges nowhere inwards: its outer side hides nothing of itself.
    pub convex: bool,
    /// True if it reflects on its inner side alone.
    pub(crate) inside_only: bool,
    /// The profile, if the mesh is a linear extrusion.
    pub extrusion: Option<Extrusion>,
    /// The centre of the box around it.
    pub center: Vec3,
    /// The greatest distance of a vertex from the centre.
    pub radius: f32,
}

/// A part of a triangle of the scene: the weights of that one's second and third vertex at the corners.
#[derive(Clone, Copy, Debug)]
struct TrianglePart {
    triangle: u32,
    corners: [Vec2; 3],
}

impl TrianglePart {
    /// The part between three places, given by weights within this part.
    fn part(&self, places: [Vec2; 3]) -> Self {
        Self { triangle: self.triangle, corners: places.map(|place| self.place(place)) }
    }

    fn place(&self, weights: Vec2) -> Vec2 {
        let [a, b, c] = self.corners;
        a + (b - a) * weights.x + (c - a) * weights.y
    }
}

impl ReflectorMesh {
    /// The mesh of an object of a scene; of analytic surfaces their tessellation. Edges longer than `longest_edge`, a
    /// share of the reflector's radius, are halved.
    pub fn new(scene: &Scene, index: u32, longest_edge: f32) -> Self {
        let object = &scene.objects[index as usize];
        let WeldedVertices { numbers: groups, firsts } =
            welded_vertices(scene, object.triangles.clone(), object.vertices.clone());
        let first = |vertex: &u32| (object.vertices.start + vertex) as usize;
        let positions: Vec<Vec3> = firsts.iter().map(|vertex| scene.positions[first(vertex)]).collect();
        let normals = firsts.iter().map(|vertex| scene.normals[first(vertex)].normalize_or_zero()).collect();
        let group_of = |vertex: u32| groups[(vertex - object.vertices.start) as usize];
        let own = &scene.triangles[object.triangles.start as usize..object.triangles.end as usize];
        // Repeated triangles show nothing that the first does not, and collapsed ones nothing at all.
        let mut taken = FxHashSet::default();
        let is_new = |triangle: &[u32; 3]| {
            let mut corners = *triangle;
            corners.sort_unstable();
            corners[0] != corners[1] && corners[1] != corners[2] && taken.insert(corners)
        };
        let welded = own.iter().map(|triangle| triangle.map(group_of)).zip(object.triangles.clone());
        let (triangles, sources) = {
            let mut is_new = is_new;
            let whole = |triangle| TrianglePart { triangle, corners: CORNERS };
            welded.filter(|(triangle, _)| is_new(triangle)).map(|(corners, source)| (corners, whole(source))).unzip()
        };
        let center = object.bounds.center();
        let radius = positions.iter().map(|position| position.distance(center)).fold(0.0, f32::max);
        let mut mesh = Self {
            object: index,
            positions,
            normals,
            triangles,
            sources,
            neighbours: Vec::new(),
            normal_errors: Vec::new(),
            pieces: Vec::new(),
            piece_count: 1,
            closed: false,
            inside_out: false,
            convex: false,
            inside_only: object.inside,
            extrusion: None,
            center,
            radius,
        };
        mesh.halve_edges(longest_edge * radius);
        mesh.neighbours = neighbours(&mesh.triangles, |vertex| vertex);
        mesh.normal_errors = normal_errors(mesh.shape());
        mesh.closed = mesh.shape().is_closed();
        mesh.inside_out = scene.role_of(index) == Role::Reflector && mesh.shape().is_inside_out();
        mesh.extrusion = Extrusion::new(mesh.shape(), (mesh.center, mesh.radius));
        (mesh.pieces, mesh.piece_count) = mesh.divided_at_creases();
        mesh.convex = mesh.shape().is_convex();
        mesh
    }

    /// Halves edges until none is longer than `longest`, or there are very many triangles.
    fn halve_edges(&mut self, longest: f32) {
        for _ in 0..MAX_HALVINGS {
            let before = self.triangles.len();
            if before > MOST_HALVED {
                break;
            }
            self.halve_once(|mesh, [a, b]| mesh.positions[a as usize].distance(mesh.positions[b as usize]) > longest);
            if self.triangles.len() == before {
                break;
            }
        }
    }

    /// This mesh with some edges, given by their vertices in order, halved.
    pub fn with_halved(&self, edges: &HashSet<[u32; 2]>) -> Self {
        let mut finer = Self { extrusion: None, ..self.clone() };
        finer.halve_once(|_, edge| edges.contains(&edge));
        finer.neighbours = neighbours(&finer.triangles, |vertex| vertex);
        finer.normal_errors = normal_errors(finer.shape());
        (finer.pieces, finer.piece_count) = finer.divided_at_creases();
        finer
    }

    /// Halves the edges for which `is_long` holds, given by their vertices in order. Every edge decides for itself, so
    /// no crack opens.
    fn halve_once(&mut self, is_long: impl Fn(&Self, [u32; 2]) -> bool) {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let (triangles, sources) = (std::mem::take(&mut self.triangles), std::mem::take(&mut self.sources));
        for (triangle, source) in triangles.into_iter().zip(sources) {
            let side = |k: usize| [triangle[(k + 1) % 3], triangle[(k + 2) % 3]];
            let long = [0, 1, 2].map(|k| {
                let [p, q] = side(k);
                is_long(self, [p.min(q), p.max(q)])
            });
            let count = long.iter().filter(|long| **long).count();
            if count == 0 {
                self.triangles.push(triangle);
                self.sources.push(source);
                continue;
            }
            // Turned so that long sides come first, seen from the first corner's opposite side on.
            let first = match count {
                1 => (0..3).find(|k| long[*k]).unwrap_or(0),
                2 => (0..3).find(|k| !long[(*k + 2) % 3]).unwrap_or(0),
                _ => 0,
            };
            let [a, b, c] = [0, 1, 2].map(|k| ((first + k) % 3, CORNERS[(first + k) % 3]));
            let mut middle = |k: usize| {
                let [p, q] = side(k);
                let vertex = *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                    let [p, q] = [p.min(q) as usize, p.max(q) as usize];
                    self.positions.push((self.positions[p] + self.positions[q]) * 0.5);
                    self.normals.push((self.normals[p] + self.normals[q]).normalize_or_zero());
                    self.positions.len() as u32 - 1
                });
                (vertex, (CORNERS[(k + 1) % 3] + CORNERS[(k + 2) % 3]) * 0.5)
            };
            let opposite_a = middle(a.0);
            let [a, b, c] = [a, b, c].map(|(k, place)| (k, (triangle[k], place)));
            let parts: Vec<[(u32, Vec2); 3]> = match count {
                1 => vec![[a.1, b.1, opposite_a], [a.1, opposite_a, c.1]],
                2 => {
                    let opposite_b = middle(b.0);
                    vec![[c.1, opposite_b, opposite_a], [opposite_b, a.1, b.1], [opposite_b, b.1, opposite_a]]
                }
                _ => {
                    let [opposite_b, opposite_c] = [middle(b.0), middle(c.0)];
                    vec![
                        [a.1, opposite_c, opposite_b],
                        [b.1, opposite_a, opposite_c],
                        [c.1, opposite_b, opposite_a],
                        [opposite_a, opposite_b, opposite_c],
                    ]
                }
            };
            for part in parts {
                self.triangles.push(part.map(|corner| corner.0));
                self.sources.push(source.part(part.map(|corner| corner.1)));
            }
        }
    }

    /// The site of the scene's mesh at a place of a triangle; weights outside it are held at its border.
    pub(super) fn site(&self, triangle: u32, weights: Vec2) -> ManifoldVertex {
        let shares = [1.0 - weights.x - weights.y, weights.x, weights.y].map(|share| share.max(0.0));
        let sum: f32 = shares.iter().sum();
        let [first, second, third] = shares.map(|share| f64::from(share / sum));
        let [a, b, c] = self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize].as_dvec3());
        let position: DVec3 = a * first + b * second + c * third;
        let source = &self.sources[triangle as usize];
        let place = source.place(Vec2::new(second as f32, third as f32));
        ManifoldVertex { position, triangle: source.triangle, barycentrics: place.to_array().map(f64::from) }
    }

    /// True if it has a shape: one no larger than the rounding of its positions has none, and nothing is seen in it.
    pub(super) fn has_shape(&self) -> bool {
        self.radius > SHAPELESS * f32::EPSILON * self.center.abs().max_element()
    }

    /// True if a point lies in the ball about the reflector.
    pub(super) fn may_hold(&self, point: Vec3) -> bool {
        point.distance(self.center) <= HOLDING * self.radius
    }

    /// The triangles that have an area.
    fn proper(&self) -> impl Iterator<Item = (usize, [u32; 3])> {
        let distinct = |[a, b, c]: [u32; 3]| a != b && b != c && c != a;
        self.triangles.iter().copied().enumerate().filter(move |(_, triangle)| distinct(*triangle))
    }

    /// The mesh alone.
    pub fn shape(&self) -> MeshShape<'_> {
        let Self { positions, normals, triangles, neighbours, .. } = self;
        MeshShape { positions, normals, triangles, neighbours }
    }

    /// The smooth pieces, between borders and creases, that triangles belong to, and how many there are. All are 0
    /// where there are more than [`MAX_PIECES`].
    fn divided_at_creases(&self) -> (Vec<u8>, u32) {
        const UNKNOWN: u8 = u8::MAX;
        let mut pieces = vec![UNKNOWN; self.triangles.len()];
        let mut count = 0;
        let mut waiting = Vec::new();
        for (first, _) in self.proper() {
            if pieces[first] != UNKNOWN {
                continue;
            }
            if count == MAX_PIECES {
                return (vec![0; self.triangles.len()], 1);
            }
            let piece = count as u8;
            count += 1;
            pieces[first] = piece;
            waiting.push(first);
            while let Some(triangle) = waiting.pop() {
                for &neighbour in &self.neighbours[triangle] {
                    if neighbour != NO_NEIGHBOUR && pieces[neighbour as usize] == UNKNOWN {
                        pieces[neighbour as usize] = piece;
                        waiting.push(neighbour as usize);
                    }
                }
            }
        }
        // Triangles without an area, which nothing is seen in.
        pieces.iter_mut().filter(|piece| **piece == UNKNOWN).for_each(|piece| *piece = 0);
        (pieces, count.max(1))
    }
}
