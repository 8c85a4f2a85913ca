//! Records of the grids that tell what rough mirrors reflect.

use bytemuck::{Pod, Zeroable};

/// Grids, each of cells of half the side of the one before.
pub const GRIDS: usize = 3;
/// The most means over ever more cells: those of a side of 65,536 cells.
pub const MOST_REDUCTIONS: usize = 16;

/// The grids of a view, and what a pass works on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Grids {
    /// Width, height, the side of a cell in pixels, and the place of the first cell; the coarsest first.
    pub levels: [[u32; 4]; GRIDS],
    /// Width, height and first cell of means over so many cells as the second grid's, the first one's, and ever more.
    pub reductions: [[u32; 4]; MOST_REDUCTIONS],
    /// The view's axis.
    pub forward: [f32; 3],
    /// The depth of its near plane.
    pub near: f32,
    /// The grids reach so far beyond the picture.
    pub margin_px: f32,
    /// Beyond this distance nothing moves in what a place sees.
    pub greatest_distance: f32,
    /// The grid that a pass works on.
    pub level: u32,
    /// The means that it works on.
    pub reduction: u32,
    /// How many there are.
    pub reduction_count: u32,
    /// Padding.
    pub unused: [u32; 3],
}

/// Bytes of a cell: what its ray meets, and what is near in its row.
pub const WORD_BYTES: u64 = 4;
/// Bytes of a ray that leaves a mirror.
pub const PASSAGE_BYTES: u64 = 64;
/// Bytes of a rough mirror's light, and of the shape of its lobe.
pub const LIGHT_BYTES: u64 = 32;
/// Bytes of the radiance that a ray shows, and of a mean of these.
pub const SHARP_BYTES: u64 = 16;
