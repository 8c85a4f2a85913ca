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
//#include "tiles/followed.wgsl"

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

// What the shading of pixels that show mirrors and glass asks for: see `tiles/followed.wgsl`.
fn followed_radiance(place: vec2f, cell: vec2u, ray: u32, triangle: u32, side: f32, samples: u32) -> vec3f {
    return look_radiance(place, triangle, side, samples);
}

fn is_shaded_once(ids: vec4u, cell: vec2u, pixel: vec2u) -> bool {
    return is_one_surface(ids, vec2f(pixel));
}
