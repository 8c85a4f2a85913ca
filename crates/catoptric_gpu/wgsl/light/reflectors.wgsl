// Reflectors and lenses by the first event alone: light is looked up in environment maps.

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
        var child = children.segments[kind];
        if spreads_light() && children.spread.alpha > 0.0 {
            let cone = cone_of(children.spread, kind, segment.ray.direction, child.ray.direction, child.change);
            child.ray.direction = cone.direction;
            child.change = cone.change;
            child.throughput *= cone.share;
        }
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
