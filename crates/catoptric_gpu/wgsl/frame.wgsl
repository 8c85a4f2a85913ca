// The colours of a picture, from what every ray hits.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "scene/environment.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "scene/shade.wgsl"
//#include "light/trace.wgsl"
//#include "tiles/cells.wgsl"
//#include "tiles/pixels.wgsl"
//#include "light/paths/tabled.wgsl"
//#include "light/paths/whole_scene.wgsl"
//#include "rough/grids.wgsl"
//#include "tiles/followed.wgsl"

// The light of rough mirrors as grids of rays found it: see `rough/grids.wgsl`.
@group(2) @binding(3) var<storage, read> rough_light: array<vec4f>;

fn known_light(object: u32, position: vec2f) -> RoughLight {
    return rough_light_at(object, position);
}

// True if four samples hit one surface on each of their paths.
fn is_one_bundle(cell: vec2u) -> bool {
    // Paths whose hits are known, a bit each, in the order of the table.
    var known = 1u;
    var is_one = frame.order <= frame.tiled_events;
    for (var events = 0u; events <= frame.order && is_one; events++) {
        for (var kinds = 0u; kinds < select(1u, 1u << events, HAS_LENSES); kinds++) {
            let first = select(events, (1u << events) - 1u, HAS_LENSES);
            if (known & (1u << (first + kinds))) == 0u {
                continue;
            }
            let all_hits = hits[hit_index(cell, events, kinds)];
            is_one = is_one && are_of_one_surface(all_hits);
            let next = select(events + 1u, (2u << events) - 1u, HAS_LENSES);
            known |= select(0u, 1u << (next + kinds), goes_on(all_hits.x, REFLECT));
            if HAS_LENSES {
                known |= select(0u, 1u << (next + kinds + (1u << events)), goes_on(all_hits.x, TRANSMIT));
            }
        }
    }
    return is_one;
}

@compute @workgroup_size(8, 8)
fn shade_one_sample(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = vec2u(invocation.x, invocation.y + frame.first_row);
    if !is_in_picture(pixel) {
        return;
    }
    let cell = invocation.xy / 2u;
    let ray = (invocation.x & 1u) | ((invocation.y & 1u) << 1u);
    let hit = hits[hit_index(cell, 0u, 0u)][ray];
    if !is_followed(hit) {
        let color = seen_radiance(vec2f(pixel) + frame.sample_place, triangle_of(hit), frame.sample_side, 1u);
        textureStore(colors, pixel, vec4f(color, 1.0));
    }
}

@compute @workgroup_size(8, 8)
fn shade_four_samples(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = vec2u(invocation.x, invocation.y + frame.first_row);
    if !is_in_picture(pixel) {
        return;
    }
    let ids = hits[hit_index(invocation.xy, 0u, 0u)];
    if is_followed(ids.x | ids.y | ids.z | ids.w) {
        return;
    }
    // One surface is shaded once.
    let is_one = is_one_surface(ids, vec2f(pixel));
    let count = select(4u, 1u, is_one);
    var sum = vec3f(0.0);
    for (var ray = 0u; ray < count; ray++) {
        let place = vec2f(pixel) + select(four_samples[ray], vec2f(0.5), is_one);
        sum += seen_radiance(place, triangle_of(ids[ray]), select(0.5, 1.0, is_one), select(1u, 4u, is_one));
    }
    textureStore(colors, pixel, vec4f(sum / f32(count), 1.0));
}

// The radiance that the shading of mirrors and glass in `tiles/followed.wgsl` asks for.
fn followed_radiance(place: vec2f, cell: vec2u, ray: u32, triangle: u32, side: f32, samples: u32) -> vec3f {
    return path_radiance(place, cell, ray, side, samples);
}

fn is_shaded_once(ids: vec4u, cell: vec2u, pixel: vec2u) -> bool {
    return is_one_bundle(cell);
}
