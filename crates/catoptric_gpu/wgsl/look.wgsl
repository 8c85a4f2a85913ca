// The colours of pixels that show mirrors and glass, which look light up in maps.

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
//#include "light/paths.wgsl"
//#include "light/maps.wgsl"

// The radiance that arrives at a position of the picture from a triangle, or from behind all: the twin of
// `light/reflector_shader`.
fn look_radiance(position: vec2f, triangle: u32, side: f32, samples: u32) -> vec3f {
    let segment = eye_segment(position, side);
    if triangle == NONE {
        return finite(background(segment.ray.direction));
    }
    var children = arrive(segment, triangle, samples, false);
    let map = reflector_map_of(object_of(triangle));
    var sum = children.sum;
    for (var kind = REFLECT; kind <= TRANSMIT; kind++) {
        if !children.goes_on[kind] {
            continue;
        }
        let child = children.segments[kind];
        var throughput = child.throughput;
        if HAS_ATTENUATION && child.deferred != NONE {
            let weight = attenuation_weight(child.deferred, proxy_distance(map, child.ray));
            sum += settled(child, weight);
            throughput *= weight;
        }
        sum += throughput * map_radiance(map, child.ray, child.change);
    }
    return finite(sum);
}

@compute @workgroup_size(8, 8)
fn look_one_sample(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let in_band = followed_pixel(group, local);
    let pixel = in_band + vec2u(0u, frame.first_row);
    let cell = in_band / 2u;
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let hit = hits[hit_index(cell, 0u, 0u)][(in_band.x & 1u) | ((in_band.y & 1u) << 1u)];
    if is_followed(hit) {
        textureStore(colors, pixel, vec4f(look_radiance(vec2f(pixel) + 0.5, triangle_of(hit), 1.0, 1u), 1.0));
    }
}

@compute @workgroup_size(8, 8)
fn look_four_samples(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let cell = followed_pixel(group, local);
    let pixel = cell + vec2u(0u, frame.first_row);
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let ids = hits[hit_index(cell, 0u, 0u)];
    if !is_followed(ids.x | ids.y | ids.z | ids.w) {
        return;
    }
    let is_one = is_one_surface(ids, vec2f(pixel));
    let count = select(4u, 1u, is_one);
    var sum = vec3f(0.0);
    for (var ray = 0u; ray < count; ray++) {
        let place = vec2f(pixel) + select(four_samples[ray], vec2f(0.5), is_one);
        sum += look_radiance(place, triangle_of(ids[ray]), select(0.5, 1.0, is_one), select(1u, 4u, is_one));
    }
    textureStore(colors, pixel, vec4f(sum / f32(count), 1.0));
}
