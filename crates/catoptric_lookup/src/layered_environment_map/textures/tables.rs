//! Layers as plain tables: for other processors to look up.

use super::maps::{Layer, LayersAbout};
use crate::layered_environment_map::shell::{Quad, Shell};
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use glam::Vec3;

/// The layers of a viewpoint about a group, the nearest first.
#[derive(Clone, Debug)]
pub struct ViewpointLayers<'a> {
    /// The viewpoint: its layers stay the same while the scene does.
    pub number: u32,
    /// The weight in the blend.
    pub share: f32,
    pub(crate) layers: LayersAbout<'a>,
}

impl<'a> ViewpointLayers<'a> {
    /// The layers.
    pub fn layers(&self) -> impl ExactSizeIterator<Item = LayerTables<'a>> {
        self.layers.iter().map(|layer| LayerTables { layer })
    }
}

/// A layer: a shell with a texture of transparency and, perhaps, depths.
#[derive(Clone, Copy, Debug)]
pub struct LayerTables<'a> {
    layer: &'a Layer,
}

/// The shape that stands in for the things of a layer, from its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShellShape {
    /// A shape all around, about the centre as its origin.
    Around(ParallaxProxy),
    /// A rectangle.
    Quad {
        /// The middle of the rectangle.
        middle: Vec3,
        /// Unit, away from the centre.
        normal: Vec3,
        /// The vector from the middle to the right edge.
        right: Vec3,
        /// The vector from the middle to the upper edge.
        up: Vec3,
    },
}

/// The depths of a layer's surfaces, in the texels of its finest level, from the centre.
#[derive(Clone, Copy, Debug)]
pub struct DepthTables<'a> {
    /// Two codes a texel, face by face and row by row: the depth where its surface begins in the lower half, the depth
    /// where the object ends in the upper. 0xFFFF is infinite; others stand for the share of the shell's distance whose
    /// bits are `base` and the code times 2^`shift`.
    pub words: &'a [u32],
    /// See `words`.
    pub base: u32,
    /// See `words`.
    pub shift: u32,
    /// The smallest and the largest share at which something begins.
    pub range: [f32; 2],
    /// The number of levels of bounds; 0: there are none.
    pub bound_levels: u32,
    layer: &'a Layer,
}

impl<'a> LayerTables<'a> {
    /// The centre of its shell, in world space.
    pub fn center(&self) -> Vec3 {
        self.layer.center
    }

    /// The layer's shell.
    pub fn shape(&self) -> ShellShape {
        match self.layer.shell {
            Shell::Around(surround) => ShellShape::Around(surround),
            Shell::Quad(Quad { middle, normal, right, up }) => ShellShape::Quad { middle, normal, right, up },
        }
    }

    /// Texels a side of the finest level of its texture, a power of two; coarser ones have halves, down to one.
    pub fn size(&self) -> u32 {
        self.layer.texture.layout.size()
    }

    /// Six faces of a cube, looked up by directions from the centre, or one square, by places from -1 to 1.
    pub fn faces(&self) -> u32 {
        self.layer.texture.layout.faces()
    }

    /// Radiance times opacity, and opacity, as the bits of half floats: level after level from the finest, face after
    /// face, row after row.
    pub fn texels(&self) -> impl ExactSizeIterator<Item = [u16; 4]> + use<'a> {
        self.layer.texture.texels.iter().map(|texel| texel.halves())
    }

    /// The depths of its texels; `None`: all lies on the shell, and layers hide each other in their order.
    pub fn depths(&self) -> Option<DepthTables<'a>> {
        let (depths, range, bounds) = self.layer.distances.as_ref()?.parts();
        let (words, base, shift) = depths.parts();
        let bound_levels = bounds.map_or(0, |bounds| bounds.parts().1);
        Some(DepthTables { words, base, shift, range, bound_levels, layer: self.layer })
    }
}

impl<'a> DepthTables<'a> {
    /// The least share at which something begins in cells of 4 x 4 texels, and the largest at which something ends
    /// (infinite and 0 in empty cells): face after face, row after row; then those of cells that are twice as large,
    /// and so on.
    pub fn bounds(&self) -> impl Iterator<Item = [f32; 2]> + use<'a> {
        let bounds = self.layer.distances.as_ref().and_then(|distances| distances.parts().2);
        bounds.into_iter().flat_map(|bounds| bounds.parts().0).map(|range| [range.least, range.most])
    }
}
