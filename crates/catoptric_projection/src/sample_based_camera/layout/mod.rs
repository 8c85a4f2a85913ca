//! Leaves as flat records of single precision numbers, without pointers: the same bytes serve every processor.

pub(crate) mod words;

pub(super) use words::{WordReader, WordWriter};

use bytemuck::{Pod, Zeroable};

/// Terms of a polynomial of degree 3 in two variables: `1, x, y, xx, xy, yy, xxx, xxy, xyy, yyy`.
pub(super) const TERMS: usize = 10;

/// The number of values of a bundle's polynomials: the first bounce point (3, from the centre), offset (2), slope (2),
/// the tail's place along the mean direction (1), the optical length to the tail (1), and nothing (3): whole vectors.
pub(super) const OUTPUTS: usize = 12;

/// A leaf of kind `ray_bundle`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct BundleLeaf {
    /// The middle of its first bounce points.
    pub(super) center: [f32; 3],
    /// The middle of its tails.
    pub(super) origin: [f32; 3],
    /// Index of refraction of the medium that its rays run through.
    pub(super) medium: f32,
    /// The mean direction of its rays, and two more axes of a rectangular frame.
    pub(super) direction: [f32; 3],
    /// The number of the connected region of rays that it belongs to.
    pub(super) piece: u32,
    /// Root mean squares of the errors of offsets and slopes.
    pub(super) offset_error: f32,
    pub(super) slope_error: f32,
    pub(super) across: [[f32; 3]; 2],
    /// The gradients of the coordinates, which are about -1 to 1 over the leaf, with respect to the first bounce point.
    pub(super) tangents: [[f32; 3]; 2],
    /// The coordinates of its rays lie between these.
    pub(super) low: [f32; 2],
    pub(super) high: [f32; 2],
    /// 1 if it interpolates between rays because no camera is accurate, else 0.
    pub(super) interpolates: u32,
    /// The corners of its rays' places in the map, in cells.
    pub(super) low_place: [f32; 2],
    pub(super) high_place: [f32; 2],
    /// Spacing, in cells.
    pub(super) apart: f32,
    /// The coefficients of each term, for each output.
    pub(super) coefficients: [[f32; OUTPUTS]; TERMS],
}

impl BundleLeaf {
    /// The distance of a place from its rays, in cells, along a row or column.
    pub(super) fn distance_from(&self, place: [f64; 2]) -> f64 {
        let beyond = |axis: usize| {
            (f64::from(self.low_place[axis]) - place[axis]).max(place[axis] - f64::from(self.high_place[axis]))
        };
        beyond(0).max(beyond(1)).max(0.0)
    }
}

/// Terms of a polynomial of degree 2 in two variables: `1, u, v, uu, uv, vv`.
pub(super) const PINHOLE_TERMS: usize = 6;

/// The number of values of a pinhole's polynomials: the first bounce point (3, from the image plane's origin), the
/// optical length to the tail, and the tail's place along the mean direction.
pub(super) const PINHOLE_OUTPUTS: usize = 5;

/// A leaf of kind `pinhole`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct PinholeLeaf {
    /// The centre of projection, unless the camera is affine.
    pub(super) center: [f32; 3],
    pub(super) is_affine: u32,
    /// A point of the image plane: the middle of the tails.
    pub(super) origin: [f32; 3],
    /// Index of refraction of the medium that its rays run through.
    pub(super) medium: f32,
    /// The image plane's unit normal.
    pub(super) normal: [f32; 3],
    /// The sign that turns the polynomials' own normal to the side that is seen.
    pub(super) side: f32,
    /// The mean direction of its rays.
    pub(super) direction: [f32; 3],
    /// Root mean square of the errors of first bounce points.
    pub(super) first_error: f32,
    /// Axes of the image plane over the extent of its tails.
    pub(super) axes: [[f32; 3]; 2],
    /// The frustum: image coordinates of its tails and heads lie between these.
    pub(super) low: [f32; 2],
    pub(super) high: [f32; 2],
    pub(super) coefficients: [[f32; PINHOLE_TERMS]; PINHOLE_OUTPUTS],
}

/// A node of the paper's tree: a splitting plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct SplitNode {
    /// Points with `normal . point > offset` are looked for in the first child, others in the second.
    pub(super) normal: [f32; 3],
    pub(super) offset: f32,
    /// Numbers of nodes, or with [`Self::LEAF`] of cameras; [`Self::LIST`] where rays are listed.
    pub(super) children: [u32; 2],
}

impl SplitNode {
    /// The bit that marks numbers of cameras.
    pub(super) const LEAF: u32 = 1 << 31;
    /// A list of rays.
    pub(super) const LIST: u32 = u32::MAX;
}
