//! Records of what is looked up: environment maps, light fields and layers.

use bytemuck::{Pod, Zeroable};

/// The environment map of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ReflectorMap {
    /// Where it was captured.
    pub center: [f32; 3],
    /// 0: there is none; of what surrounds it, times 256: 1 infinite, 2 a box, 3 a sphere. Added to it is the number of
    /// the object's light field, from 1; 0: it has none.
    pub shape: u32,
    /// The lower corner of the box; the radius of the sphere in its first component.
    pub low: [f32; 3],
    /// Texels a side of its cube; 0: the scene's background is read.
    pub size: u32,
    /// The upper corner of the box.
    pub high: [f32; 3],
    /// The first texel of its cube.
    pub first: u32,
}

/// A region of reflectors and lenses with the slabs of its light field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FieldRegion {
    /// The root of the hierarchy over its reflectors and lenses, or [`NONE`](super::NONE).
    pub root: u32,
    /// Views a side of a slab.
    pub views: u32,
    /// Pixels a side of a view.
    pub pixels: u32,
    /// The first of the six layers of its pictures.
    pub first_layer: u32,
    /// Not 0: the parallax of pixels is looked up.
    pub has_depth: u32,
    /// Not 0: paths leave it after one event.
    pub by_one_event: u32,
    /// Padding.
    pub unused: [u32; 2],
    /// For each slab.
    pub slabs: [FieldSlab; 6],
}

/// The plane of a slab's views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct FieldSlab {
    /// The first view's coordinates across the axis.
    pub low: [f32; 2],
    /// The coordinate of all views along the axis.
    pub plane: f32,
    /// The parallax of the focal plane.
    pub focal: f32,
    /// The steps from view to view.
    pub spacing: [f32; 2],
    /// Padding.
    pub unused: [u32; 2],
}

/// A group of reflectors and lenses with layered environment maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LayerGroup {
    /// The root of the hierarchy over it.
    pub root: u32,
    /// The place of the first of its layers, in texels of the table.
    pub first_layer: u32,
    /// The number of its layers.
    pub layers: u32,
    /// The number of viewpoints that are blended.
    pub viewpoints: u32,
    /// Their shares.
    pub shares: [f32; 4],
}

/// A layer about a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Layer {
    /// The centre of its shell.
    pub center: [f32; 3],
    /// 0 infinite, 1 a box, 2 a sphere, 3 a cylinder, 4 a quad.
    pub shape: u32,
    /// The lower corner of a box; the radius of a sphere, and of a cylinder with its bottom and top; a quad's middle.
    pub low: [f32; 3],
    /// Texels a side of the finest level.
    pub size: u32,
    /// The upper corner of a box; a quad's normal.
    pub high: [f32; 3],
    /// Six, or one of a quad.
    pub faces: u32,
    /// A quad's way from its middle to the right edge, over its squared length.
    pub right: [f32; 3],
    /// The smallest share at which something begins.
    pub least: f32,
    /// A quad's way from its middle to the upper edge, over its squared length.
    pub up: [f32; 3],
    /// The largest share at which something begins.
    pub most: f32,
    /// Not 0: texels have depths.
    pub has_depths: u32,
    /// The first word of depths.
    pub first_depth: u32,
    /// The bits that their codes count from.
    pub depth_base: u32,
    /// In steps of this power of two.
    pub depth_shift: u32,
    /// The first word of bounds, or [`NONE`](super::NONE).
    pub first_bound: u32,
    /// How many levels they have.
    pub bound_levels: u32,
    /// Padding.
    pub unused: [u32; 2],
    /// The first texel of each viewpoint's texture.
    pub first_texels: [u32; 4],
}

/// Viewpoints that are blended at most.
pub const MAX_VIEWPOINTS: usize = 4;
