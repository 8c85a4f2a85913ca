// Records for the picture in a smooth reflector, which is found on the device. The twin of `Reflection` is in
// `src/layout/virtual_mesh.rs`.

// One reflector in one view.
struct Reflection {
    // From the world to the clip space of the reflector's own picture.
    clip_from_world: mat4x4f,
    // The part of the view's picture that this shows, in pixels.
    low: vec2f,
    size: vec2f,
    // The corners of what of that part lies in the view's picture, in pixels.
    shown_low: vec2f,
    shown_high: vec2f,
    // The reflector's box, and half its diagonal.
    box_low: vec3f,
    radius: f32,
    box_high: vec3f,
    object: u32,
    // The view's axis; the nearest depth, and in orthographic views the farthest.
    axis: vec3f,
    near: f32,
    far: f32,
    // Edges are divided until their middles are this near to where they belong; pieces are no smaller, in pixels.
    edge_error_px: f32,
    piece_px: f32,
    // Edges are no shorter, in scene units.
    shortest: f32,
    // The reflector's own vertices and triangles: the first, and that after the last.
    own_vertices: vec2u,
    own_triangles: vec2u,
    vertex_count: u32,
    triangle_count: u32,
    // Room in the tables: for appearances, for pieces that are divided, and for those that are drawn.
    most_appearances: u32,
    most_pieces: u32,
    most_drawn: u32,
    // The place of the arguments that it is drawn with.
    number: u32,
    most_points: u32,
    // 0: it is convex, and shows every point once, and nothing of itself.
    shows_itself: u32,
    // Axes of the map of directions from the reflector's middle; the radius of the sphere that holds the scene.
    map_x: vec3f,
    far_radius: f32,
    map_y: vec3f,
    unused2: f32,
    map_z: vec3f,
    unused3: f32,
}

// A vertex of the scene, or the middle of an edge, with its appearances.
struct Point {
    position: vec3f,
    // The first of them, and how many there are.
    first: u32,
    // The weights of the source triangle's second and third vertex, unless the point is a vertex of the scene.
    weights: vec2f,
    count: u32,
    unused: u32,
}

// Where a point appears.
struct Appearance {
    image_px: vec2f,
    // The homogeneous coordinate, and the path's length along the view's axis.
    w: f32,
    depth: f32,
    // Changes of the image's column and row with the point.
    change_x: vec3f,
    state: u32,
    change_y: vec3f,
    // Not 0: rays have crossed on the way.
    is_turned: u32,
}

// The states of an appearance: the point appears nowhere; in the reflector; beside it, where drawing is cut off.
const NOWHERE = 0u;
const WITHIN = 1u;
const BESIDE_IT = 2u;

// A part of a triangle: its corners among the points.
struct Piece {
    corners: vec3u,
    source: u32,
}

@group(2) @binding(0) var<uniform> reflection: Reflection;

// Texels along a side of a reflector's own picture, and rays along a side of the grid in it from which searches begin.
const PICTURE_SIDE = 512u;
const GRID_SIDE = 32u;
