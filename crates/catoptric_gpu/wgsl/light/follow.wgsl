// All paths of a ray. The shader that includes this says what they meet: the root of the hierarchy that is traced
// (`root_of_paths`), and what lies beyond, by a path that ends there (`light_beyond`, `distance_beyond`).

//#include "light/paths.wgsl"

// True if there are paths longer than those that tiles have followed.
override TRACES: bool = true;

// The radiance that arrives at a position of the picture along all paths of a ray of a cell, which stands for so many samples.
fn path_radiance(position: vec2f, cell: vec2u, ray: u32, side: f32, samples: u32) -> vec3f {
    var segment = eye_segment(position, side);
    var waiting: array<Segment, MAX_ORDER>;
    var count = 0u;
    var hit = hits[hit_index(cell, 0u, 0u)][ray];
    var sum = vec3f(0.0);
    loop {
        var children: Children;
        // Rays that tiles have not followed have no direction but for rounding: total internal reflection.
        let shown = select(triangle_of(hit), NONE, hit == UNRESOLVED);
        if shown != NONE {
            let last = segment.order >= frame.order || (hit & HIT_REFLECTS) == 0u;
            children = arrive(segment, shown, samples, last);
            sum += children.sum;
        } else {
            var throughput = segment.throughput;
            if HAS_ATTENUATION && segment.deferred != NONE {
                let weight = attenuation_weight(segment.deferred, distance_beyond(segment));
                sum += settled(segment, weight);
                throughput *= weight;
            }
            sum += throughput * light_beyond(segment);
        }
        if children.goes_on[REFLECT] {
            segment = children.segments[REFLECT];
            // Each event on the way has left one at most.
            if HAS_LENSES && children.goes_on[TRANSMIT] && count < MAX_ORDER {
                waiting[count] = children.segments[TRANSMIT];
                count++;
            }
        } else if HAS_LENSES && children.goes_on[TRANSMIT] {
            segment = children.segments[TRANSMIT];
        } else if HAS_LENSES && count > 0u {
            count--;
            segment = waiting[count];
        } else {
            break;
        }
        if TRACES && segment.order > frame.tiled_events {
            hit = (nearest(root_of_paths(), segment.ray, 0.0, FAR, segment.own, false).triangle + 1u) | HIT_REFLECTS;
        } else {
            hit = hits[hit_index(cell, segment.order, segment.kinds)][ray];
        }
    }
    return finite(sum);
}
