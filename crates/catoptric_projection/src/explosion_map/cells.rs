//! The cells of an explosion map: triangles of the reflector that show the side that is met, cut where it turns away,
//! and extended beyond.

use crate::find::virtual_objects::{CORNERS, Reflector, interpolated};
use catoptric_core::surface::mesh::adjacency::NO_NEIGHBOUR;
use glam::{Vec2, Vec3, Vec3A};

/// A border of an open reflector is extended by this share of its radius. Chosen, not measured.
const BORDER_SHARE: f32 = 0.05;

/// A place of the reflector with the ray that leaves there.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayCorner {
    pub(super) position: Vec3A,
    /// The unit normal on the side that is met.
    pub(super) normal: Vec3A,
    pub(super) outgoing: Vec3A,
    /// True for corners beyond a silhouette: their rays hit spheres further out.
    pub(super) outward: bool,
}

/// A triangle of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapCell {
    /// Indices of its corners.
    pub(super) corners: [u32; 3],
    /// The triangle of the reflector's mesh.
    pub(super) triangle: u32,
    pub(super) beyond: bool,
}

/// The cells of a reflector.
#[derive(Clone, Debug, Default)]
pub(super) struct MapCells {
    pub(super) corners: Vec<RayCorner>,
    pub(super) cells: Vec<MapCell>,
}

/// Vertices that are no corner yet.
const NONE: u32 = u32::MAX;

impl MapCells {
    /// The cells of a reflector's rays.
    pub(super) fn new(reflector: &Reflector<'_>) -> Self {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        let mut all = Self { corners: Vec::with_capacity(mesh.positions.len()), cells: Vec::new() };
        all.cells.reserve(mesh.triangles.len());
        let mut corner_of = vec![NONE; mesh.positions.len()];
        for (index, &triangle) in mesh.triangles.iter().enumerate() {
            if !rays.shows(triangle) {
                continue;
            }
            let cosines = triangle.map(|vertex| rays.cosines[vertex as usize]);
            let index = index as u32;
            let mut maker = Maker { reflector, triangle, index, corner_of: &mut corner_of, all: &mut all };
            if cosines.iter().all(|cosine| *cosine > 0.0) {
                let corners = [0, 1, 2].map(|k: usize| maker.vertex(k));
                maker.push(corners, false);
            } else {
                maker.cut(cosines);
            }
            for side in 0..3 {
                let (a, b) = ((side + 1) % 3, (side + 2) % 3);
                let ends = mesh.neighbours[index as usize][side] == NO_NEIGHBOUR;
                if ends && cosines[a] > 0.0 && cosines[b] > 0.0 {
                    maker.extend(a, b, side);
                }
            }
        }
        all
    }
}

/// Makes the cells of one triangle.
struct Maker<'a> {
    reflector: &'a Reflector<'a>,
    triangle: [u32; 3],
    index: u32,
    /// The corner of each vertex.
    corner_of: &'a mut [u32],
    all: &'a mut MapCells,
}

impl Maker<'_> {
    fn push(&mut self, corners: [u32; 3], beyond: bool) {
        if corners.iter().all(|corner| self.all.corners[*corner as usize].outgoing.is_finite()) {
            self.all.cells.push(MapCell { corners, triangle: self.index, beyond });
        }
    }

    fn add(&mut self, corner: RayCorner) -> u32 {
        self.all.corners.push(corner);
        self.all.corners.len() as u32 - 1
    }

    fn vertex(&mut self, k: usize) -> u32 {
        let (mesh, rays) = (self.reflector.mesh, self.reflector.rays);
        let vertex = self.triangle[k] as usize;
        if self.corner_of[vertex] == NONE {
            self.corner_of[vertex] = self.add(RayCorner {
                position: mesh.positions[vertex].into(),
                normal: (mesh.normals[vertex] * rays.side).into(),
                outgoing: rays.outgoing[vertex].into(),
                outward: false,
            });
        }
        self.corner_of[vertex]
    }

    /// A place of the triangle's plane, by its weights; the ray arrives there as between those at the corners.
    fn place(&mut self, weights: Vec2) -> u32 {
        let (mesh, rays) = (self.reflector.mesh, self.reflector.rays);
        let mix = |values: &[Vec3]| interpolated(values, self.triangle, weights);
        let position = mix(&mesh.positions);
        let normal = mix(&mesh.normals).normalize_or_zero() * rays.side;
        // Rays of the eye all come from one point.
        let incoming = match self.reflector.view {
            Some(_) => position - mix(&rays.origins),
            None => mix(&rays.incoming),
        };
        let incoming = incoming.normalize_or_zero();
        let outgoing = rays.scattered(incoming, normal).into();
        self.add(RayCorner { position: position.into(), normal: normal.into(), outgoing, outward: false })
    }

    /// Adds the visible part of a profile triangle, and its extension beyond the silhouette.
    fn cut(&mut self, cosines: [f32; 3]) {
        let mut polygon: [Option<u32>; 4] = [None; 4];
        let mut count = 0;
        let mut silhouette: [Option<u32>; 2] = [None; 2];
        for k in 0..3 {
            let next = (k + 1) % 3;
            if cosines[k] > 0.0 {
                polygon[count] = Some(self.vertex(k));
                count += 1;
            }
            if (cosines[k] > 0.0) != (cosines[next] > 0.0) {
                // The interpolation starts at the seen end, so that both triangles of an edge find the same place.
                let (seen, hidden) = if cosines[k] > 0.0 { (k, next) } else { (next, k) };
                let share = cosines[seen] / (cosines[seen] - cosines[hidden]);
                let place = self.place(CORNERS[seen].lerp(CORNERS[hidden], share));
                polygon[count] = Some(place);
                count += 1;
                silhouette[usize::from(silhouette[0].is_some())] = Some(place);
            }
        }
        if let [Some(a), Some(b), third, fourth] = polygon {
            for (second, third) in [(Some(b), third), (third, fourth)] {
                if let (Some(second), Some(third)) = (second, third) {
                    self.push([a, second, third], false);
                }
            }
        }
        if let [Some(a), Some(b)] = silhouette {
            let [a_out, b_out] = [a, b].map(|corner| {
                let corner = self.all.corners[corner as usize];
                self.add(RayCorner { outward: true, ..corner })
            });
            self.push([a, b, b_out], true);
            self.push([a, b_out, a_out], true);
        }
    }

    /// Extends the cells beyond the border between two corners; `opposite` is the third.
    fn extend(&mut self, a: usize, b: usize, opposite: usize) {
        let mesh = self.reflector.mesh;
        let at = |k: usize| mesh.positions[self.triangle[k] as usize];
        let edge = at(b) - at(a);
        let from = at(opposite) - at(a);
        let share = from.dot(edge) / edge.length_squared();
        let height = (from - edge * share).length();
        let by = BORDER_SHARE * mesh.radius / height;
        if !by.is_finite() {
            return;
        }
        // Straight out, across the edge.
        let reflection_point = CORNERS[a].lerp(CORNERS[b], share);
        let out = (reflection_point - CORNERS[opposite]) * by;
        let [a, b] = [CORNERS[a], CORNERS[b]];
        let [near_a, near_b, far_a, far_b] = [a, b, a + out, b + out].map(|weights| self.place(weights));
        self.push([near_a, near_b, far_b], true);
        self.push([near_a, far_b, far_a], true);
    }
}
