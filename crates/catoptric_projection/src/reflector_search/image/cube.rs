//! The six faces of a cube around a reflector.

use crate::find::virtual_objects::{CORNERS, NOTHING, ReflectorMesh, in_front};
use catoptric_engine::light::cube_map::{FACES, direction_of, place_on_face};
use catoptric_engine::raster::id_map::covered_shares;
use glam::{Vec2, Vec3};

/// Faces reach this many texels over their edges, so that every place lies amid texels of its own face.
const OVERLAP: u32 = 2;

/// Triangles are cut where they are nearer to a face's own plane through the centre than this share of the radius.
/// Chosen, not measured.
const NEAR_SHARE: f32 = 1e-5;

/// A place in a picture: a face, and coordinates that are whole at the centres of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImagePlace {
    /// The face.
    pub face: u32,
    /// The coordinates.
    pub at: Vec2,
}

/// The mapping between directions from a centre and places of a cube's six faces.
#[derive(Clone, Copy, Debug)]
pub struct CubeFaces {
    center: Vec3,
    /// Texels a side without the overlap.
    size: u32,
}

/// A corner of a clipped triangle: its place on a face as a direction, and its weights.
type CubeCorner = (Vec3, Vec2);

impl CubeFaces {
    /// Six faces of so many texels a side about a centre.
    pub fn new(center: Vec3, size: u32) -> Self {
        Self { center, size }
    }

    /// Texels a side with the overlap.
    pub(in super::super) fn side(&self) -> u32 {
        self.size + 2 * OVERLAP
    }

    /// The place (whole at the centres of texels) of tangents of the angles to a face's axis.
    #[inline]
    fn place_of(&self, tangents: Vec2) -> Vec2 {
        (tangents + 1.0) * (0.5 * self.size as f32) + (OVERLAP as f32 - 0.5)
    }

    /// The place of a direction.
    #[inline]
    pub fn place(&self, direction: Vec3) -> ImagePlace {
        let (face, tangents) = place_on_face(direction.to_array());
        ImagePlace { face, at: self.place_of(tangents.into()) }
    }

    /// The direction of a place, not of unit length.
    #[inline]
    pub fn direction(&self, place: &ImagePlace) -> Vec3 {
        let tangents = (place.at - (OVERLAP as f32 - 0.5)) * (2.0 / self.size as f32) - 1.0;
        direction_of(place.face as usize % 6, tangents)
    }

    /// A place on the face of its layer that it belongs to; six faces are a layer.
    #[inline]
    pub fn settled(&self, place: ImagePlace) -> ImagePlace {
        let (low, high) = (OVERLAP as f32 - 0.5, (OVERLAP + self.size) as f32 - 0.5);
        let own = place.at.x >= low && place.at.y >= low && place.at.x <= high && place.at.y <= high;
        if own {
            return place;
        }
        let moved = self.place(self.direction(&place));
        ImagePlace { face: moved.face + place.face / 6 * 6, ..moved }
    }

    /// Draws a face: the triangles at its texels, and weights.
    pub(in super::super) fn draw(&self, mesh: &ReflectorMesh, face: usize, outermost: bool) -> Vec<(u32, Vec2)> {
        let side = self.side();
        let [right, down, forward] = [FACES[face][0], -FACES[face][1], -FACES[face][2]].map(Vec3::from);
        // Depth values: the reciprocal depth along the face's axis, signed so that the greatest counts.
        let sign = if outermost { -1.0 } else { 1.0 };
        let mut seen = vec![(f32::NEG_INFINITY, NOTHING, Vec2::ZERO); side as usize * side as usize];
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let corners = [0, 1, 2].map(|k| {
                let from = mesh.positions[triangle[k] as usize] - self.center;
                (Vec3::new(right.dot(from), down.dot(from), forward.dot(from)), CORNERS[k])
            });
            let height = |(corner, _): &CubeCorner| corner.z - NEAR_SHARE * mesh.radius;
            in_front(corners, height, mixed, |piece| {
                let places = piece.map(|(corner, _)| self.place_of(corner.truncate() / corner.z) + 0.5);
                covered_shares(places, side, side, |x, y, shares| {
                    // Linear on the face: one over the depth, and weights times it.
                    let nearness: f32 = (0..3).map(|k| shares[k] / piece[k].0.z).sum();
                    let texel = &mut seen[(y * side + x) as usize];
                    if nearness * sign > texel.0 {
                        let weights: Vec2 = (0..3).map(|k| piece[k].1 * (shares[k] / piece[k].0.z)).sum();
                        *texel = (nearness * sign, index as u32, weights / nearness);
                    }
                });
            });
        }
        seen.into_iter().map(|(_, triangle, weights)| (triangle, weights)).collect()
    }
}

/// The corner at a share of the way between two.
fn mixed(here: &CubeCorner, next: &CubeCorner, share: f32) -> CubeCorner {
    (here.0.lerp(next.0, share), here.1.lerp(next.1, share))
}
