// The scene's tables; the twins of these records are in `src/layout.rs`.

const NONE = 0xffffffffu;

// Roles.
const DIFFUSE = 0u;
const REFLECTOR = 1u;
const LENS = 2u;
const COATED = 3u;

// Flags of surfaces.
const UNLIT = 1u;
const SCHLICK = 2u;
const INSIDE = 4u;
const MICROFACETS = 8u;
const RAMP = 16u;
const ATTENUATION = 32u;
const OWN_COLOR = 64u;
const ALPHA_TESTED = 128u;
const CONVEX = 256u;
const CLOSED = 512u;
const QUADRIC = 1024u;
const OWN_LIGHT = 2048u;
const BLEND = 4096u;

// Flags of the frame.
const PERSPECTIVE = 1u;

// What a scene has: code for the rest is left out of its pipelines.
override HAS_ENVIRONMENT: bool = true;
override HAS_LIGHTS: bool = true;
override HAS_SHADOWS: bool = true;
override HAS_MICROFACETS: bool = true;
override HAS_NORMAL_MAPS: bool = true;
override HAS_HIGHLIGHTS: bool = true;
override HAS_COATS: bool = true;
override HAS_LENSES: bool = true;
override HAS_ATTENUATION: bool = true;
override HAS_QUADRICS: bool = true;
override HAS_HOLES: bool = true;
override HAS_COLORS: bool = true;
// The first textures of surfaces that any of them has.
override BINDINGS_USED: u32 = 6u;

// Bindings of a surface's textures.
const BASE = 0u;
const EMISSIVE = 1u;
const FACETS = 2u;
const NORMALS = 3u;
const OCCLUSION = 4u;
const COAT = 5u;
const BINDINGS = 6u;

const MAX_LEVELS = 16u;
// 2 to the power of this texels are in a row.
const TEXEL_ROW_LOG2 = 13u;
const MAX_LIGHTS = 128u;
const ENVIRONMENT_MAPS = 8u;

struct Light {
    position: vec3f,
    kind: u32,
    direction: vec3f,
    range: f32,
    intensity: vec3f,
    inner_cos: f32,
    outer_cos: f32,
    unused0: f32,
    unused1: f32,
    unused2: f32,
}

struct Frame {
    clip_from_world: mat4x4f,
    origin: vec3f,
    flags: u32,
    direction: vec3f,
    order: u32,
    right: vec3f,
    width: u32,
    down: vec3f,
    height: u32,
    light_count: u32,
    // Of the hierarchy: a node, a leaf, or NONE.
    root: u32,
    first_row: u32,
    unused: u32,
    // Width, height and first row of each of the environment's maps: of irradiance, then of highlights, roughest first.
    maps: array<vec4u, ENVIRONMENT_MAPS>,
    lights: array<Light, MAX_LIGHTS>,
}

struct Vertex {
    position: vec3f,
    u0: f32,
    normal: vec3f,
    v0: f32,
    color: vec4f,
    tangent: vec4f,
    uv1: vec2f,
    // A number that is equal in triangles of one smooth surface; 0: the vertex's triangles are none.
    part: u32,
    unused: u32,
}

struct Binding {
    // The columns of a matrix.
    matrix: vec4f,
    translation: vec2f,
    texture: u32,
    channel: u32,
}

// A polynomial of second degree about a centre, within a box along its own axes.
struct Quadric {
    center: vec3f,
    value: f32,
    gradient: vec3f,
    size: f32,
    // Second derivatives: xx, yy, zz; then yz, zx, xy.
    curved: vec3f,
    unused0: f32,
    twisted: vec3f,
    unused1: f32,
    axis_x: vec3f,
    unused2: f32,
    axis_y: vec3f,
    unused3: f32,
    axis_z: vec3f,
    unused4: f32,
    low: vec3f,
    unused5: f32,
    high: vec3f,
    unused6: f32,
}

struct Surface {
    base_color: vec4f,
    emissive: vec3f,
    role: u32,
    absorption: vec3f,
    flags: u32,
    specular: vec3f,
    specular_at_grazing: f32,
    own_color: vec3f,
    alpha_cutoff: f32,
    metallic: f32,
    roughness: f32,
    facets_coat: f32,
    facets_coat_roughness: f32,
    ior: f32,
    coat: f32,
    // Below 0: lights make no highlights.
    highlight_roughness: f32,
    // Of the object's box.
    extent: f32,
    ramp: vec2f,
    attenuation: vec2f,
    attenuation_distance: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    unused: f32,
    quadric: Quadric,
    bindings: array<Binding, BINDINGS>,
}

struct Level {
    size: vec2f,
    first: u32,
    stride: u32,
}

struct TextureRecord {
    size: vec2f,
    // Of the coarsest level; below 0 where levels are not used.
    last_level: f32,
    // 1 where the nearest level is taken, not a blend of two.
    nearest_level: f32,
    magnified_half: f32,
    minified_half: f32,
    // 0 clamped, 1 repeated, 0.5 mirrored.
    wrap: vec2f,
    levels: array<Level, MAX_LEVELS>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> vertices: array<Vertex>;
// Three vertices and the object.
@group(0) @binding(2) var<storage, read> triangles: array<vec4u>;
@group(0) @binding(3) var<storage, read> surfaces: array<Surface>;
@group(0) @binding(4) var<storage, read> textures: array<TextureRecord>;
// Of all textures, in rows of TEXEL_ROW: 65535 for 1.
@group(0) @binding(5) var texels: texture_2d<u32>;
