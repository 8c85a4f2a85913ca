//! Virtual meshes: pieces of an object's triangles where they appear, and the work that they may take.

use catoptric_core::scene::PicturePoint;
use catoptric_engine::raster::{BlockMask, DrawTriangle};
use glam::Vec2;
use std::ops::Range;

/// Pieces of an object's triangles where they appear.
#[derive(Clone, Debug, Default)]
pub struct VirtualMesh {
    /// The corners of the pieces.
    pub vertices: Vec<PicturePoint>,
    /// The pieces; their groups are left at 0.
    pub triangles: Vec<DrawTriangle>,
    /// Weights of the source's second and third vertex at the corners.
    pub corners: Vec<[Vec2; 3]>,
    /// Blocks of the picture where pieces may show that are left out.
    pub holes: BlockMask,
    /// Points projected to make it.
    pub points_projected: u64,
    /// Pieces that were left undivided, or whose ends were not searched for, because there was too much to do.
    pub unfinished: u64,
    /// Vertices that were not projected, but put where the appearances of one near them lead, for the same reason.
    pub extrapolated: u64,
    /// Appearances of its vertices and of points on its edges that are left out: these had too many.
    pub left_out: u64,
    /// Vertices whose places follow from a few numbers that are kept.
    pub steady_points: u64,
    /// Time that these took, in milliseconds.
    pub blend_ms: f64,
    /// Work that it took.
    pub work: u64,
    /// Work that was allowed.
    pub(crate) allowed: u64,
    /// The least that may be allowed for the same mesh; `None` if any part of it was stopped, if only for a while.
    pub needed: Option<u64>,
}

/// Work that a mesh may take.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    /// Work, in units of about 100 ns of one core.
    pub(super) work: u64,
    /// True if an incomplete mesh is of no use, and is not made.
    pub(super) whole: bool,
}

impl Allowance {
    /// The allowance of a mesh that becomes coarser if this is not enough.
    pub fn for_all(work: u64) -> Self {
        Self { work, whole: false }
    }

    /// The work.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// The allowance of a mesh that is not made at all if this is not enough.
    pub fn for_whole(work: u64) -> Self {
        Self { work, whole: true }
    }
}

impl VirtualMesh {
    /// The counts of a mesh that takes too much work, without its geometry.
    pub(super) fn given_up(self) -> Self {
        let Self { points_projected, extrapolated, work, allowed, .. } = self;
        Self { points_projected, extrapolated, work, allowed, unfinished: self.unfinished.max(1), ..Self::default() }
    }

    /// True if nothing of it is coarser than asked for.
    pub fn is_whole(&self) -> bool {
        self.unfinished + self.extrapolated == 0
    }

    /// True if it would be the same with this much work allowed.
    pub fn holds_with(&self, allowed: u64) -> bool {
        allowed == self.allowed || self.needed.is_some_and(|needed| allowed >= needed)
    }

    /// Appends the pieces to those of other meshes.
    pub fn append_to(
        &self,
        vertices: &mut Vec<PicturePoint>,
        triangles: &mut Vec<DrawTriangle>,
        corners: &mut Vec<[Vec2; 3]>,
    ) {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(&self.vertices);
        let moved = |triangle: &DrawTriangle| DrawTriangle {
            vertices: triangle.vertices.map(|vertex| vertex + first),
            ..*triangle
        };
        triangles.extend(self.triangles.iter().map(moved));
        corners.extend_from_slice(&self.corners);
    }

    /// Appends some of a divider's pieces.
    pub(super) fn append_some_to(
        &self,
        pieces: Range<usize>,
        vertices: &mut Vec<PicturePoint>,
        triangles: &mut Vec<DrawTriangle>,
        corners: &mut Vec<[Vec2; 3]>,
    ) {
        // Three vertices a piece, in their order.
        let (first, from) = (vertices.len() as u32, 3 * pieces.start as u32);
        vertices.extend_from_slice(&self.vertices[3 * pieces.start..3 * pieces.end]);
        let moved = |triangle: &DrawTriangle| {
            let vertices = triangle.vertices.map(|vertex| vertex - from + first);
            DrawTriangle { vertices, ..*triangle }
        };
        triangles.extend(self.triangles[pieces.clone()].iter().map(moved));
        corners.extend_from_slice(&self.corners[pieces]);
    }
}
