//! Meshes of the shapes of `[[object]]`, about their middle.

use crate::builtin::parts::shapes::{self, Shape};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Segments about the axis of round shapes.
const SEGMENTS: u32 = 96;
/// Rings of a sphere, and of the small ones that mark points.
const RINGS: [u32; 2] = [48, 8];
/// Cells along the sides of flat faces.
const CELLS: u32 = 8;
/// Segments of a flat mirror or lens face: its rim is off by 5e-6 of its radius.
const FINE_SEGMENTS: u32 = 1000;

/// A shape and its lengths.
pub(super) enum Solid {
    /// By width, height and depth.
    Box([f32; 3]),
    /// In the xz plane, towards +y, upright as seen with -z up: by width and height.
    Quad([f32; 2]),
    /// By the radius.
    Sphere(f32),
    /// A sphere of few triangles.
    Point(f32),
    /// About y: by radius and height.
    Cylinder(f32, f32),
    /// About y, its tip at the top: by radius and height.
    Cone(f32, f32),
    /// In the xz plane, towards +y: by the radius.
    Disk(f32),
}

impl Solid {
    /// The mesh. A picture covers it once, each face of a box, or it has squares of a side, as nearly as they fit.
    pub(super) fn mesh(&self, square: Option<f32>) -> Shape {
        // Textures of squares hold two of them a side.
        let tile = square.map(|square| 2.0 * square);
        match *self {
            Self::Box(size) => cuboid(Vec3::from(size) * 0.5, tile),
            Self::Quad([width, height]) => {
                let (right, up) = (Vec3::X * width, Vec3::NEG_Z * height);
                face((right + up) * -0.5, right, up, tile)
            }
            Self::Sphere(radius) => around(ball(radius, RINGS[0]), radius, PI * radius, tile),
            Self::Point(radius) => around(ball(radius, RINGS[1]), radius, PI * radius, tile),
            Self::Cylinder(radius, height) => {
                let half = height * 0.5;
                let lid = |y: f32, from: f32, to: f32| [Vec2::new(from, y), Vec2::new(to, y)];
                let side = [Vec2::new(radius, -half), Vec2::new(radius, half)];
                let mut mesh = around(turned(side), radius, height, tile);
                for line in [lid(-half, 0.0, radius), lid(half, radius, 0.0)] {
                    shapes::append(&mut mesh, &around(turned(line), radius, radius, tile));
                }
                mesh
            }
            Self::Cone(radius, height) => {
                let half = height * 0.5;
                let side = turned([Vec2::new(radius, -half), Vec2::new(0.0, half)]);
                let mut mesh = around(side, radius, Vec2::new(radius, height).length(), tile);
                let base = turned([Vec2::new(0.0, -half), Vec2::new(radius, -half)]);
                shapes::append(&mut mesh, &around(base, radius, radius, tile));
                mesh
            }
            Self::Disk(radius) => disk(radius, SEGMENTS, tile),
        }
    }
}

/// The finer mesh of a flat round face of that radius, in the xz plane, towards +y or -y.
pub(super) fn fine_disk(radius: f32, is_up: bool) -> Shape {
    let mut mesh = disk(radius, FINE_SEGMENTS, None);
    if !is_up {
        mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    mesh
}

fn face(corner: Vec3, right: Vec3, up: Vec3, tile: Option<f32>) -> Shape {
    let tile = tile.map_or(Vec2::new(right.length(), up.length()), Vec2::splat);
    shapes::rectangle(corner, right, up, [CELLS; 2], tile)
}

fn cuboid(half: Vec3, tile: Option<f32>) -> Shape {
    let (x, y, z) = (Vec3::X * half.x * 2.0, Vec3::Y * half.y * 2.0, Vec3::Z * half.z * 2.0);
    let mut mesh = Shape::default();
    for (signs, right, up) in [
        ([-1.0, -1.0, 1.0], x, y),
        ([1.0, -1.0, -1.0], -x, y),
        ([1.0, -1.0, 1.0], -z, y),
        ([-1.0, -1.0, -1.0], z, y),
        ([-1.0, 1.0, 1.0], x, -z),
        ([-1.0, -1.0, -1.0], x, z),
    ] {
        shapes::append(&mut mesh, &face(half * Vec3::from(signs), right, up, tile));
    }
    mesh
}

fn ball(radius: f32, rings: u32) -> Shape {
    let mut mesh = shapes::sphere(radius, rings);
    // Seen from outside, a picture is not mirrored.
    mesh.uvs.iter_mut().for_each(|uv| uv.x = 1.0 - uv.x);
    mesh
}

/// The surface that a straight line (radius, y) sweeps out about y.
fn turned(line: [Vec2; 2]) -> Shape {
    let point = |end: Vec2| shapes::ProfilePoint { radius: end.x, y: end.y, direction: line[1] - line[0] };
    shapes::revolution(&line.map(point), SEGMENTS)
}

/// The texture coordinates of a mesh about an axis in squares: as many as fit around its circumference.
fn around(mut mesh: Shape, radius: f32, length: f32, tile: Option<f32>) -> Shape {
    if let Some(tile) = tile {
        let repeats = Vec2::new((TAU * radius / tile).round().max(1.0), length / tile);
        mesh.uvs.iter_mut().for_each(|uv| *uv *= repeats);
    }
    mesh
}

/// A fan from the middle, whose picture is cut out of a square.
fn disk(radius: f32, segments: u32, tile: Option<f32>) -> Shape {
    let mut mesh = shapes::revolution(
        &[Vec2::new(radius, 0.0), Vec2::ZERO].map(|end| shapes::ProfilePoint {
            radius: end.x,
            y: end.y,
            direction: Vec2::NEG_X,
        }),
        segments,
    );
    let scale = tile.unwrap_or(2.0 * radius).recip();
    mesh.uvs = mesh.positions.iter().map(|p| (Vec2::new(p.x, p.z) + radius) * scale).collect();
    mesh
}
