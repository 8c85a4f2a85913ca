//! Pictures of a reflector: the surface at each texel, and the texels that lie side by side on it.

pub(crate) mod cube;

use crate::find::virtual_objects::{EyeImage, NOTHING, ReflectorMesh, interpolated};
use catoptric_core::parallel;
use catoptric_core::scene::View;
use cube::CubeFaces;
pub(super) use cube::ImagePlace;
use glam::{Vec2, Vec3};

/// Normals of neighbouring texels further apart than this (a cosine) belong to different surfaces: a crease. Chosen,
/// not measured.
const CREASE: f32 = 0.5;

/// Reflectors with a longer mean normal are about flat. Chosen, not measured.
const FLAT: f32 = 0.95;

/// Neighbouring texels on one surface lie in each other's tangent planes, but for the surface's bend between them and
/// this slope: that of flat triangles against their normals. Chosen, not measured.
const SLOPE: f32 = 0.25;

/// Surface point of a texel; not finite without one.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceTexel {
    pub(super) position: Vec3,
    /// The unit normal on the outer side.
    pub(super) normal: Vec3,
}

/// The place of a texel on the reflector's mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshSpot {
    /// The triangle; [`NOTHING`] where there is none.
    pub(super) triangle: u32,
    /// The weights of its second and third corner.
    pub(super) weights: Vec2,
}

/// A picture of a reflector from the eye, or the six of a cube around it, in one layer or two.
#[derive(Clone, Debug)]
pub struct ReflectorImage {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) face_count: u32,
    /// Face by face, row by row.
    pub(super) texels: Vec<SurfaceTexel>,
    /// The place of every texel; apart from the texels, since the search reads few.
    pub(super) spots: Vec<MeshSpot>,
    /// True if a texel and those to its right, below, and below to the right show one piece of smooth surface.
    joined: Vec<bool>,
    /// The mapping of a cube's faces, for cube maps.
    cube: Option<CubeFaces>,
}

impl ReflectorImage {
    /// Draws the surface nearest to the eye, with about `size` texels along the longer side; returns `None` if nothing
    /// is seen.
    pub fn from_eye(mesh: &ReflectorMesh, view: &View, size: u32) -> Option<Self> {
        let drawn = EyeImage::draw(mesh, view, size)?;
        let shown = drawn.texels.iter().map(|texel| (texel.triangle, texel.weights));
        Some(Self::new(mesh, [drawn.width, drawn.height, 1], shown, None))
    }

    /// The reflector from its centre on six faces of `size` texels a side: its outermost surface, and, if it is not
    /// convex, a second layer of six faces with its innermost one.
    pub fn around(mesh: &ReflectorMesh, size: u32) -> Self {
        let cube = CubeFaces::new(Self::center_of(mesh), size);
        let side = cube.side();
        let face_count = if mesh.convex { 6 } else { 12 };
        let faces = parallel::map_collect(face_count, |face| cube.draw(mesh, face % 6, face < 6));
        Self::new(mesh, [side, side, face_count as u32], faces.into_iter().flatten(), Some(cube))
    }

    /// Triangles and weights, face by face and row by row.
    fn new(
        mesh: &ReflectorMesh,
        [width, height, face_count]: [u32; 3],
        shown: impl Iterator<Item = (u32, Vec2)>,
        cube: Option<CubeFaces>,
    ) -> Self {
        let (texels, spots): (Vec<SurfaceTexel>, Vec<MeshSpot>) =
            shown.map(|(triangle, weights)| texel_of(mesh, triangle, weights)).unzip();
        let mut image = Self { width, height, face_count, texels, spots, joined: Vec::new(), cube };
        image.joined = image.cells(|corners| image.is_smooth(corners));
        image
    }

    /// Asks of every texel whether something is true of it and those to its right, below, and below to the right; it is
    /// not of those along the right and lower sides.
    fn cells(&self, is: impl Fn([usize; 4]) -> bool) -> Vec<bool> {
        let mut all = vec![false; self.texels.len()];
        for face in 0..self.face_count {
            for y in 0..self.height - 1 {
                for x in 0..self.width - 1 {
                    let low = self.index(face, x, y);
                    all[low] = is(self.corners(low));
                }
            }
        }
        all
    }

    /// The cells that show one piece of smooth surface of those triangles that are `shown`.
    pub(super) fn whole_cells(&self, shown: &[bool]) -> Vec<bool> {
        let is_shown = |texel: usize| shown.get(self.spots[texel].triangle as usize).copied().unwrap_or(false);
        self.cells(|corners| self.joined[corners[0]] && corners.into_iter().all(is_shown))
    }

    /// The texels of a cell, row by row.
    #[inline]
    pub(super) fn corners(&self, low: usize) -> [usize; 4] {
        let width = self.width as usize;
        [low, low + 1, low + width, low + width + 1]
    }

    /// The index of a texel; coordinates must lie within the face.
    #[inline]
    pub(super) fn index(&self, face: u32, x: u32, y: u32) -> usize {
        (face as usize * self.height as usize + y as usize) * self.width as usize + x as usize
    }

    /// The texel whose cell, between it and the texels to the right and below, holds a place; held in the picture.
    #[inline]
    pub(super) fn cell_at(&self, place: &ImagePlace) -> (u32, u32) {
        // Casts saturate; values that are not numbers become 0.
        let x = (place.at.x as u32).min(self.width - 2);
        let y = (place.at.y as u32).min(self.height - 2);
        (x, y)
    }

    /// A place on the face that it belongs to: faces overlap a little, and places beyond a face lie on another.
    #[inline]
    pub(super) fn settled(&self, place: ImagePlace) -> ImagePlace {
        match &self.cube {
            Some(cube) => cube.settled(place),
            None => place,
        }
    }

    /// The point from which cube maps of a reflector are taken: its centre, but for flat ones a place before them,
    /// because the centre has them edge-on.
    fn center_of(mesh: &ReflectorMesh) -> Vec3 {
        let mean = mesh.normals.iter().sum::<Vec3>() / mesh.normals.len().max(1) as f32;
        if mean.length() > FLAT { mesh.center + mean * (0.5 * mesh.radius) } else { mesh.center }
    }

    /// True if four neighbouring texels (row by row) show one piece of smooth surface.
    fn is_smooth(&self, corners: [usize; 4]) -> bool {
        if corners.iter().any(|texel| self.spots[*texel].triangle == NOTHING) {
            return false;
        }
        let near = |first: usize, second: usize| {
            if self.spots[first].triangle == self.spots[second].triangle {
                return true;
            }
            let (a, b) = (&self.texels[first], &self.texels[second]);
            let (step, turn) = (b.position - a.position, b.normal - a.normal);
            let allowed = (turn.length() + SLOPE) * step.length();
            a.normal.dot(b.normal) > CREASE
                && a.normal.dot(step).abs() <= allowed
                && b.normal.dot(step).abs() <= allowed
        };
        let [a, b, c, d] = corners;
        near(a, b) && near(c, d) && near(a, c) && near(b, d)
    }

    /// Bytes held.
    pub(super) fn byte_count(&self) -> u64 {
        let bytes = size_of_val(self.texels.as_slice())
            + size_of_val(self.spots.as_slice())
            + size_of_val(self.joined.as_slice());
        bytes as u64
    }
}

/// Surface point at a place of a triangle.
fn texel_of(mesh: &ReflectorMesh, triangle: u32, weights: Vec2) -> (SurfaceTexel, MeshSpot) {
    let nothing =
        (SurfaceTexel { position: Vec3::NAN, normal: Vec3::NAN }, MeshSpot { triangle: NOTHING, weights: Vec2::ZERO });
    let Some(corners) = mesh.triangles.get(triangle as usize) else { return nothing };
    let at = |values: &[Vec3]| interpolated(values, *corners, weights);
    let (position, normal) = (at(&mesh.positions), at(&mesh.normals).try_normalize());
    match normal {
        Some(normal) if position.is_finite() => (SurfaceTexel { position, normal }, MeshSpot { triangle, weights }),
        _ => nothing,
    }
}
