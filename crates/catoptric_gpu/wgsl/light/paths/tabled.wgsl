// Paths whose first hits are in the table of hits.

//#include "light/paths/follow.wgsl"

// True if there are paths longer than those that tiles have followed.
override TRACES: bool = true;

fn hit_on_path(segment: Segment, place: PictureRay) -> u32 {
    let is_traced = segment.order > frame.tiled_events || (spreads_light() && segment.is_cone);
    if TRACES && is_traced {
        return traced_hit(segment);
    }
    return hits[hit_index(place.cell, segment.order, segment.kinds)][place.ray];
}

// The radiance that arrives at a position of the picture along all paths of a ray of a cell, which stands for so many
// samples.
fn path_radiance(position: vec2f, cell: vec2u, ray: u32, side: f32, samples: u32) -> vec3f {
    let place = PictureRay(position, cell, ray, side, samples, RAYS_A_PIXEL * side * side);
    return finite(light_along(eye_segment(position, side), hits[hit_index(cell, 0u, 0u)][ray], place));
}
