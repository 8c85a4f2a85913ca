//! Triangles on any implicit surface within a box, by marching tetrahedra (Doi and Koide 1991): every cell of a grid is
//! cut into six tetrahedra, in which the signs at the corners determine the surface's facets.
//!
//! Vertices are roots along the edges of the tetrahedra, so those at the surface's ends lie on the box's faces exactly.
//! Roots near a corner of the grid are joined to one vertex, which takes the slivers away.

use super::mesh::{SurfaceMesh, cells};
use crate::math::roots::bracketed_root;
use crate::parallel;
use glam::{DVec3, Vec2};
use std::collections::HashMap;

/// Cells along the longest side of the box.
const CELLS: u32 = 96;

/// Roots nearer to a corner than this share of an edge are joined there.
const JOINING: f64 = 0.15;

/// A grid over a box, and the function at its points.
struct Grid {
    corners: [DVec3; 2],
    cells: [u32; 3],
    values: Vec<f64>,
}

impl Grid {
    fn index(&self, at: [u32; 3]) -> usize {
        let [nx, ny, _] = self.cells.map(|count| count as usize + 1);
        (at[2] as usize * ny + at[1] as usize) * nx + at[0] as usize
    }

    fn point(&self, at: [u32; 3]) -> DVec3 {
        let [min, max] = self.corners;
        // The box's own numbers at its faces.
        let along = |axis: usize| match at[axis] {
            step if step == self.cells[axis] => max[axis],
            step => min[axis] + (max[axis] - min[axis]) * (step as f64 / self.cells[axis] as f64),
        };
        DVec3::new(along(0), along(1), along(2))
    }

    /// Returns true if a point of the grid lies on no face of the box.
    fn is_inside(&self, at: [u32; 3]) -> bool {
        (0..3).all(|axis| at[axis] > 0 && at[axis] < self.cells[axis])
    }
}

/// A vertex belongs to a point of the grid (direction 0) or to an edge from it, whose direction has one bit an axis.
type VertexKey = (usize, u8);

/// A function to be polygonised at its zeros.
pub(in super::super) trait Field: Sync {
    /// The value at a point.
    fn value(&self, point: DVec3) -> f64;

    /// The value at a point and its change along a direction.
    fn value_and_slope(&self, point: DVec3, direction: DVec3) -> (f64, f64);

    /// The gradient at a point.
    fn gradient(&self, point: DVec3) -> DVec3;
}

/// Triangles on the zeros of a function; points at which it is not finite have no surface.
///
/// Features smaller than a cell (of the finest mesh a 96th of the box's longest side) can be missed.
pub(in super::super) fn polygonise(corners: [DVec3; 2], fineness: f64, field: &impl Field) -> SurfaceMesh {
    let size = corners[1] - corners[0];
    let most = cells(CELLS, fineness);
    let cells =
        size.to_array().map(|extent| ((most as f64 * extent / size.max_element()).ceil() as u32).clamp(4, most));
    let mut grid = Grid { corners, cells, values: Vec::new() };
    let layer = (cells[0] as usize + 1) * (cells[1] as usize + 1);
    let mut values = vec![0.0; layer * (cells[2] as usize + 1)];
    parallel::for_each_chunk_mut(&mut values, layer, |z, values| {
        for (index, number) in values.iter_mut().enumerate() {
            let (x, y) = (index % (cells[0] as usize + 1), index / (cells[0] as usize + 1));
            *number = field.value(grid.point([x as u32, y as u32, z as u32]));
        }
    });
    grid.values = values;
    let mut builder = Polygoniser {
        grid: &grid,
        field,
        vertices: HashMap::new(),
        points: HashMap::new(),
        mesh: SurfaceMesh::default(),
    };
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                builder.add_cell([x, y, z]);
            }
        }
    }
    let mut mesh = builder.mesh;
    cancel_doubles(&mut mesh);
    flip_slivers(&mut mesh);
    mesh
}

/// The orders in which a tetrahedron of a cell goes along the axes from the first corner to the last, each with
/// whether its four corners are positively oriented (an even order of the axes).
const ORDERS: [([u8; 3], bool); 6] = [
    ([1, 2, 4], true),
    ([2, 4, 1], true),
    ([4, 1, 2], true),
    ([2, 1, 4], false),
    ([1, 4, 2], false),
    ([4, 2, 1], false),
];

/// A point of an edge; coordinates that both ends share are kept exactly.
fn between(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    if share == 1.0 { to } else { from + (to - from) * share }
}

struct Polygoniser<'a, F> {
    grid: &'a Grid,
    field: &'a F,
    vertices: HashMap<VertexKey, u32>,
    /// Vertices by the bits of their positions: no two are the same point.
    points: HashMap<[u32; 3], u32>,
    mesh: SurfaceMesh,
}

impl<F: Field> Polygoniser<'_, F> {
    fn add_cell(&mut self, cell: [u32; 3]) {
        let corner = |bits: u8| [0, 1, 2].map(|axis| cell[axis] + u32::from(bits >> axis & 1));
        let values: [f64; 8] = std::array::from_fn(|bits| self.grid.values[self.grid.index(corner(bits as u8))]);
        let inside = values.iter().filter(|value| **value < 0.0).count();
        if inside == 0 || inside == 8 {
            return;
        }
        for ([a, b, _], even) in ORDERS {
            let mut bits = [0, a, a | b, 7];
            if !even {
                bits.swap(0, 1);
            }
            if bits.iter().all(|bits| values[*bits as usize].is_finite()) {
                self.add_tetrahedron(corner, bits, bits.map(|bits| values[bits as usize] < 0.0));
            }
        }
    }

    /// The triangles in a positively oriented tetrahedron: its corners are ordered such that the inner ones come first,
    /// by swaps in pairs that keep the orientation.
    fn add_tetrahedron(&mut self, corner: impl Fn(u8) -> [u32; 3], mut bits: [u8; 4], mut inner: [bool; 4]) {
        let count = inner.iter().filter(|inner| **inner).count();
        if count == 0 || count == 4 {
            return;
        }
        let mut odd = false;
        for place in 0..count {
            if let Some(from) = (place..4).find(|from| inner[*from]).filter(|from| *from != place) {
                bits.swap(place, from);
                inner.swap(place, from);
                odd = !odd;
            }
        }
        if odd {
            // Among three of one side the order does not matter; with two and two, neither does it within a pair.
            if count == 1 { bits.swap(2, 3) } else { bits.swap(0, 1) }
        }
        let mut cut = |a: usize, b: usize| self.vertex(corner(bits[a]), corner(bits[b]), bits[a], bits[b]);
        match count {
            1 => {
                let triangle = [cut(0, 1), cut(0, 2), cut(0, 3)];
                self.mesh.push_triangle(triangle);
            }
            2 => {
                let [a, b, c, d] = [cut(0, 2), cut(0, 3), cut(1, 3), cut(1, 2)];
                let at = |vertex: u32| self.mesh.positions[vertex as usize];
                // The shorter diagonal.
                if at(a).distance_squared(at(c)) <= at(b).distance_squared(at(d)) {
                    self.mesh.push_triangle([a, b, c]);
                    self.mesh.push_triangle([a, c, d]);
                } else {
                    self.mesh.push_triangle([a, b, d]);
                    self.mesh.push_triangle([b, c, d]);
                }
            }
            _ => {
                // The outer corner is the last: from its side the inner three turn the other way.
                let triangle = [cut(0, 3), cut(1, 3), cut(2, 3)];
                self.mesh.push_triangle(triangle);
            }
        }
    }

    /// The vertex on the edge between two points of the grid, whose signs differ.
    fn vertex(&mut self, a: [u32; 3], b: [u32; 3], bits_a: u8, bits_b: u8) -> u32 {
        // From the smaller corner, so that all cells find the same root.
        let (a, b, direction) = if bits_a < bits_b { (a, b, bits_b ^ bits_a) } else { (b, a, bits_b ^ bits_a) };
        let key = (self.grid.index(a), direction);
        if let Some(vertex) = self.vertices.get(&key) {
            return *vertex;
        }
        let (from, to) = (self.grid.point(a), self.grid.point(b));
        let [value, last] = [a, b].map(|at| self.grid.values[self.grid.index(at)]);
        let along = |share: f64| self.field.value_and_slope(between(from, to, share), to - from);
        let share = match (value, last) {
            (0.0, _) => 0.0,
            (_, 0.0) => 1.0,
            _ => bracketed_root(along, 0.0, 1.0, value, value / (value - last)),
        };
        // Joined inside the box alone: at its faces every vertex keeps to its edge, and so to the face.
        let corner = match share {
            share if share < JOINING && self.grid.is_inside(a) => Some(a),
            share if share > 1.0 - JOINING && self.grid.is_inside(b) => Some(b),
            _ => None,
        };
        let joint = corner.map(|corner| (self.grid.index(corner), 0));
        let joined = joint.and_then(|joint| self.vertices.get(&joint).copied());
        let vertex = joined.unwrap_or_else(|| {
            let nearest = corner.and_then(|corner| self.nearest(self.grid.point(corner)));
            self.push_vertex(nearest.unwrap_or_else(|| between(from, to, share)))
        });
        if let Some(joint) = joint {
            self.vertices.insert(joint, vertex);
        }
        self.vertices.insert(key, vertex);
        vertex
    }

    /// The point of the surface nearest to a point of the grid, by Newton's method; returns `None` if it is not near.
    fn nearest(&self, start: DVec3) -> Option<DVec3> {
        let [min, max] = self.grid.corners;
        let size = ((max - min) / DVec3::from(self.grid.cells.map(f64::from))).max_element();
        let mut point = start;
        for _ in 0..8 {
            let (value, gradient) = (self.field.value(point), self.field.gradient(point));
            let step = gradient * (value / gradient.length_squared());
            point -= step;
            // Joined roots lie on diagonals, too.
            if !point.is_finite() || (point - start).length() >= 2.0 * JOINING * size {
                return None;
            }
            // Steps shrink quadratically: the next one would be lost in rounding.
            if step.length() < 1e-7 * size {
                return Some(point);
            }
        }
        None
    }

    fn push_vertex(&mut self, position: DVec3) -> u32 {
        let single = position.as_vec3();
        // Adding zero makes the two zeros one.
        let bits = single.to_array().map(|x| (x + 0.0).to_bits());
        if let Some(vertex) = self.points.get(&bits) {
            return *vertex;
        }
        self.points.insert(bits, self.mesh.positions.len() as u32);
        let gradient = self.field.gradient(position);
        let [min, max] = self.grid.corners;
        let share = (position - min) / (max - min);
        self.mesh.positions.push(single);
        self.mesh.normals.push(gradient.normalize_or(DVec3::Y).as_vec3());
        self.mesh.uvs.push(Vec2::new(share.x as f32, share.z as f32));
        (self.mesh.positions.len() - 1) as u32
    }
}

/// Takes out pairs of triangles of the same vertices that turn opposite ways: joining roots leaves them where
/// it flattens a tetrahedron. Their neighbours meet without them.
fn cancel_doubles(mesh: &mut SurfaceMesh) {
    let mut by_corners: HashMap<[u32; 3], usize> = HashMap::with_capacity(mesh.triangles.len());
    let mut is_cancelled = vec![false; mesh.triangles.len()];
    // Turned so that the smallest vertex is first: the order of the other two gives its orientation.
    let turned = |[a, b, c]: [u32; 3]| match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    };
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = turned(*triangle);
        match by_corners.remove(&[a, c, b]) {
            Some(other) => (is_cancelled[index], is_cancelled[other]) = (true, true),
            None => {
                by_corners.insert([a, b, c], index);
            }
        }
    }
    let mut cancelled = is_cancelled.into_iter();
    mesh.triangles.retain(|_| !cancelled.next().unwrap_or(false));
}

/// Triangles that face their normals less than this (a cosine) are slivers, or folded over.
const MIN_FACING: f64 = 0.5;

/// Turns the longest edge of slivers over, where the two triangles beside it face their normals better afterwards.
///
/// If a vertex lies nearly on the line between two others, the triangle of the three stands upright on the surface.
fn flip_slivers(mesh: &mut SurfaceMesh) {
    let facing = |mesh: &SurfaceMesh, triangle: [u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
        let normal: DVec3 = triangle.iter().map(|vertex| mesh.normals[*vertex as usize].as_dvec3()).sum();
        (b - a).cross(c - a).normalize_or_zero().dot(normal.normalize_or_zero())
    };
    let mut owners: HashMap<(u32, u32), usize> = HashMap::with_capacity(3 * mesh.triangles.len());
    let own = |owners: &mut HashMap<(u32, u32), usize>, [a, b, c]: [u32; 3], index: usize| {
        owners.extend([((a, b), index), ((b, c), index), ((c, a), index)]);
    };
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        own(&mut owners, *triangle, index);
    }
    for index in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.triangles[index];
        let before = facing(mesh, [a, b, c]);
        if before >= MIN_FACING {
            continue;
        }
        let length = |from: u32, to: u32| mesh.positions[from as usize].distance_squared(mesh.positions[to as usize]);
        let turns = [[a, b, c], [b, c, a], [c, a, b]];
        let Some([a, b, c]) = turns.into_iter().max_by(|p, q| length(p[0], p[1]).total_cmp(&length(q[0], q[1]))) else {
            continue;
        };
        let Some(&other) = owners.get(&(b, a)) else { continue };
        let Some(&d) = mesh.triangles[other].iter().find(|vertex| **vertex != a && **vertex != b) else { continue };
        let flipped = [[a, d, c], [d, b, c]];
        let after = flipped.map(|triangle| facing(mesh, triangle)).into_iter().fold(f64::INFINITY, f64::min);
        // An edge that is there already must not come twice.
        if after <= before.min(facing(mesh, [b, a, d])).max(0.0)
            || owners.contains_key(&(c, d))
            || owners.contains_key(&(d, c))
        {
            continue;
        }
        owners.remove(&(a, b));
        owners.remove(&(b, a));
        for (triangle, index) in flipped.into_iter().zip([index, other]) {
            mesh.triangles[index] = triangle;
            own(&mut owners, triangle, index);
        }
    }
}
