//! Records of the scene's tables, as the shaders read them: twins of those in `wgsl/scene/records.wgsl`.
//!
//! A test compares their sizes and the offsets of all fields with the shaders'.

#[macro_use]
mod flags;
mod lobes;
mod lookups;
mod rough;
mod virtual_mesh;

pub use lobes::{LobesRecord, lobe_flags};
pub use lookups::{FieldRegion, FieldSlab, Layer, LayerGroup, MAX_VIEWPOINTS, ReflectorMap};
pub use rough::{GRIDS, Grids, LIGHT_BYTES, MOST_REDUCTIONS, PASSAGE_BYTES, SHARP_BYTES, WORD_BYTES};
pub use virtual_mesh::{Appearance, GRID_SIDE, PICTURE_SIDE, Piece, Point, Reflection, START_RAY_BYTES};

use bytemuck::{Pod, Zeroable};

/// An index that points to nothing.
pub const NONE: u32 = u32::MAX;
/// The most lights of a scene.
pub const MAX_LIGHTS: usize = 1000;
/// Texels of a row of the picture that holds those of all textures.
pub const TEXEL_ROW: usize = 8192;
/// The most mip levels of a texture: those of a side of 32,768 texels.
pub const MAX_LEVELS: usize = 16;
/// The environment's maps: of irradiance, then of highlights.
pub const ENVIRONMENT_MAPS: usize = 8;
/// The most reductions of the environment's picture: those of a width of 32,768 texels.
pub const MAX_REDUCTIONS: usize = 12;
/// The most specular events of a path.
pub const MAX_ORDER: u32 = 16;
/// The most children of the nodes of the hierarchy that tiles walk.
pub const WIDTH: usize = 8;
/// The deepest hierarchy that shaders can walk.
pub const MAX_DEPTH: usize = 64;

/// The union of those bits that are to be set.
pub(crate) fn bits(all: &[(u32, bool)]) -> u32 {
    all.iter().filter(|(_, is_set)| *is_set).fold(0, |bits, (bit, _)| bits | bit)
}

/// Bits of [`Surface::flags`].
pub mod surface_flags {
    flags! {
        /// The base colour is radiance.
        UNLIT = 0;
        /// The reflectance rises to 1 at grazing angles.
        SCHLICK = 1;
        /// The inner side alone is a mirror.
        INSIDE = 2;
        /// The surface is a metallic-roughness one.
        MICROFACETS = 3;
        /// The share of reflection depends on the angle.
        RAMP = 4;
        /// The share of reflection depends on the distance.
        ATTENUATION = 5;
        /// A mirror's own light has another colour than its tint.
        OWN_COLOR = 6;
        /// The surface has holes where alpha is low.
        ALPHA_TESTED = 7;
        /// Rays that leave the outer side never meet it again.
        CONVEX = 8;
        /// The object has an inside.
        CLOSED = 9;
        /// The surface is given by a formula.
        EXACT = 10;
        /// The surface sends light of its own, beside what it reflects and refracts.
        OWN_LIGHT = 11;
        /// The reflection is blended with the surface's own colour.
        BLEND = 12;
    }
}

/// Bits of [`Frame::flags`].
pub mod frame_flags {
    flags! {
        /// All rays start at the eye.
        PERSPECTIVE = 0;
        /// Triangles of one surface that meet in a pixel are shaded apart.
        APART = 1;
    }
}

/// The places of a surface's textures in [`Surface::bindings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingPlace {
    /// Base colour.
    Base,
    /// Emitted light.
    Emissive,
    /// Roughness and metalness.
    Facets,
    /// Normals.
    Normals,
    /// Occlusion.
    Occlusion,
    /// The share of a coat.
    Coat,
    /// Normals of a coat.
    CoatNormals,
}

/// Textures of a surface.
pub const BINDINGS: usize = 7;

/// A vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// In the world.
    pub position: [f32; 3],
    /// First texture coordinate of the first set.
    pub u0: f32,
    /// Unit normal.
    pub normal: [f32; 3],
    /// Second texture coordinate of the first set.
    pub v0: f32,
    /// Linear colour.
    pub color: [f32; 4],
    /// Along the normal map's u, and the sign of the bitangent.
    pub tangent: [f32; 4],
    /// The second set of texture coordinates.
    pub uv1: [f32; 2],
    /// A number that is equal in triangles of one smooth surface; 0: the vertex's triangles are none.
    pub part: u32,
    /// Padding.
    pub unused: u32,
}

/// A node of the hierarchy over triangles: the boxes of two children, and what they are: the number of a node, or
/// [`LEAF`], eight times the place of the first triangle, and the number of triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Node {
    /// Lower corner of the first child's box.
    pub low0: [f32; 3],
    /// The first child.
    pub child0: u32,
    /// Upper corner of its box.
    pub high0: [f32; 3],
    /// Padding.
    pub unused0: u32,
    /// Lower corner of the second child's box.
    pub low1: [f32; 3],
    /// The second child.
    pub child1: u32,
    /// Upper corner of its box.
    pub high1: [f32; 3],
    /// Padding.
    pub unused1: u32,
}

/// The kind of surfaces where an expression is zero: `curved` begins with one over the size and the factor on the
/// expression, `twisted` with the place of its program's first step among the texels of objects, and their number.
pub const EXPRESSION: u32 = 4;

/// Children of [`Node`]s with this bit are leaves.
pub const LEAF: u32 = 1 << 31;

/// A child of a node of the hierarchy that tiles walk.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct WideChild {
    /// Lower corner of its box.
    pub low: [f32; 3],
    /// As in [`Node`], with numbers of wide nodes; [`NONE`]: there is none.
    pub code: u32,
    /// Upper corner of its box.
    pub high: [f32; 3],
    /// Padding.
    pub unused: u32,
}

impl Default for WideChild {
    fn default() -> Self {
        Self { low: [f32::MAX; 3], code: NONE, high: [-f32::MAX; 3], unused: 0 }
    }
}

/// Bits of hits: numbers of triangles and 1.
pub mod hit_flags {
    /// Light is reflected there.
    pub const HIT_REFLECTS: u32 = 1 << 30;
    /// Light is refracted there.
    pub const HIT_REFRACTS: u32 = 1 << 31;
    /// The geometry of a path goes on from there by reflection.
    pub const HIT_LIST_REFLECTS: u32 = 1 << 28;
    /// And by refraction.
    pub const HIT_LIST_REFRACTS: u32 = 1 << 29;
    /// Tiles follow no ray from there: the light is known, or found by rays of lobes.
    pub const HIT_BLURRED: u32 = 1 << 27;
    /// All of them with their names in shaders.
    pub const ALL: &[(&str, u32)] = &[
        ("HIT_REFLECTS", HIT_REFLECTS),
        ("HIT_REFRACTS", HIT_REFRACTS),
        ("HIT_LIST_REFLECTS", HIT_LIST_REFLECTS),
        ("HIT_LIST_REFRACTS", HIT_LIST_REFRACTS),
        ("HIT_BLURRED", HIT_BLURRED),
    ];
}

/// Bits of [`LeafTriangle::flags`].
pub mod triangle_flags {
    flags! {
        /// The triangle casts shadows.
        HIDES_LIGHTS = 0;
        /// The alpha of the triangle's texture is tested.
        MAY_HAVE_HOLES = 1;
        /// The triangle's winding is opposite to its normals.
        TURNED = 2;
        /// The triangle's surface reflects.
        REFLECTS = 3;
        /// The triangle's surface refracts.
        REFRACTS = 4;
        /// The triangle belongs to a rough mirror or coat.
        IS_ROUGH = 5;
        /// Rays follow lobes of the triangle's surface.
        SPREADS = 6;
        /// Some of the light that arrives at the triangle's surface, which is no lens, goes straight on.
        PASSES = 7;
    }
}

/// A triangle of a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LeafTriangle {
    /// The first corner.
    pub a: [f32; 3],
    /// The scene's triangle.
    pub triangle: u32,
    /// The second corner.
    pub b: [f32; 3],
    /// The object that the triangle belongs to.
    pub object: u32,
    /// The third corner.
    pub c: [f32; 3],
    /// See [`triangle_flags`].
    pub flags: u32,
}

/// A texture of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Binding {
    /// The columns of the matrix from the vertex's to the texture's coordinates.
    pub matrix: [f32; 4],
    /// The translation behind that matrix.
    pub translation: [f32; 2],
    /// The texture, or [`NONE`].
    pub texture: u32,
    /// The set of texture coordinates.
    pub channel: u32,
}

impl Default for Binding {
    fn default() -> Self {
        Self { matrix: [1.0, 0.0, 0.0, 1.0], translation: [0.0; 2], texture: NONE, channel: 0 }
    }
}

/// A surface given by a formula about a centre, within a box along its own axes: a polynomial of second degree, or one
/// whose numbers are in `curved` and `twisted`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ExactSurface {
    /// The centre in the world.
    pub center: [f32; 3],
    /// The formula's value at the centre.
    pub value: f32,
    /// The formula's gradient at the centre.
    pub gradient: [f32; 3],
    /// The box's diagonal.
    pub size: f32,
    /// Second derivatives xx, yy and zz.
    pub curved: [f32; 3],
    /// 0: of second degree; a torus (1), a surface of revolution (2), a superquadric (3), or an [`EXPRESSION`].
    pub kind: u32,
    /// Second derivatives yz, zx and xy.
    pub twisted: [f32; 3],
    /// Padding.
    pub unused1: f32,
    /// The box's axes in the world, with padding.
    pub axes: [[f32; 4]; 3],
    /// The box's lower corner along its axes, from the centre.
    pub low: [f32; 3],
    /// Padding.
    pub unused5: f32,
    /// The box's upper corner along its axes, from the centre.
    pub high: [f32; 3],
    /// Padding.
    pub unused6: f32,
}

/// An object with its material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Surface {
    /// 0 diffuse, 1 reflector, 2 lens, 3 coated.
    pub role: u32,
    /// See [`surface_flags`].
    pub flags: u32,
    /// Index of refraction.
    pub ior: f32,
    /// The diagonal of the object's box.
    pub extent: f32,
    /// Linear, with alpha.
    pub base_color: [f32; 4],
    /// Emitted radiance.
    pub emissive: [f32; 3],
    /// The share of a clear coat that reflects.
    pub coat: f32,
    /// Absorption inside a lens, a unit of length.
    pub absorption: [f32; 3],
    /// Perceptual roughness of highlights on a mirror; below 0: there are none.
    pub highlight_roughness: f32,
    /// Reflectance of the dielectric at normal incidence.
    pub specular: [f32; 3],
    /// The same at grazing angles.
    pub specular_at_grazing: f32,
    /// Albedo of a mirror's own light.
    pub own_color: [f32; 3],
    /// Alpha below which there is a hole.
    pub alpha_cutoff: f32,
    /// 0 for dielectrics to 1 for metals.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// The share of a coat whose highlights alone are drawn.
    pub facets_coat: f32,
    /// The perceptual roughness of that coat.
    pub facets_coat_roughness: f32,
    /// Least and greatest share of reflection by the angle.
    pub ramp: [f32; 2],
    /// The same by the distance.
    pub attenuation: [f32; 2],
    /// The distance from which on the share is the least.
    pub attenuation_distance: f32,
    /// The factor on the normal map's slopes.
    pub normal_scale: f32,
    /// How much of the occlusion map counts.
    pub occlusion_strength: f32,
    /// Perceptual roughness with which a mirror or coat reflects; 0: sharply.
    pub mirror_roughness: f32,
    /// The place among the textures of the map that turns the rays which leave a mirror, glass or coat, or [`NONE`].
    pub turning_map: u32,
    /// The factor on that map's slopes.
    pub turning_scale: f32,
    /// The texel among those of objects where the lobes begin that rays follow, or [`NONE`]: see [`LobesRecord`].
    pub lobes: u32,
    /// Padding.
    pub unused: f32,
    /// The exact surface.
    pub exact: ExactSurface,
    /// Textures: see [`BindingPlace`].
    pub bindings: [Binding; BINDINGS],
}

/// A mip level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Level {
    /// Width and height in texels.
    pub size: [f32; 2],
    /// The level's first texel among those of all textures.
    pub first: u32,
    /// Texels from row to row.
    pub stride: u32,
}

/// A texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct TextureRecord {
    /// Width and height of the finest level, in texels.
    pub size: [f32; 2],
    /// The index of the coarsest level; below 0 where levels are not used.
    pub last_level: f32,
    /// 1 where the nearest level is taken, not a blend of two.
    pub nearest_level: f32,
    /// Half a texel where magnified texels are blended.
    pub magnified_half: f32,
    /// The same for minified ones.
    pub minified_half: f32,
    /// 0 clamped, 1 repeated, 0.5 mirrored.
    pub wrap: [f32; 2],
    /// The levels.
    pub levels: [Level; MAX_LEVELS],
}

/// A light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightRecord {
    /// In the world.
    pub position: [f32; 3],
    /// 0 directional, 1 point, 2 spot.
    pub kind: u32,
    /// The direction of its light.
    pub direction: [f32; 3],
    /// Where it ends; 0: nowhere.
    pub range: f32,
    /// Linear colour times intensity.
    pub intensity: [f32; 3],
    /// Cosine of the angle at which a spot begins to fade.
    pub inner_cos: f32,
    /// And at which it is gone.
    pub outer_cos: f32,
    /// Padding.
    pub unused: [f32; 3],
}

/// The values that are the same for a whole frame.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Frame {
    /// The columns of the matrix to clip space.
    pub clip_from_world: [[f32; 4]; 4],
    /// The eye, or where the ray through the picture's corner starts.
    pub origin: [f32; 3],
    /// See [`frame_flags`].
    pub flags: u32,
    /// Through the picture's corner at distance 1 along the axis, or the common direction.
    pub direction: [f32; 3],
    /// The most specular events of a path.
    pub order: u32,
    /// The step to the next column.
    pub right: [f32; 3],
    /// The picture's width, in pixels.
    pub width: u32,
    /// The step to the next row.
    pub down: [f32; 3],
    /// The picture's height, in pixels.
    pub height: u32,
    /// Lights in use.
    pub light_count: u32,
    /// The hierarchy's root: see [`Node`]; [`NONE`] without triangles.
    pub root: u32,
    /// The first row of the band that is drawn.
    pub first_row: u32,
    /// The diagonal of the scene's box.
    pub extent: f32,
    /// Columns and rows of cells of four rays in the band.
    pub cells: [u32; 2],
    /// The most events of paths whose rays tiles have followed.
    pub tiled_events: u32,
    /// The place of the queue of tiles that are shaded path by path.
    pub followed: u32,
    /// Width, height and first row of each of the environment's maps; the fourth number of the first is that of its
    /// picture's reductions.
    pub maps: [[u32; 4]; ENVIRONMENT_MAPS],
    /// The same of those reductions.
    pub reductions: [[u32; 4]; MAX_REDUCTIONS],
    /// The place of a single sample from the pixel's corner.
    pub sample_place: [f32; 2],
    /// The side of the square that it stands for, in pixels.
    pub sample_side: f32,
    /// Suns of the sky, behind the lights in use.
    pub sun_count: u32,
}

/// The path that a pass of tiles works on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Tiling {
    /// Events of the path before its last ray.
    pub events: u32,
    /// A bit an event, set where light is refracted.
    pub kinds: u32,
    /// The place of the queue of tiles in the table of work.
    pub queue: u32,
    /// The place of the queue of blocks whose rays are traced.
    pub traced_queue: u32,
    /// The place of the queue of tiles to be shaded path by path, or [`NONE`] if they are known.
    pub shade_queue: u32,
    /// Not 0: some rays' hits are known.
    pub some_known: u32,
    /// Padding.
    pub unused: [u32; 2],
}

/// The scene in a flat mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MirrorPath {
    /// The columns of the matrix from the scene to clip space.
    pub clip_from_scene: [[f32; 4]; 4],
    /// The mirror's plane: the product with `(p, 1)` is how far a point `p` lies in front of the mirror.
    pub plane: [f32; 4],
    /// The mirror, from 1.
    pub mirror: u32,
    /// The number of the path in which the mirror is seen; 0: directly.
    pub parent: u32,
    /// The path's own number, from 1.
    pub number: u32,
    /// Padding.
    pub unused: u32,
}

/// The geometry that appears at the end of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct PathList {
    /// The object of the path's last event.
    pub object: u32,
    /// The number of the path before that; 0: what is seen directly.
    pub parent: u32,
    /// The path's own number, from 1.
    pub number: u32,
    /// Padding.
    pub unused: u32,
}

/// A corner of such geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ListCorner {
    /// In clip space, with reversed depth.
    pub position: [f32; 4],
    /// The weights of the triangle's second and third vertex.
    pub at: [f32; 2],
    /// The triangle as it is hit.
    pub hit: u32,
    /// The number of the choice of blocks where no geometry goes on from there, or 0.
    pub blocks: u32,
}
