// The hierarchy over all triangles, and what of its own object a ray can meet: the twin of the tiles' `OwnRule`.

// The boxes of two children, and what these are: see `hierarchy.rs`.
struct Node {
    low0: vec3f,
    child0: u32,
    high0: vec3f,
    unused0: u32,
    low1: vec3f,
    child1: u32,
    high1: vec3f,
    unused1: u32,
}

struct LeafTriangle {
    a: vec3f,
    triangle: u32,
    b: vec3f,
    object: u32,
    c: vec3f,
    flags: u32,
}

@group(1) @binding(0) var node_table: texture_2d<u32>;
@group(1) @binding(1) var leaf_table: texture_2d<u32>;
// Eight children a node: boxes, and what they are.
@group(1) @binding(2) var wide_table: texture_2d<u32>;

// Texels of a record.
const NODE_TEXELS = 4u;
const LEAF_TRIANGLE_TEXELS = 3u;

fn node_of(index: u32) -> Node {
    let first = textureLoad(node_table, row_of(index * NODE_TEXELS), 0);
    let second = textureLoad(node_table, row_of(index * NODE_TEXELS + 1u), 0);
    let third = textureLoad(node_table, row_of(index * NODE_TEXELS + 2u), 0);
    let fourth = textureLoad(node_table, row_of(index * NODE_TEXELS + 3u), 0);
    return Node(
        bitcast<vec3f>(first.xyz), first.w,
        bitcast<vec3f>(second.xyz), 0u,
        bitcast<vec3f>(third.xyz), third.w,
        bitcast<vec3f>(fourth.xyz), 0u,
    );
}

fn leaf_triangle_of(place: u32) -> LeafTriangle {
    let first = textureLoad(leaf_table, row_of(place * LEAF_TRIANGLE_TEXELS), 0);
    let second = textureLoad(leaf_table, row_of(place * LEAF_TRIANGLE_TEXELS + 1u), 0);
    let third = textureLoad(leaf_table, row_of(place * LEAF_TRIANGLE_TEXELS + 2u), 0);
    return LeafTriangle(
        bitcast<vec3f>(first.xyz), first.w,
        bitcast<vec3f>(second.xyz), second.w,
        bitcast<vec3f>(third.xyz), third.w,
    );
}

// Children with this bit are leaves: the place of the first triangle, times 8, and their number.
const LEAF = 0x80000000u;
// Flags of a leaf's triangles.
const HIDES_LIGHTS = 1u;
const MAY_HAVE_HOLES = 2u;
// The winding is opposite to the normals.
const TURNED = 4u;
// The triangle's surface reflects, and refracts.
const REFLECTS = 8u;
const REFRACTS = 16u;
// The triangle's surface is a rough mirror or coat.
const IS_ROUGH = 32u;
// Rays follow lobes of the triangle's surface.
const SPREADS = 64u;
// Some of the light that arrives, at no lens, goes straight on.
const PASSES = 128u;

// Faces of an object that is not closed count from behind only at this share of its extent.
const AROUND = 0.05;
// Within a lens its surface is met before things that touch it from without.
const TOUCHING = 1e-4;
const FAR = 3e38;

// The part of the object that a ray has left which the ray can still meet.
struct OwnRule {
    object: u32,
    none: bool,
    outside: bool,
    from_behind: f32,
}

fn own_rule(object: u32, kind: u32, outside: bool) -> OwnRule {
    let flags = surface_of(object).flags;
    let none = (flags & CONVEX) != 0u && outside && kind == REFLECT;
    let from_behind = select(AROUND * surface_of(object).extent, FAR, (flags & CLOSED) != 0u);
    return OwnRule(object, none, outside, from_behind);
}

const NO_RULE = OwnRule(NONE, false, true, 0.0);
