//! The CPU rasteriser: draws real and moved (virtual) geometry alike into layers of coverage samples, tile by tile,
//! and hands each visible surface to a shader once a pixel.

use crate::scene::{PicturePoint, shade::Barycentrics};
use glam::{Vec2, Vec3};

/// A triangle to be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawTriangle {
    /// Indices into the list's vertices.
    pub vertices: [u32; 3],
    /// What the shader is told: the triangle of the scene whose attributes it carries.
    pub source: u32,
    /// A number that later lists can be confined to: [`Stencil::group`].
    pub group: u32,
}

/// Confines a list to those samples where the layer below shows a triangle of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stencil {
    /// The list (index in the call) that drew the layer below.
    pub list: u32,
    /// The group of its triangles.
    pub group: u32,
}

/// Geometry that is drawn together.
#[derive(Clone, Debug, Default)]
pub struct DrawList {
    /// Vertices in the picture's homogeneous coordinates. Depth orders visibility (nearer is smaller).
    pub vertices: Vec<PicturePoint>,
    /// Triangles; both windings are drawn.
    pub triangles: Vec<DrawTriangle>,
    /// The layer: 0 is what the eye sees directly, 1 what is seen in that by one reflection, and so on.
    pub layer: u32,
    /// Where it may be drawn; none: everywhere (layer 0).
    pub stencil: Option<Stencil>,
}

/// What a pixel shows in one layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerSurface {
    /// The list that drew it.
    pub list: u32,
    /// [`DrawTriangle::source`].
    pub source: u32,
    /// [`DrawTriangle::group`].
    pub group: u32,
    /// Perspective-correct barycentric coordinates at `Fragment::position`, and their true screen derivatives.
    pub barycentrics: Barycentrics,
}

/// A part of a pixel that shows one chain of surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment<'a> {
    /// Where it is shaded, in pixels: the pixel's centre, or the centroid of its samples where it is covered in part.
    pub position: Vec2,
    /// The surfaces, layer 0 first; a chain ends where a layer shows nothing. Empty: the background.
    pub chain: &'a [LayerSurface],
}

/// Gives colours to fragments.
pub trait FragmentShader: Sync {
    /// The linear radiance of a fragment.
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3;
}

mod samples;
pub use samples::sample_positions;
