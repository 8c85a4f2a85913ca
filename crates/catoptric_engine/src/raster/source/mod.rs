//! Surfaces that no list draws: a source works them out tile by tile, from what the layers below show.
//!
//! Lists know their geometry before any tile is drawn. What is seen in a curved mirror can also be found from the
//! mirror's own pixels; such surfaces have no triangles in the picture, but take part in everything that comes after:
//! stencils of the next layers, fragments, shading.

pub use super::ids::{EMPTY, FOUND, found_id, found_number};

use super::attributes::depth_at;
use super::fragment::LayerSurface;
use super::kernel::{BLOCK, Ids, TILE_BLOCKS};
use super::lists::DrawTriangle;
use super::plan::{LayerPlan, Plan, surface_at};
use glam::Vec2;

/// Finds surfaces of the layers above the first, tile by tile.
pub trait LayerSource: Sync {
    /// The surfaces that were found in a tile, with the buffers of a thread.
    type Found: Default + Send;

    /// The number of layers that it may show something in, the first (which it never does) among them.
    fn layer_count(&self) -> usize;

    /// Forgets what was found: another tile begins.
    fn begin(&self, found: &mut Self::Found);

    /// Writes ids ([`found_id`]) of surfaces to the samples of the layer above those of `tile`. Samples that lists
    /// own ([`TileBelow::has_list`]) are left as they are.
    fn draw_layer(&self, tile: &TileBelow<'_>, found: &mut Self::Found, ids: &mut [u32]) -> ShownBySource;

    /// A surface at a position of the picture, in pixels.
    fn surface(&self, found: &Self::Found, number: u32, position: Vec2) -> LayerSurface;

    /// The number of the smooth surface that it is a part of ([`DrawTriangle::patch`]).
    fn patch(&self, found: &Self::Found, number: u32) -> u32;

    /// The surface's depth at a position of the picture, in pixels.
    fn depth_at(&self, found: &Self::Found, number: u32, position: Vec2) -> f32;

    /// Returns true if the surface's place changes unevenly within a pixel: its footprint alone does not tell where
    /// samples see it.
    fn is_bent(&self, found: &Self::Found, number: u32) -> bool;

    /// Returns true if the source goes on from a triangle of the scene by two branches.
    fn divides(&self, triangle: u32) -> bool;
}

/// The surfaces that a source shows in a layer, in short.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShownBySource {
    /// Anything at all.
    pub any: bool,
    /// Light divides at some surface of the layer below that the source goes on from.
    pub divides: bool,
}

/// The layers of a tile so far.
pub struct TileBelow<'a> {
    /// The tile's first pixel: column and row.
    pub pixel: [i32; 2],
    /// Columns and rows of the tile that lie in the picture.
    pub extent: [usize; 2],
    /// The places of samples in a pixel.
    pub positions: &'static [Vec2],
    /// Bit k: surfaces of layer k pass light on by their second branch.
    pub second_branches: u64,
    pub(super) plan: &'a Plan<'a>,
    pub(super) layers: &'a [Vec<Ids>],
}

impl TileBelow<'_> {
    /// The number of layers below the one that is drawn, at least 1.
    pub fn layer(&self) -> usize {
        self.layers.len()
    }

    /// The ids of all samples in a layer.
    pub fn ids(&self, layer: usize) -> &[u32] {
        bytemuck::cast_slice(&self.layers[layer])
    }

    /// The index of a pixel's first sample; the others follow it.
    #[inline]
    pub fn first_sample(&self, column: usize, row: usize) -> usize {
        let block = row / BLOCK * TILE_BLOCKS + column / BLOCK;
        ((block * BLOCK + row % BLOCK) * BLOCK + column % BLOCK) * self.positions.len()
    }

    /// The triangle of a list that a sample shows, by its id.
    #[inline]
    pub fn triangle(&self, id: u32) -> &DrawTriangle {
        self.plan.triangle(id).1
    }

    /// Returns true if lists leave out blocks of the picture in the layer that is drawn.
    pub fn has_holes(&self) -> bool {
        self.plan.layers.get(self.layer()).is_some_and(LayerPlan::has_holes)
    }

    /// Returns true if a list shows what lies beyond a list's triangle in a block of the tile, and a source need not.
    #[inline]
    pub fn has_list(&self, id: u32, block: usize) -> bool {
        let Some(layer) = self.plan.layers.get(self.layer()) else { return false };
        let (list, triangle) = self.plan.triangle(id);
        let label = layer.label(list, triangle.group);
        if label == 0 || !layer.has_holes() {
            return label != 0;
        }
        let second = self.second_branches >> (self.layer() - 1) & 1 != 0;
        let place = [block % TILE_BLOCKS, block / TILE_BLOCKS];
        let place = [0, 1].map(|axis: usize| self.pixel[axis] as usize / BLOCK + place[axis]);
        !self.plan.has_hole(layer, (label, second), place)
    }

    /// The number of samples in a block of the tile; blocks follow each other row by row.
    pub fn samples_a_block(&self) -> usize {
        BLOCK * BLOCK * self.positions.len()
    }

    /// The surface of a list that a sample shows, by its id, at a position of the picture (in pixels), which lies no
    /// further beside the triangle than so many times its size.
    #[inline(always)] // for the instructions of its caller
    pub fn surface(&self, id: u32, position: Vec2, leeway: f32) -> LayerSurface {
        surface_at(self.plan, id, position, leeway)
    }
}

/// Nothing beyond the lists.
pub(super) struct ListsAlone;

impl LayerSource for ListsAlone {
    type Found = ();

    fn layer_count(&self) -> usize {
        0
    }

    fn begin(&self, (): &mut ()) {}

    fn draw_layer(&self, _: &TileBelow<'_>, (): &mut (), _: &mut [u32]) -> ShownBySource {
        ShownBySource::default()
    }

    fn surface(&self, (): &(), _: u32, _: Vec2) -> LayerSurface {
        LayerSurface::default()
    }

    fn patch(&self, (): &(), _: u32) -> u32 {
        0
    }

    fn depth_at(&self, (): &(), _: u32, _: Vec2) -> f32 {
        0.0
    }

    fn is_bent(&self, (): &(), _: u32) -> bool {
        false
    }

    fn divides(&self, _: u32) -> bool {
        false
    }
}

/// The surfaces of lists and of a tile's source, by their ids.
pub(super) struct KnownSurfaces<'a, L: LayerSource> {
    pub(super) plan: &'a Plan<'a>,
    pub(super) source: &'a L,
    pub(super) found: &'a L::Found,
}

impl<L: LayerSource> KnownSurfaces<'_, L> {
    /// The list (none of them, where a source has found it) and the number of the smooth surface that it is part of, 0
    /// for none.
    pub(super) fn patch(&self, id: u32) -> (u32, u32) {
        match found_number(id) {
            Some(number) => (u32::MAX, self.source.patch(self.found, number)),
            None => {
                let (list, triangle) = self.plan.triangle(id);
                (list, triangle.patch)
            }
        }
    }

    /// Returns true if a source has found the surface, and its place changes unevenly within a pixel.
    #[inline]
    pub(super) fn is_bent(&self, id: u32) -> bool {
        found_number(id).is_some_and(|number| self.source.is_bent(self.found, number))
    }

    /// The depth of a surface at a position of the picture, to be compared with others of the same list.
    pub(super) fn depth_at(&self, id: u32, position: Vec2) -> f32 {
        match found_number(id) {
            Some(number) => self.source.depth_at(self.found, number, position),
            None => {
                let (list, triangle) = self.plan.triangle(id);
                depth_at(self.plan.corners(list, triangle), position)
            }
        }
    }

    /// Returns true if light divides at a surface that shows in a layer.
    pub(super) fn divides(&self, layer: usize, id: u32) -> bool {
        if let Some(number) = found_number(id) {
            let surface = self.source.surface(self.found, number, Vec2::ZERO);
            return surface.group != 0 && self.source.divides(surface.source);
        }
        let (_, triangle) = self.plan.triangle(id);
        self.plan.divides(layer, id) || (triangle.group != 0 && self.source.divides(triangle.source))
    }
}
