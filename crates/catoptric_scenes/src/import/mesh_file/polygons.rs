//! Division of polygons into triangles.

use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;
use glam::{DVec2, DVec3};

/// Divides polygons into triangles; holds memory that is used again.
#[derive(Default)]
pub(in super::super) struct PolygonDivider {
    ears: Earcut<f64>,
    corners: Vec<[f64; 3]>,
    in_plane: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl PolygonDivider {
    /// The triangles of a polygon, three numbers of its corners each, in the polygon's sense of rotation: a fan where
    /// it is convex, else ears are cut off its projection. Polygons of fewer than three corners have none.
    pub(in super::super) fn divide(&mut self, corners: &[DVec3]) -> &[u32] {
        self.triangles.clear();
        let count = corners.len() as u32;
        if count > 3 && !is_convex(corners) {
            self.corners.clear();
            self.corners.extend(corners.iter().map(|corner| (*corner - corners[0]).to_array()));
            if project3d_to_2d(&self.corners, corners.len(), &mut self.in_plane) {
                self.ears.earcut(self.in_plane.iter().copied(), &[], &mut self.triangles);
            }
            // The projection is seen from the side where the polygon runs counter-clockwise.
            let place = |corner: u32| DVec2::from(self.in_plane[corner as usize]);
            for triangle in self.triangles.chunks_exact_mut(3) {
                let [a, b, c] = [place(triangle[0]), place(triangle[1]), place(triangle[2])];
                if (b - a).perp_dot(c - a) < 0.0 {
                    triangle.swap(1, 2);
                }
            }
        }
        if self.triangles.is_empty() {
            self.triangles.extend((2..count).flat_map(|corner| [0, corner - 1, corner]));
        }
        &self.triangles
    }
}

/// Returns true if a polygon turns to the same side at all corners, seen along its mean normal (Newell's).
fn is_convex(corners: &[DVec3]) -> bool {
    let next = |index: usize| corners[(index + 1) % corners.len()];
    let normal: DVec3 =
        (1..corners.len()).map(|index| (corners[index] - corners[0]).cross(next(index) - corners[0])).sum();
    (0..corners.len()).all(|index| {
        let (here, after, beyond) = (corners[index], next(index), next((index + 1) % corners.len()));
        (after - here).cross(beyond - after).dot(normal) >= 0.0
    })
}
