//! Lists of triangles, and the layers and samples that they are drawn in.

use super::block_mask::BlockMask;
use catoptric_core::scene::PicturePoint;
use glam::Vec2;

/// A triangle to be drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DrawTriangle {
    /// Indices into the list's vertices. Triangles that point beyond them are not drawn.
    pub vertices: [u32; 3],
    /// The source handed to the shader: the triangle of the scene whose attributes it carries.
    pub source: u32,
    /// A number that later lists can be confined to: [`Stencil::group`].
    pub group: u32,
    /// Triangles of a list with the same number (other than 0) are parts of one smooth surface, whose look does not
    /// depend on which of them is visible: where several meet in a pixel at the same depth they are shaded as one.
    pub patch: u32,
    /// The shader tests at every sample whether the surface is there, by its
    /// [`is_present`](super::super::FragmentShader::is_present). At equal depth such triangles lie behind all others.
    pub alpha_tested: bool,
}

/// Confines a list to those samples where the layer below shows a triangle of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stencil {
    /// The list (index in the call) that drew the layer below.
    pub list: u32,
    /// The group of its triangles.
    pub group: u32,
    /// The branch of light on from the layer below.
    pub branch: Branch,
}

/// The branches at a surface where light may divide, as on glass into reflected and refracted light.
///
/// A sample shows one surface a layer. So where surfaces with lists in their second branch (even empty ones) are
/// visible, the layers above are drawn again with those lists in place of the first branch's, and what the shader gives
/// is added: each sequence of branches that shows in a tile is drawn and shaded once. Pictures without such surfaces
/// cost nothing more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Branch {
    /// The only way on, or the first of two.
    #[default]
    First,
    /// The other.
    Second,
}

/// Geometry that is drawn together.
#[derive(Clone, Debug, Default)]
pub struct DrawList {
    /// Vertices in the picture's homogeneous coordinates. In perspective views `w` orders visibility, in orthographic
    /// ones `depth` does (nearer is smaller, the first drawn wins where they are equal). Triangles with a vertex that
    /// is not finite are not drawn; parts nearer than the view's near plane are cut off.
    pub vertices: Vec<PicturePoint>,
    /// For every vertex a signed distance, linear in space (the height above a mirror, say): parts below 0 are cut
    /// off. Empty: nothing is.
    pub clip_distances: Vec<f32>,
    /// Triangles; both windings are drawn.
    pub triangles: Vec<DrawTriangle>,
    /// For every triangle its corners' coordinates in its source: the weights of the source's second and third vertex.
    /// Empty (or missing for a triangle): the corners are the source's own.
    pub corners: Vec<[Vec2; 3]>,
    /// The layer: 0 for directly visible surfaces, 1 for their reflections in layer 0, and so on.
    pub layer: u32,
    /// The samples it is confined to: `None` in layer 0, and a list of the layer below in all others.
    pub stencil: Option<Stencil>,
    /// Blocks of the picture where a list above layer 0 is not drawn: what it would show there a source finds
    /// ([`LayerSource`](super::super::source::LayerSource)).
    pub holes: BlockMask,
}
