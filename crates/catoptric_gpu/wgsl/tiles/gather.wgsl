// Copies the hits that a picture shows, directly or on a path, from its texture into the table of hits.

//#include "scene/records.wgsl"
//#include "optics/step.wgsl"
//#include "tiles/cells.wgsl"

// Events before what the picture shows, and their kinds.
override EVENTS: u32 = 0u;
override KINDS: u32 = 0u;
// Where nothing is drawn rays are still to be followed: not all is drawn that there is.
override HOLES_WAIT: bool = false;

@group(1) @binding(0) var<storage, read_write> hits: array<vec4u>;
@group(1) @binding(1) var seen: texture_2d<u32>;
@group(1) @binding(2) var seen_samples: texture_multisampled_2d<u32>;
// For each object, where the geometry of paths is drawn, the bits of hits that say whether that goes on from it, with
// the number of the choice of blocks where it does not. The choices follow, each at as many times its own length as its
// number says: a bit a block, row by row. Four numbers a texel.
@group(1) @binding(3) var lists_of_objects: texture_2d<u32>;

fn hit_of(halves: vec4u) -> u32 {
    return halves.x | (halves.y << 16u);
}

// Blocks of so many pixels a side are chosen.
const BLOCK = 8u;

fn list_number(place: u32) -> u32 {
    return textureLoad(lists_of_objects, row_of(place / 4u), 0)[place % 4u];
}

// True if a pixel is in a block that a choice has.
fn is_chosen(choice: u32, pixel: vec2u) -> bool {
    if choice == 0u {
        return false;
    }
    // Rows begin with words of 64 bits.
    let words = (frame.width + 64u * BLOCK - 1u) / (64u * BLOCK) * 2u;
    let rows = (frame.height + BLOCK - 1u) / BLOCK;
    let block = pixel / BLOCK;
    let word = list_number((choice * rows + block.y) * words + block.x / 32u);
    return ((word >> (block.x % 32u)) & 1u) != 0u;
}

// A hit, without its bits of lists if no geometry goes on from there in the block of a pixel.
fn left_out(hit: u32, choice: u32, pixel: vec2u) -> u32 {
    return select(hit, hit & ~(HIT_LIST_REFLECTS | HIT_LIST_REFRACTS), is_chosen(choice, pixel));
}

fn is_in_picture(pixel: vec2u) -> bool {
    return pixel.x < frame.width && pixel.y < frame.height;
}

// The hit of a ray that shows this in the picture (the hit, and a choice of blocks), with what lists know of it.
fn known_hit(shown: vec2u, parent: u32, pixel: vec2u) -> u32 {
    let drawn = shown.x;
    if !HAS_LISTS {
        return drawn;
    }
    if EVENTS == 0u {
        if drawn == 0u {
            return 0u;
        }
        let object = object_of(triangle_of(drawn));
        let known = list_number(object);
        return drawn | left_out(known & (HIT_LIST_REFLECTS | HIT_LIST_REFRACTS), known & 0xffffu, pixel);
    }
    let kind = (KINDS >> (max(EVENTS, 1u) - 1u)) & 1u;
    let is_known = goes_on(parent, kind) && list_goes_on(parent, kind) && !(HOLES_WAIT && drawn == 0u);
    return select(UNRESOLVED, left_out(drawn, shown.y, pixel), is_known);
}

// The hits of all rays of a cell, as `known_hit`.
fn known_hits(cell: vec2u, drawn: vec4u, choices: vec4u) -> vec4u {
    var parents = vec4u(0u);
    if HAS_LISTS && EVENTS > 0u {
        parents = hits[hit_index(cell, max(EVENTS, 1u) - 1u, KINDS)];
    }
    var known = drawn;
    for (var ray = 0u; ray < RAYS; ray++) {
        let pixel = pixel_of(cell, ray) + vec2u(0u, frame.first_row);
        known[ray] = known_hit(vec2u(drawn[ray], choices[ray]), parents[ray], pixel);
    }
    return known;
}

@compute @workgroup_size(8, 8)
fn gather_one_sample(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    if any(cell >= frame.cells) {
        return;
    }
    var all = vec4u(0u);
    var choices = vec4u(0u);
    for (var ray = 0u; ray < RAYS; ray++) {
        let pixel = pixel_of(cell, ray) + vec2u(0u, frame.first_row);
        if is_in_picture(pixel) {
            let shown = textureLoad(seen, pixel, 0);
            all[ray] = hit_of(shown);
            choices[ray] = shown.w;
        }
    }
    hits[hit_index(cell, EVENTS, KINDS)] = known_hits(cell, all, choices);
}

@compute @workgroup_size(8, 8)
fn gather_four_samples(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    if any(cell >= frame.cells) {
        return;
    }
    var all = vec4u(0u);
    var choices = vec4u(0u);
    let pixel = cell + vec2u(0u, frame.first_row);
    for (var ray = 0u; ray < RAYS && is_in_picture(pixel); ray++) {
        let shown = textureLoad(seen_samples, pixel, ray);
        all[ray] = hit_of(shown);
        choices[ray] = shown.w;
    }
    hits[hit_index(cell, EVENTS, KINDS)] = known_hits(cell, all, choices);
}
