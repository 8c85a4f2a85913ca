//! Pictures of a reflector: what of it is at a texel, and which texels lie side by side on its surface.

use super::cube::CubeFaces;
use crate::methods::projection::virtual_objects::{EyeImage, NOTHING, ReflectorMesh, interpolated};
use crate::parallel;
use crate::scene::View;
use glam::{Vec2, Vec3};

/// Normals of neighbouring texels further apart than this (a cosine) belong to different surfaces: a crease.
const CREASE: f32 = 0.5;

/// Neighbouring texels on one surface lie in each other's tangent planes, but for the surface's bend between them and
/// this slope: that of flat triangles against their normals.
const SLOPE: f32 = 0.25;

/// What a texel shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texel {
    pub(super) position: Vec3,
    /// The unit normal on the outer side.
    pub(super) normal: Vec3,
    /// The triangle of the reflector's mesh; [`NOTHING`] where there is none.
    pub(super) triangle: u32,
    /// The weights of its second and third corner.
    pub(super) weights: Vec2,
    /// Whether it and the texels to its right, below, and below to the right show one piece of smooth surface.
    pub(super) joined: bool,
}

/// A place in a picture: a face, and coordinates that are whole at the centres of texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) face: u32,
    pub(super) at: Vec2,
}

/// A picture of a reflector from the eye, or the six of a cube around it, in one layer or two.
#[derive(Clone, Debug)]
pub(super) struct ReflectorImage {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) face_count: u32,
    /// Face by face, row by row.
    pub(super) texels: Vec<Texel>,
    /// How directions and places of a cube's faces belong together.
    cube: Option<CubeFaces>,
}

impl ReflectorImage {
    /// What is seen first from the eye, with about `size` texels along the longer side; none where nothing is seen.
    pub(super) fn from_eye(mesh: &ReflectorMesh, view: &View, size: u32) -> Option<Self> {
        let drawn = EyeImage::draw(mesh, view, size)?;
        let texels = drawn.texels.iter().map(|texel| Texel::new(mesh, texel.triangle, texel.weights)).collect();
        let mut image = Self { width: drawn.width, height: drawn.height, face_count: 1, texels, cube: None };
        image.join();
        Some(image)
    }

    /// What is seen around the reflector's centre on six faces of `size` texels a side: what is outermost, and, if it is
    /// not convex, a second layer of six with what is innermost.
    pub(super) fn around(mesh: &ReflectorMesh, size: u32) -> Self {
        let cube = CubeFaces::new(mesh.center, size);
        let side = cube.side();
        let face_count = if mesh.convex { 6 } else { 12 };
        let faces = parallel::map_collect(face_count, |face| cube.draw(mesh, face % 6, face < 6));
        let texels = faces.concat();
        let mut image = Self { width: side, height: side, face_count: face_count as u32, texels, cube: Some(cube) };
        image.join();
        image
    }

    /// Tells which texels lie side by side on the surface.
    fn join(&mut self) {
        let (width, height) = (self.width as usize, self.height as usize);
        for face in self.texels.chunks_mut(width * height) {
            for y in 0..height - 1 {
                for x in 0..width - 1 {
                    let low = y * width + x;
                    let corners = [low, low + 1, low + width, low + width + 1].map(|index| face[index]);
                    face[low].joined = is_smooth(&corners);
                }
            }
        }
    }

    /// The index of a texel; coordinates must lie within the face.
    #[inline]
    pub(super) fn index(&self, face: u32, x: u32, y: u32) -> usize {
        (face as usize * self.height as usize + y as usize) * self.width as usize + x as usize
    }

    /// The texel whose cell, between it and the texels to the right and below, holds a place; held in the picture.
    #[inline]
    pub(super) fn cell_at(&self, place: &Place) -> (u32, u32) {
        // Casts saturate; what is not a number becomes 0.
        let x = (place.at.x as u32).min(self.width - 2);
        let y = (place.at.y as u32).min(self.height - 2);
        (x, y)
    }

    /// A place on the face that it belongs to: faces overlap a little, and places beyond a face lie on another.
    #[inline]
    pub(super) fn settled(&self, place: Place) -> Place {
        match &self.cube {
            Some(cube) => cube.settled(place),
            None => place,
        }
    }

    /// Bytes held.
    pub(super) fn byte_count(&self) -> u64 {
        size_of_val(self.texels.as_slice()) as u64
    }
}

impl Texel {
    /// What lies at a place of a triangle.
    pub(super) fn new(mesh: &ReflectorMesh, triangle: u32, weights: Vec2) -> Self {
        let nothing =
            Self { position: Vec3::NAN, normal: Vec3::NAN, triangle: NOTHING, weights: Vec2::ZERO, joined: false };
        let Some(corners) = mesh.triangles.get(triangle as usize) else { return nothing };
        let at = |values: &[Vec3]| interpolated(values, *corners, weights);
        let (position, normal) = (at(&mesh.positions), at(&mesh.normals).try_normalize());
        match normal {
            Some(normal) if position.is_finite() => Self { position, normal, triangle, weights, joined: false },
            _ => nothing,
        }
    }
}

/// Whether four neighbouring texels (row by row) show one piece of smooth surface.
fn is_smooth(corners: &[Texel; 4]) -> bool {
    if corners.iter().any(|texel| texel.triangle == NOTHING) {
        return false;
    }
    let near = |a: &Texel, b: &Texel| {
        if a.triangle == b.triangle {
            return true;
        }
        let (step, turn) = (b.position - a.position, b.normal - a.normal);
        let allowed = (turn.length() + SLOPE) * step.length();
        a.normal.dot(b.normal) > CREASE && a.normal.dot(step).abs() <= allowed && b.normal.dot(step).abs() <= allowed
    };
    let [a, b, c, d] = corners;
    near(a, b) && near(c, d) && near(a, c) && near(b, d)
}
