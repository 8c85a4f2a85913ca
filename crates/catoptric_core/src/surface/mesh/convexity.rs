//! Closed and convex meshes.

use super::adjacency::NO_NEIGHBOUR;
use super::weld::weld_tolerance;
use glam::Vec3;

/// A corner may lie this far above the plane of its neighbour on a convex mesh, as a share of the distance between.
/// Chosen, not measured.
const CONVEX_TOLERANCE: f32 = 1e-3;

/// A mesh with the neighbours of its triangles.
#[derive(Clone, Copy, Debug)]
pub struct MeshShape<'a> {
    /// The vertices' positions.
    pub positions: &'a [Vec3],
    /// The vertices' normals, on the outer side.
    pub normals: &'a [Vec3],
    /// Vertices of each triangle.
    pub triangles: &'a [[u32; 3]],
    /// The triangle across the edge opposite to each corner, see [`super::adjacency::neighbours`].
    pub neighbours: &'a [[u32; 3]],
}

impl MeshShape<'_> {
    /// True if every triangle with an area has all its neighbours, and there is one.
    pub fn is_closed(&self) -> bool {
        self.proper().next().is_some()
            && self.proper().all(|(index, _)| !self.neighbours[index].contains(&NO_NEIGHBOUR))
    }

    /// True if it is closed, hangs together and bulges nowhere inwards: its outer side hides nothing of itself, and no
    /// ray that leaves it comes back.
    pub fn is_convex(&self) -> bool {
        self.is_closed() && self.bulges_outwards() && self.hangs_together()
    }

    /// True if it is closed and its normals point into what it encloses, as in files whose triangles are wound the
    /// other way round.
    pub fn is_inside_out(&self) -> bool {
        if !self.is_closed() {
            return false;
        }
        let from = self.proper().next().map_or(Vec3::ZERO, |(_, [a, ..])| a).as_dvec3();
        let volume = |(index, triangle): (usize, [Vec3; 3])| {
            let [a, b, c] = triangle.map(|corner| corner.as_dvec3() - from);
            let outer: Vec3 = self.triangles[index].iter().map(|vertex| self.normals[*vertex as usize]).sum();
            let volume = a.dot(b.cross(c));
            if (b - a).cross(c - a).dot(outer.as_dvec3()) < 0.0 { -volume } else { volume }
        };
        self.proper().map(volume).sum::<f64>() < 0.0
    }

    /// The triangles that have an area.
    fn proper(&self) -> impl Iterator<Item = (usize, [Vec3; 3])> {
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| self.positions[vertex as usize]);
        let distinct = |[a, b, c]: [Vec3; 3]| a != b && b != c && c != a;
        self.triangles
            .iter()
            .map(corners)
            .enumerate()
            .filter(move |(index, triangle)| distinct(*triangle) && self.neighbours[*index] != [NO_NEIGHBOUR; 3])
    }

    fn bulges_outwards(&self) -> bool {
        // The rounding of positions as they are stored, and as they are welded.
        let rounding = weld_tolerance(self.positions_of_triangles());
        self.proper().all(|(index, [a, b, c])| {
            let outer: Vec3 = self.triangles[index].iter().map(|vertex| self.normals[*vertex as usize]).sum();
            let face = (b - a).cross(c - a).normalize_or_zero();
            let face = if face.dot(outer) < 0.0 { -face } else { face };
            self.neighbours[index].iter().all(|&neighbour| {
                let other = self.triangles[neighbour as usize].map(|vertex| self.positions[vertex as usize]);
                other.iter().all(|corner| (*corner - a).dot(face) <= CONVEX_TOLERANCE * corner.distance(a) + rounding)
            })
        })
    }

    fn positions_of_triangles(&self) -> impl Iterator<Item = Vec3> {
        self.triangles.iter().flatten().map(|vertex| self.positions[*vertex as usize])
    }

    /// True if all triangles that have an area are neighbours of neighbours of one of them; of closed meshes.
    fn hangs_together(&self) -> bool {
        let Some((first, _)) = self.proper().next() else { return false };
        let mut reached = vec![false; self.triangles.len()];
        reached[first] = true;
        let mut waiting = vec![first];
        while let Some(triangle) = waiting.pop() {
            for &neighbour in self.neighbours[triangle].iter().filter(|neighbour| **neighbour != NO_NEIGHBOUR) {
                if !std::mem::replace(&mut reached[neighbour as usize], true) {
                    waiting.push(neighbour as usize);
                }
            }
        }
        // Repeated triangles are nobody's neighbours: what they lie on counts.
        self.proper().all(|(index, _)| {
            reached[index] || self.neighbours[index].iter().all(|neighbour| reached[*neighbour as usize])
        })
    }
}
