// What is seen, directly or on a path, from a picture's texture into the table of hits.

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
// For each object, where the geometry of paths is drawn, the bits of hits that say whether that goes on from it; four a
// texel.
@group(1) @binding(3) var lists_of_objects: texture_2d<u32>;

fn hit_of(halves: vec4u) -> u32 {
    return halves.x | (halves.y << 16u);
}

fn is_in_picture(pixel: vec2u) -> bool {
    return pixel.x < frame.width && pixel.y < frame.height;
}

// The hit of a ray that shows this in the picture, with what lists know of it.
fn known_hit(drawn: u32, parent: u32) -> u32 {
    if !HAS_LISTS {
        return drawn;
    }
    if EVENTS == 0u {
        if drawn == 0u {
            return 0u;
        }
        let object = object_of(triangle_of(drawn));
        return drawn | textureLoad(lists_of_objects, row_of(object / 4u), 0)[object % 4u];
    }
    let kind = (KINDS >> (max(EVENTS, 1u) - 1u)) & 1u;
    let is_known = goes_on(parent, kind) && list_goes_on(parent, kind) && !(HOLES_WAIT && drawn == 0u);
    return select(UNRESOLVED, drawn, is_known);
}

// Those of all rays of a cell.
fn known_hits(cell: vec2u, drawn: vec4u) -> vec4u {
    var parents = vec4u(0u);
    if HAS_LISTS && EVENTS > 0u {
        parents = hits[hit_index(cell, max(EVENTS, 1u) - 1u, KINDS)];
    }
    var known = drawn;
    for (var ray = 0u; ray < RAYS; ray++) {
        known[ray] = known_hit(drawn[ray], parents[ray]);
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
    for (var ray = 0u; ray < RAYS; ray++) {
        let pixel = pixel_of(cell, ray) + vec2u(0u, frame.first_row);
        if is_in_picture(pixel) {
            all[ray] = hit_of(textureLoad(seen, pixel, 0));
        }
    }
    hits[hit_index(cell, EVENTS, KINDS)] = known_hits(cell, all);
}

@compute @workgroup_size(8, 8)
fn gather_four_samples(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    if any(cell >= frame.cells) {
        return;
    }
    var all = vec4u(0u);
    let pixel = cell + vec2u(0u, frame.first_row);
    for (var ray = 0u; ray < RAYS && is_in_picture(pixel); ray++) {
        all[ray] = hit_of(textureLoad(seen_samples, pixel, ray));
    }
    hits[hit_index(cell, EVENTS, KINDS)] = known_hits(cell, all);
}
