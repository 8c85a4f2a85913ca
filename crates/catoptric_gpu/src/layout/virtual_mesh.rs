//! Records of what smooth reflectors show, found on the device: twins of those in `wgsl/virtual_mesh/reflection.wgsl`.

use bytemuck::{Pod, Zeroable};

/// Texels along a side of a reflector's own picture.
pub const PICTURE_SIDE: u32 = 512;
/// Rays along a side of the grid in it from which searches begin.
pub const GRID_SIDE: u32 = 32;
/// Bytes of such a ray.
pub const START_RAY_BYTES: u64 = 32;

/// A reflector in a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Reflection {
    /// From the world to the clip space of the reflector's own picture.
    pub clip_from_world: [[f32; 4]; 4],
    /// The corner of the part of the view's picture that this shows, in pixels.
    pub low: [f32; 2],
    /// The size of that part, in pixels.
    pub size: [f32; 2],
    /// The corner of the area of that part that lies in the view's picture, in pixels.
    pub shown_low: [f32; 2],
    /// The opposite corner of that area.
    pub shown_high: [f32; 2],
    /// The lower corner of the reflector's box.
    pub box_low: [f32; 3],
    /// Half the box's diagonal.
    pub radius: f32,
    /// The upper corner.
    pub box_high: [f32; 3],
    /// The reflector.
    pub object: u32,
    /// The view's axis.
    pub axis: [f32; 3],
    /// The nearest depth.
    pub near: f32,
    /// In orthographic views the farthest.
    pub far: f32,
    /// Edges are divided until their middles are this near to where they belong, in pixels.
    pub edge_error_px: f32,
    /// Pieces are no smaller, in pixels.
    pub piece_px: f32,
    /// Edges are no shorter, in scene units.
    pub shortest: f32,
    /// The reflector's first vertex, and that after its last.
    pub own_vertices: [u32; 2],
    /// The same of its triangles.
    pub own_triangles: [u32; 2],
    /// Vertices of the scene.
    pub vertex_count: u32,
    /// Triangles of the scene.
    pub triangle_count: u32,
    /// Room for appearances,
    pub most_appearances: u32,
    /// for pieces that are divided,
    pub most_pieces: u32,
    /// and for triangles that are drawn.
    pub most_drawn: u32,
    /// The place of the arguments that it is drawn with.
    pub number: u32,
    /// Room for points.
    pub most_points: u32,
    /// 0: it is convex, and shows every point once, and nothing of itself.
    pub shows_itself: u32,
    /// The first axis of the map of directions from the reflector's middle.
    pub map_x: [f32; 3],
    /// The radius of the sphere about it that holds the scene.
    pub far_radius: f32,
    /// The second axis.
    pub map_y: [f32; 3],
    /// Padding.
    pub unused2: f32,
    /// The third, towards the eye.
    pub map_z: [f32; 3],
    /// Padding.
    pub unused3: f32,
}

/// A vertex of the scene, or the middle of an edge, with its appearances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Point {
    /// Where it is.
    pub position: [f32; 3],
    /// The first of its appearances.
    pub first: u32,
    /// The weights of a triangle's second and third vertex, of points that are no vertices.
    pub weights: [f32; 2],
    /// How many appearances there are.
    pub count: u32,
    /// Padding.
    pub unused: u32,
}

/// Where a point appears in a reflector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Appearance {
    /// The place in the picture, in pixels.
    pub image_px: [f32; 2],
    /// The homogeneous coordinate.
    pub w: f32,
    /// The path's length along the view's axis.
    pub depth: f32,
    /// Change of the image's column with the point.
    pub change_x: [f32; 3],
    /// 0: nowhere; 1: in the reflector; 2: beside it.
    pub state: u32,
    /// Change of its row.
    pub change_y: [f32; 3],
    /// Not 0: rays have crossed on the way.
    pub is_turned: u32,
}

/// A part of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Piece {
    /// The piece's corners among the points.
    pub corners: [u32; 3],
    /// The triangle.
    pub source: u32,
}
