//! Radiance from all directions about a point, on the faces of a cube, with mip levels.

use super::{FACES, Probes, locate, texels_across};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::{Projection, View};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec4, Vec4Swizzles};

/// Texels added around each face of the finest level, so that blending across edges has both sides.
const BORDER: u32 = 1;

/// The largest ratio of a footprint's axes that is resolved by several look-ups. A bound on time; chosen, not measured.
const MAX_ANISOTROPY: f32 = 8.0;

/// One face at one resolution; rows from the top, linear radiance and coverage.
#[derive(Clone, Debug)]
struct Face {
    /// Texels a side without the border.
    size: u32,
    /// Texels of border on each side.
    border: u32,
    texels: Vec<[f32; 4]>,
}

/// Radiance from all directions about a point.
///
/// The faces are +x, -x, +y, -y, +z, -z, each with its mip levels; the finest level has a border of one texel.
#[derive(Clone, Debug)]
pub struct CubeMap {
    /// Texels a side of the finest level.
    size: u32,
    /// Face by face, the mip levels from the finest.
    faces: Vec<Vec<Face>>,
}

impl CubeMap {
    /// The view that captures a face: its picture is `size + 2` pixels a side, one of them a border.
    pub fn face_view(face: usize, center: Vec3, size: u32, near: f32) -> View {
        let [right, up, back] = FACES[face];
        let side = size + 2 * BORDER;
        // Without the border exactly 90 degrees are seen.
        let fov_y = 2.0 * (side as f32 / size as f32).arc_tangent();
        View {
            world_from_view: Affine3A { matrix3: Mat3A::from_cols(right, up, back), translation: center.into() },
            projection: Projection::Perspective { fov_y },
            width: side,
            height: side,
            near,
        }
    }

    /// A map from six captured pictures (in the order and size of [`Self::face_view`]).
    pub fn new(size: u32, pictures: Vec<Vec<[f32; 4]>>) -> Self {
        let faces = pictures.into_iter().map(|texels| mip_levels(Face { size, border: BORDER, texels })).collect();
        Self { size, faces }
    }

    /// Texels a side of the finest level, without its border.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Linear radiance and coverage, face by face, of each the levels from the finest, rows from the top.
    pub fn texels(&self) -> impl Iterator<Item = &[f32; 4]> {
        self.faces.iter().flatten().flat_map(|face| &face.texels)
    }

    /// Memory of all texels.
    pub fn byte_count(&self) -> u64 {
        self.faces.iter().flatten().map(|face| face.texels.len() as u64 * 16).sum()
    }

    /// The radiance from a direction of unit length, blurred over a footprint: the changes of the direction from pixel
    /// to pixel. Long footprints take up to eight look-ups along their longer axis.
    pub(crate) fn filtered(&self, direction: Vec3, changes: [Vec3; 2]) -> Vec3 {
        self.filtered_with_coverage(direction, changes).xyz()
    }

    /// As `Self::filtered`; the fourth number is the coverage of the captured pictures, 0 to 1.
    pub fn filtered_with_coverage(&self, direction: Vec3, changes: [Vec3; 2]) -> Vec4 {
        let probes = Probes::of(changes, MAX_ANISOTROPY);
        let radiance = |at| self.radiance(direction + at, probes.spread);
        probes.offsets().map(radiance).sum::<Vec4>() / probes.count as f32
    }

    /// Radiance and coverage from a direction (any length above 0), blurred over `spread` (radians).
    pub fn radiance(&self, direction: Vec3, spread: f32) -> Vec4 {
        let (face, at, secant2) = locate(direction);
        let texels = texels_across(spread, self.size, secant2);
        let levels = &self.faces[face];
        let level = if texels > 1.0 { texels.logarithm2().min((levels.len() - 1) as f32) } else { 0.0 };
        let index = level as usize;
        let fine = levels[index].bilinear(at);
        let blend = level - index as f32;
        if blend <= 0.0 {
            return fine;
        }
        let coarse = levels[(index + 1).min(levels.len() - 1)].bilinear(at);
        fine + (coarse - fine) * blend
    }
}

impl Face {
    fn bilinear(&self, at: Vec2) -> Vec4 {
        let side = (self.size + 2 * self.border) as f32;
        let position = (at + 1.0) * (0.5 * self.size as f32) + self.border as f32 - 0.5;
        let position = position.clamp(Vec2::ZERO, Vec2::splat(side - 1.0));
        let low = position.floor();
        let blend = position - low;
        let (x0, y0) = (low.x as usize, low.y as usize);
        let side = side as usize;
        let (x1, y1) = ((x0 + 1).min(side - 1), (y0 + 1).min(side - 1));
        let texel = |x: usize, y: usize| Vec4::from(self.texels[y * side + x]);
        let upper = texel(x0, y0).lerp(texel(x1, y0), blend.x);
        let lower = texel(x0, y1).lerp(texel(x1, y1), blend.x);
        upper.lerp(lower, blend.y)
    }
}

/// All levels of a face; coarser ones have no border: they are only used blurred.
fn mip_levels(finest: Face) -> Vec<Face> {
    let mut levels = vec![finest];
    while let Some(fine) = levels.last().filter(|face| face.size > 1) {
        let size = fine.size / 2;
        let side = (fine.size + 2 * fine.border) as usize;
        let mut texels = Vec::with_capacity((size * size) as usize);
        for y in 0..size as usize {
            for x in 0..size as usize {
                // Odd sizes drop their last row and column; blurred directions shift by less than a texel.
                let (x, y) = (2 * x + fine.border as usize, 2 * y + fine.border as usize);
                let mut sum = [0.0f32; 4];
                for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let texel = fine.texels[(y + dy) * side + x + dx];
                    sum.iter_mut().zip(texel).for_each(|(sum, value)| *sum += 0.25 * value);
                }
                texels.push(sum);
            }
        }
        levels.push(Face { size, border: 0, texels });
    }
    levels
}
