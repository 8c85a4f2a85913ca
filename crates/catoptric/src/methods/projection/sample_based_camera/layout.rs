//! Leaves as flat records of single precision numbers, without pointers: the same bytes serve every processor.

use bytemuck::{Pod, Zeroable};

/// Terms of a polynomial of degree 3 in two variables: `1, x, y, xx, xy, yy, xxx, xxy, xyy, yyy`.
pub(super) const TERMS: usize = 10;

/// What a bundle's polynomials give: the first bounce point (3, from the centre), offset (2), slope (2), where tails
/// are along the mean direction (1), the optical length to the tail (1).
pub(super) const OUTPUTS: usize = 9;

/// A leaf of kind `ray_bundle`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct BundleLeaf {
    /// Where coordinates are zero, on the first surface or near it.
    pub(super) center: [f32; 3],
    /// How far its first bounce points are from there.
    pub(super) size: f32,
    /// The middle of its tails.
    pub(super) origin: [f32; 3],
    /// Index of refraction of what its rays run through.
    pub(super) medium: f32,
    /// The mean direction of its rays, and two more axes of a rectangular frame.
    pub(super) direction: [f32; 3],
    /// Which connected region of rays it belongs to.
    pub(super) piece: u32,
    /// Root mean squares of the errors of offsets and slopes.
    pub(super) offset_error: f32,
    pub(super) slope_error: f32,
    pub(super) across: [[f32; 3]; 2],
    /// Gradients of the coordinates: about -1 to 1 over the leaf.
    pub(super) tangents: [[f32; 3]; 2],
    /// The coordinates of its rays lie between these.
    pub(super) low: [f32; 2],
    pub(super) high: [f32; 2],
    /// The cells of its rays, corners included.
    pub(super) low_cell: [u32; 2],
    pub(super) high_cell: [u32; 2],
    pub(super) coefficients: [[f32; TERMS]; OUTPUTS],
}
