//! The rasteriser as a whole, and its parts.

mod attributes;
mod coverage;
mod id_map;
mod layers;
mod patches;
mod pieces;
mod robustness;
mod samples;

use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Silent;
use catoptric_core::scene::{PicturePoint, Projection, View};
use catoptric_engine::raster::{DrawList, DrawTriangle, Fragment, FragmentShader, draw};
use glam::{Affine3A, DVec3, Vec2, Vec3};

/// A view from the origin along -z with y up; perspective ones have a vertical field of view of 60 degrees,
/// orthographic ones show 2 units up and down.
fn view(width: u32, height: u32, perspective: bool) -> View {
    let projection = if perspective {
        Projection::Perspective { fov_y: 60.0f32.to_radians() }
    } else {
        Projection::Orthographic { half_height: 2.0 }
    };
    View { world_from_view: Affine3A::IDENTITY, projection, width, height, near: 0.5 }
}

/// A point of the picture (in pixels) at a depth.
fn at(x: f32, y: f32, depth: f32) -> PicturePoint {
    PicturePoint { xy: Vec2::new(x, y) * depth, w: depth, depth }
}

/// A list of triangles with three vertices of their own each; sources count up from 0, groups are all 0.
fn list(triangles: impl IntoIterator<Item = [PicturePoint; 3]>) -> DrawList {
    let mut list = DrawList::default();
    for (source, corners) in triangles.into_iter().enumerate() {
        let first = list.vertices.len() as u32;
        list.vertices.extend(corners);
        let vertices = [first, first + 1, first + 2];
        list.triangles.push(DrawTriangle { vertices, source: source as u32, ..DrawTriangle::default() });
    }
    list
}

/// A rectangle of the picture in two triangles, at a depth.
fn rectangle(low: Vec2, high: Vec2, depth: f32) -> [[PicturePoint; 3]; 2] {
    let [a, b, c, d] =
        [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)].map(|(x, y)| at(x, y, depth));
    [[a, b, c], [a, c, d]]
}

/// Gives each fragment the colour of a function of it.
struct Paint<F>(F);

impl<F: Fn(&Fragment<'_>) -> Vec3 + Sync> FragmentShader for Paint<F> {
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        (self.0)(fragment)
    }
}

/// The picture of lists with a shader that is a function.
fn picture(view: &View, samples: u32, lists: &[DrawList], shade: impl Fn(&Fragment<'_>) -> Vec3 + Sync) -> Framebuffer {
    let mut target = Framebuffer::new(view.width, view.height);
    draw(view, samples, lists, &Paint(shade), &mut target, &Silent).expect("the count is supported");
    target
}

/// White on all surfaces: the coverage of a pixel.
fn coverage(fragment: &Fragment<'_>) -> Vec3 {
    if fragment.chain.is_empty() { Vec3::ZERO } else { Vec3::ONE }
}

/// The hit of the ray from the origin through `direction` (its z is -1) with a triangle: depth and barycentric
/// coordinates, in double precision, by solving for them directly.
fn meet(corners: &[Vec3; 3], direction: DVec3) -> Option<(f64, [f64; 3])> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let volumes = [direction.dot(b.cross(c)), direction.dot(c.cross(a)), direction.dot(a.cross(b))];
    let sum: f64 = volumes.iter().sum();
    let weights = volumes.map(|volume| volume / sum);
    let depth = -(a.z * weights[0] + b.z * weights[1] + c.z * weights[2]);
    (weights.iter().all(|w| *w >= 0.0) && depth > 0.0).then_some((depth, weights))
}
