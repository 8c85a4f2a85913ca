//! The cells of an explosion map: triangles of the reflector that show the side that is met, cut where it turns away,
//! and extended beyond.

use super::chart::CellCorner;
use crate::methods::projection::virtual_objects::{CORNERS, Reflector, interpolated};
use crate::surface::site::NO_NEIGHBOUR;
use glam::{Vec2, Vec3};

/// A border of an open reflector is extended by this share of its radius.
const BORDER_SHARE: f32 = 0.05;

/// A corner with the ray that leaves there.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayCorner {
    pub(super) corner: CellCorner,
    pub(super) outgoing: Vec3,
    /// Beyond a silhouette: its ray hits spheres further out.
    pub(super) outward: bool,
}

/// A triangle of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) corners: [RayCorner; 3],
    /// The triangle of the reflector's mesh.
    pub(super) triangle: u32,
    pub(super) beyond: bool,
}

/// All cells of a reflector.
pub(super) fn cells_of(reflector: &Reflector<'_>) -> Vec<Cell> {
    let (mesh, rays) = (reflector.mesh, reflector.rays);
    let mut cells = Vec::with_capacity(mesh.triangles.len());
    for (index, &triangle) in mesh.triangles.iter().enumerate() {
        if !rays.shows(triangle) {
            continue;
        }
        let maker = Maker { reflector, triangle, index: index as u32 };
        let cosines = triangle.map(|vertex| rays.cosines[vertex as usize]);
        let whole = cosines.iter().all(|cosine| *cosine > 0.0);
        if whole {
            maker.push(&mut cells, [0, 1, 2].map(|k: usize| maker.vertex(k)), false);
        } else {
            maker.cut(&mut cells, cosines);
        }
        for side in 0..3 {
            let (a, b) = ((side + 1) % 3, (side + 2) % 3);
            if mesh.neighbours[index][side] == NO_NEIGHBOUR && cosines[a] > 0.0 && cosines[b] > 0.0 {
                maker.extend(&mut cells, a, b, side);
            }
        }
    }
    cells
}

/// Makes the cells of one triangle.
struct Maker<'a> {
    reflector: &'a Reflector<'a>,
    triangle: [u32; 3],
    index: u32,
}

impl Maker<'_> {
    fn push(&self, cells: &mut Vec<Cell>, corners: [RayCorner; 3], beyond: bool) {
        if corners.iter().all(|corner| corner.outgoing.is_finite()) {
            cells.push(Cell { corners, triangle: self.index, beyond });
        }
    }

    fn vertex(&self, k: usize) -> RayCorner {
        let (mesh, rays) = (self.reflector.mesh, self.reflector.rays);
        let vertex = self.triangle[k] as usize;
        let (position, normal) = (mesh.positions[vertex], mesh.normals[vertex] * rays.side);
        let corner = CellCorner { position, normal };
        RayCorner { corner, outgoing: rays.outgoing[vertex], outward: false }
    }

    /// A place of the triangle's plane, by its weights; the ray arrives there as between those at the corners.
    fn place(&self, weights: Vec2) -> RayCorner {
        let (mesh, rays) = (self.reflector.mesh, self.reflector.rays);
        let mix = |values: &[Vec3]| interpolated(values, self.triangle, weights);
        let position = mix(&mesh.positions);
        let normal = mix(&mesh.normals).normalize_or_zero() * rays.side;
        // From the eye all rays come from one point.
        let incoming = match self.reflector.view {
            Some(_) => position - mix(&rays.origins),
            None => mix(&rays.incoming),
        };
        let incoming = incoming.normalize_or_zero();
        let corner = CellCorner { position, normal };
        RayCorner { corner, outgoing: rays.scattered(incoming, normal), outward: false }
    }

    /// The part of a profile triangle that is seen, and what extends it beyond the silhouette.
    fn cut(&self, cells: &mut Vec<Cell>, cosines: [f32; 3]) {
        let mut polygon: [Option<RayCorner>; 4] = [None; 4];
        let mut count = 0;
        let mut silhouette: [Option<RayCorner>; 2] = [None; 2];
        for k in 0..3 {
            let next = (k + 1) % 3;
            if cosines[k] > 0.0 {
                polygon[count] = Some(self.vertex(k));
                count += 1;
            }
            if (cosines[k] > 0.0) != (cosines[next] > 0.0) {
                // From the seen end, so that both triangles of an edge find the same place.
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
                    self.push(cells, [a, second, third], false);
                }
            }
        }
        if let [Some(a), Some(b)] = silhouette {
            let [a_out, b_out] = [a, b].map(|corner| RayCorner { outward: true, ..corner });
            self.push(cells, [a, b, b_out], true);
            self.push(cells, [a, b_out, a_out], true);
        }
    }

    /// What goes on beyond the border between two corners; `opposite` is the third.
    fn extend(&self, cells: &mut Vec<Cell>, a: usize, b: usize, opposite: usize) {
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
        let foot = CORNERS[a].lerp(CORNERS[b], share);
        let out = (foot - CORNERS[opposite]) * by;
        let [a, b] = [CORNERS[a], CORNERS[b]];
        let [near_a, near_b, far_a, far_b] = [a, b, a + out, b + out].map(|weights| self.place(weights));
        self.push(cells, [near_a, near_b, far_b], true);
        self.push(cells, [near_a, far_b, far_a], true);
    }
}
