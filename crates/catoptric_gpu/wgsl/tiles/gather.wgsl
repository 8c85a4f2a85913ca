// What is seen, directly or after some events, from a picture's texture into the table of hits.

//#include "scene/records.wgsl"
//#include "optics/step.wgsl"
//#include "tiles/cells.wgsl"

// Events before what the picture shows.
override EVENTS: u32 = 0u;

@group(1) @binding(0) var<storage, read_write> hits: array<vec4u>;
@group(1) @binding(1) var seen: texture_2d<u32>;
@group(1) @binding(2) var seen_samples: texture_multisampled_2d<u32>;

fn hit_of(halves: vec4u) -> u32 {
    return halves.x | (halves.y << 16u);
}

fn is_in_picture(pixel: vec2u) -> bool {
    return pixel.x < frame.width && pixel.y < frame.height;
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
    hits[hit_index(cell, EVENTS, 0u)] = all;
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
    hits[hit_index(cell, EVENTS, 0u)] = all;
}
