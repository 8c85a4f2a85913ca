//! Answers of cameras, and counts of their leaves.

use super::camera_projection::CameraProjection;
use crate::sample_based_camera::layout::BundleLeaf;

/// A camera's projection of a point, and the rays for which it holds.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct CameraAnswer<'a> {
    pub(in super::super) answer: &'a CameraProjection,
    /// The connected region of rays that it is meant for.
    pub(in super::super) piece: u32,
    /// Places of these rays, in cells; `None` if all of the piece may be meant.
    pub(in super::super) places: Option<[[f32; 2]; 2]>,
    /// Spacing of these rays, in cells.
    pub(in super::super) apart: f32,
    /// True if it is interpolated between rays, and may be off by about that.
    pub(in super::super) interpolates: bool,
}

impl<'a> CameraAnswer<'a> {
    /// The answer of a leaf.
    pub(in super::super) fn of(answer: &'a CameraProjection, leaf: &BundleLeaf) -> Self {
        let places = Some([leaf.low_place, leaf.high_place]);
        Self { answer, piece: leaf.piece, places, apart: leaf.apart, interpolates: leaf.interpolates != 0 }
    }
}

/// A leaf among those of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct LeafNumber {
    /// The number of the camera, or of a list of rays.
    pub(in super::super) number: u32,
    /// True if it interpolates between rays.
    pub(in super::super) is_list: bool,
}

/// Scratch space of look-ups.
#[derive(Debug, Default)]
pub(in super::super) struct CameraScratch {
    pub(in super::super) numbers: Vec<u32>,
    pub(in super::super) answers: Vec<CameraProjection>,
}

/// Counts of cameras.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Counts {
    /// Leaves that are cameras within the accuracy.
    pub(in super::super) leaves: u64,
    /// Leaves that interpolate between rays instead, and the rays in them.
    pub(in super::super) ray_lists: u64,
    pub(in super::super) rays_in_lists: u64,
    /// Blocks of the map that interpolate because there were too many to trace more rays for.
    pub(in super::super) unrefined_blocks: u64,
    /// Lists of rays that would have been split further, had there not been too many splits.
    pub(in super::super) unsplit_lists: u64,
    pub(in super::super) bytes: u64,
}
