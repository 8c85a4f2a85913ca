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
const EXACT = 1024u;
const OWN_LIGHT = 2048u;
const BLEND = 4096u;

// Flags of the frame.
const PERSPECTIVE = 1u;
const APART = 2u;

// Features that a scene has: code for the others is left out of its pipelines.
override HAS_ENVIRONMENT: bool = true;
override HAS_LIGHTS: bool = true;
override HAS_SHADOWS: bool = true;
override HAS_MICROFACETS: bool = true;
override HAS_NORMAL_MAPS: bool = true;
override HAS_HIGHLIGHTS: bool = true;
override HAS_COATS: bool = true;
override HAS_LENSES: bool = true;
override HAS_ATTENUATION: bool = true;
override HAS_EXACT: bool = true;
override HAS_HIGHER_DEGREES: bool = true;
override HAS_EXPRESSIONS: bool = true;
override HAS_HOLES: bool = true;
override HAS_COLORS: bool = true;
override HAS_SECOND_UVS: bool = true;
// Normal maps turn what mirrors, glass or coats reflect and refract; mirrors or coats are rough.
override HAS_TURNS: bool = true;
override HAS_ROUGH: bool = true;
// Rays follow lobes of some surfaces.
override HAS_LOBES: bool = true;
// It is known what surfaces see of the light from infinity, and whose suns are looked at one by one.
override HAS_SKY: bool = true;
override HAS_SUNS: bool = true;
// Geometry that paths show is drawn: its places may be off by parts of a pixel.
override HAS_LISTS: bool = true;
// Mirrors and glass at which paths end show the light from infinity.
override ENDS_IN_ENVIRONMENT: bool = true;
// The first textures of surfaces that any of them has.
override BINDINGS_USED: u32 = 7u;

// Bindings of a surface's textures.
const BASE = 0u;
const EMISSIVE = 1u;
const FACETS = 2u;
const NORMALS = 3u;
const OCCLUSION = 4u;
const COAT = 5u;
const COAT_NORMALS = 6u;
const BINDINGS = 7u;
// Textures of lobes.
const OF_TRANSMISSION = 0u;
const OF_COAT_ROUGHNESS = 1u;
const OF_SPECULAR = 2u;
const OF_SPECULAR_COLOR = 3u;
const LOBE_TEXTURES = 11u;

const MAX_LEVELS = 16u;
// 2 to the power of this texels are in a row of a table.
const TEXEL_ROW_LOG2 = 13u;
const MAX_LIGHTS = 1000u;
const ENVIRONMENT_MAPS = 8u;
const MAX_REDUCTIONS = 12u;

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
    // The root of the hierarchy: a node, a leaf, or NONE.
    root: u32,
    first_row: u32,
    // The diagonal of the scene's box.
    extent: f32,
    // Columns and rows of cells in the band, and how many events of paths tiles have followed.
    cells: vec2u,
    tiled_events: u32,
    // The place of the queue of tiles that are shaded path by path.
    followed: u32,
    // Width, height and first row of each of the environment's maps: of irradiance, then of highlights, roughest first.
    // The fourth number of the first is that of the picture's reductions, whose places follow; that of the third one is
    // the place of the light on surfaces behind the triangles, that of the fourth one the number of lamps and, times
    // 65536, the first reduction without their light, whose row is the fourth number of the reduction's place; that of the
    // fifth is the row where lamps begin.
    maps: array<vec4u, ENVIRONMENT_MAPS>,
    reductions: array<vec4u, MAX_REDUCTIONS>,
    // A pixel's single sample: its place from the pixel's corner, and the side of the square that it stands for, in
    // pixels.
    sample_place: vec2f,
    sample_side: f32,
    // Suns of the sky, behind the lights.
    sun_count: u32,
}

struct Vertex {
    position: vec3f,
    u0: f32,
    normal: vec3f,
    v0: f32,
    color: vec4f,
    tangent: vec4f,
    // Only where it is used.
    uv1: vec2f,
    // See `part_of`.
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

// A surface given by a formula about a centre, within a box along its own axes. Of second degree: a polynomial; of
// others the numbers of the formula are in `curved` and `twisted`, see `scene/exact.wgsl`.
struct ExactSurface {
    center: vec3f,
    value: f32,
    gradient: vec3f,
    size: f32,
    // Second derivatives: xx, yy, zz; then yz, zx, xy.
    curved: vec3f,
    kind: u32,
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

// An object's surface. The numbers of its exact surface and its textures follow it in the table.
struct Surface {
    role: u32,
    flags: u32,
    ior: f32,
    // The diagonal of the object's box.
    extent: f32,
    base_color: vec4f,
    emissive: vec3f,
    coat: f32,
    absorption: vec3f,
    // Below 0: lights make no highlights.
    highlight_roughness: f32,
    specular: vec3f,
    specular_at_grazing: f32,
    own_color: vec3f,
    alpha_cutoff: f32,
    metallic: f32,
    roughness: f32,
    facets_coat: f32,
    facets_coat_roughness: f32,
    ramp: vec2f,
    attenuation: vec2f,
    attenuation_distance: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    // 0: it reflects sharply.
    mirror_roughness: f32,
    // The place of a texture, or NONE.
    turning_map: u32,
    turning_scale: f32,
    // The texel where the lobes begin that rays follow, or NONE.
    lobes: u32,
    unused0: f32,
}

// The lobes of a surface. Their textures follow it in the table.
struct LobesRecord {
    transmission: f32,
    flags: u32,
    coat_normal_scale: f32,
    unused0: f32,
}

// Flags of lobes.
const THIN = 1u;
const PLATE = 2u;
const HAS_INSIDE = 4u;
const BLENDS = 8u;

struct Level {
    size: vec2f,
    first: u32,
    stride: u32,
}

// A texture. Its levels follow it in the table.
struct TextureRecord {
    size: vec2f,
    // The number of the coarsest level; below 0 where levels are not used.
    last_level: f32,
    // 1 where the nearest level is taken, not a blend of two.
    nearest_level: f32,
    magnified_half: f32,
    minified_half: f32,
    // 0 clamped, 1 repeated, 0.5 mirrored.
    wrap: vec2f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// Tables are pictures of four numbers a texel, a record after the other: devices (and above all drivers that draw on
// the processor) read these faster than buffers.
@group(0) @binding(1) var vertex_table: texture_2d<u32>;
@group(0) @binding(2) var triangle_table: texture_2d<u32>;
@group(0) @binding(3) var surface_table: texture_2d<u32>;
@group(0) @binding(4) var texture_table: texture_2d<u32>;
// The texels of all textures, in rows as those of tables: 65535 stands for 1.
@group(0) @binding(5) var texels: texture_2d<u32>;

// A corner in clip space, moved so that a pixel's single sample lies in its middle.
fn shifted(position: vec4f) -> vec4f {
    let step = (vec2f(0.5) - frame.sample_place) * vec2f(2.0, -2.0) / vec2f(f32(frame.width), f32(frame.height));
    return vec4f(position.xy + step * position.w, position.zw);
}

// The place of a texel of a table.
fn row_of(index: u32) -> vec2u {
    return vec2u(index & ((1u << TEXEL_ROW_LOG2) - 1u), index >> TEXEL_ROW_LOG2);
}

// Texels of a record.
const VERTEX_TEXELS = 5u;
const SURFACE_TEXELS = 33u;
const EXACT_AT = 10u;
const BINDINGS_AT = 19u;
const LOBE_BINDINGS_AT = 1u;
const TEXTURE_TEXELS = 18u;
const LEVELS_AT = 2u;

fn vertex_number(vertex: u32, texel: u32) -> vec4f {
    return bitcast<vec4f>(textureLoad(vertex_table, row_of(vertex * VERTEX_TEXELS + texel), 0));
}

fn vertex_of(vertex: u32) -> Vertex {
    let position = vertex_number(vertex, 0u);
    let normal = vertex_number(vertex, 1u);
    var result: Vertex;
    result.position = position.xyz;
    result.u0 = position.w;
    result.normal = normal.xyz;
    result.v0 = normal.w;
    if HAS_COLORS {
        result.color = vertex_number(vertex, 2u);
    }
    if HAS_NORMAL_MAPS {
        result.tangent = vertex_number(vertex, 3u);
    }
    if HAS_SECOND_UVS {
        result.uv1 = vertex_number(vertex, 4u).xy;
    }
    return result;
}

// A number that is equal in triangles of one smooth surface; 0: the vertex's triangles are none.
fn part_of(vertex: u32) -> u32 {
    return bitcast<u32>(vertex_number(vertex, 4u).z);
}

// Three vertices and the object.
fn corners_of(triangle: u32) -> vec4u {
    return textureLoad(triangle_table, row_of(triangle), 0);
}

fn object_of(triangle: u32) -> u32 {
    return corners_of(triangle).w;
}

fn surface_number(object: u32, texel: u32) -> vec4f {
    return bitcast<vec4f>(textureLoad(surface_table, row_of(object * SURFACE_TEXELS + texel), 0));
}

fn surface_of(object: u32) -> Surface {
    let head = surface_number(object, 0u);
    let emissive = surface_number(object, 2u);
    let absorption = surface_number(object, 3u);
    let specular = surface_number(object, 4u);
    let own_color = surface_number(object, 5u);
    let facets = surface_number(object, 6u);
    let shares = surface_number(object, 7u);
    let last = surface_number(object, 8u);
    var result: Surface;
    result.role = bitcast<u32>(head.x);
    result.flags = bitcast<u32>(head.y);
    result.ior = head.z;
    result.extent = head.w;
    result.base_color = surface_number(object, 1u);
    result.emissive = emissive.xyz;
    result.coat = emissive.w;
    result.absorption = absorption.xyz;
    result.highlight_roughness = absorption.w;
    result.specular = specular.xyz;
    result.specular_at_grazing = specular.w;
    result.own_color = own_color.xyz;
    result.alpha_cutoff = own_color.w;
    result.metallic = facets.x;
    result.roughness = facets.y;
    result.facets_coat = facets.z;
    result.facets_coat_roughness = facets.w;
    result.ramp = shares.xy;
    result.attenuation = shares.zw;
    result.attenuation_distance = last.x;
    result.normal_scale = last.y;
    result.occlusion_strength = last.z;
    result.mirror_roughness = last.w;
    let turning = surface_number(object, 9u);
    result.turning_map = bitcast<u32>(turning.x);
    result.turning_scale = turning.y;
    result.lobes = bitcast<u32>(turning.z);
    return result;
}

// True if rays follow lobes of an object's surface.
fn has_lobes(object: u32) -> bool {
    return HAS_LOBES && surface_of(object).lobes != NONE;
}

// A texel of the table of objects.
fn object_number(texel: u32) -> vec4f {
    return bitcast<vec4f>(textureLoad(surface_table, row_of(texel), 0));
}

fn lobes_record_at(first: u32) -> LobesRecord {
    let head = object_number(first);
    return LobesRecord(head.x, bitcast<u32>(head.y), head.z, head.w);
}

// True if there is a medium behind an object's surface, which light enters.
fn has_medium(object: u32) -> bool {
    let surface = surface_of(object);
    var result = HAS_LENSES && surface.role == LENS;
    if HAS_LOBES && surface.lobes != NONE {
        result = (lobes_record_at(surface.lobes).flags & HAS_INSIDE) != 0u;
    }
    return result;
}

fn exact_of(object: u32) -> ExactSurface {
    let center = surface_number(object, EXACT_AT);
    let gradient = surface_number(object, EXACT_AT + 1u);
    var result: ExactSurface;
    result.center = center.xyz;
    result.value = center.w;
    result.gradient = gradient.xyz;
    result.size = gradient.w;
    let curved = surface_number(object, EXACT_AT + 2u);
    result.curved = curved.xyz;
    result.kind = bitcast<u32>(curved.w);
    result.twisted = surface_number(object, EXACT_AT + 3u).xyz;
    result.axis_x = surface_number(object, EXACT_AT + 4u).xyz;
    result.axis_y = surface_number(object, EXACT_AT + 5u).xyz;
    result.axis_z = surface_number(object, EXACT_AT + 6u).xyz;
    result.low = surface_number(object, EXACT_AT + 7u).xyz;
    result.high = surface_number(object, EXACT_AT + 8u).xyz;
    return result;
}

fn binding_at(texel: u32) -> Binding {
    let last = object_number(texel + 1u);
    let numbers = bitcast<vec4u>(last);
    return Binding(object_number(texel), last.xy, numbers.z, numbers.w);
}

fn binding_of(object: u32, index: u32) -> Binding {
    return binding_at(object * SURFACE_TEXELS + BINDINGS_AT + 2u * index);
}

fn texture_number(texture: u32, texel: u32) -> vec4u {
    return textureLoad(texture_table, row_of(texture * TEXTURE_TEXELS + texel), 0);
}

fn texture_of(texture: u32) -> TextureRecord {
    let first = bitcast<vec4f>(texture_number(texture, 0u));
    let second = bitcast<vec4f>(texture_number(texture, 1u));
    return TextureRecord(first.xy, first.z, first.w, second.x, second.y, second.zw);
}

fn level_of(texture: u32, index: u32) -> Level {
    let numbers = texture_number(texture, LEVELS_AT + index);
    return Level(bitcast<vec2f>(numbers.xy), numbers.z, numbers.w);
}
