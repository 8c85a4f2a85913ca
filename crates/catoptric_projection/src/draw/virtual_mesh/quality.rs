//! Fineness of virtual geometry.

use super::picture_scale::PictureScale;
use catoptric_core::scene::View;

/// Fineness of virtual geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshQuality {
    /// Edges are divided until their middles are this near to where they belong, in pixels.
    pub edge_error_px: f32,
    /// Edges shorter than this are not divided, in pixels; those on which an appearance ends, than 32 times this.
    pub piece_px: f32,
    /// True for the rules of Chen and Arvo 2000: appearances at the two ends of an edge are joined where they lie near
    /// each other, whether they predict each other or not, and no mirror appears in itself.
    pub is_plain: bool,
    /// The picture: edges outside it are not divided.
    pub picture: PictureScale,
    /// The fate of pieces on which appearances end, and of those that would have to be very small.
    pub ends: Ends,
}

/// Pieces on which appearances end (in folds, at silhouettes, behind other parts of a mirror) and strongly bent ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ends {
    /// Drawn: appearances are followed to their ends.
    #[default]
    Followed,
    /// Left to something else, with the blocks of the picture where they may show (`VirtualMesh::holes`).
    LeftOut,
}

impl MeshQuality {
    /// Quality for a view's picture, from the finest edges' error and the smallest pieces, both in pixels.
    pub fn new(view: &View, edge_error_px: f32, piece_px: f32) -> Self {
        let (picture, ends) = (PictureScale::new(view), Ends::Followed);
        Self { edge_error_px, piece_px, is_plain: false, picture, ends }
    }
}

impl MeshQuality {
    /// This quality with errors and pieces so many times larger.
    #[must_use]
    pub fn coarser(&self, times: f32) -> Self {
        Self { edge_error_px: self.edge_error_px * times, piece_px: self.piece_px * times, ..*self }
    }
}
