// Paths whose first hits are in the table of hits.

//#include "light/paths/follow.wgsl"

// True if there are paths longer than those that tiles have followed.
override TRACES: bool = true;
// Where light is looked up each sample has so many rays of surfaces that spread light, as on the processor; 0: each
// pixel has `RAYS_A_PIXEL`.
override RAYS_A_SAMPLE: f32 = 0.0;

fn hit_on_path(segment: Segment, place: PictureRay) -> u32 {
    let is_beside = (spreads_light() && segment.is_cone) || (HAS_LOBES && segment.beside_tiles > 0u);
    let is_traced = segment.order > frame.tiled_events || is_beside;
    if TRACES && is_traced {
        return traced_hit(segment);
    }
    return known_hit(hits[hit_index(place.cell, segment.order, segment.kinds)], segment, place.ray, place.samples);
}

// Where directions change by more than this within a pixel, they change unevenly: its samples are followed apart.
// Chosen between time and error: at three times as much a teapot of many triangles has 0.02 % more wrong pixels.
const EVEN_CHANGE = 0.03;

// The hit of one of a cell's rays, or that of four samples which are shaded as one. Where light is looked up, what is
// seen directly is all that is known.
fn known_hit(found: vec4u, segment: Segment, ray: u32, samples: u32) -> u32 {
    if SAMPLES != RAYS || samples != RAYS || frame.tiled_events == 0u {
        return found[ray];
    }
    let change = segment.change;
    let most = max(dot(change.direction_dx, change.direction_dx), dot(change.direction_dy, change.direction_dy));
    shows_several = shows_several || !(most <= EVEN_CHANGE * EVEN_CHANGE);
    return shared_hit(found, segment.ray);
}

// The radiance that arrives at a position of the picture along all paths of a ray of a cell, which stands for so many
// samples.
fn path_radiance(position: vec2f, cell: vec2u, ray: u32, side: f32, samples: u32) -> vec3f {
    let rays = max(floor(select(RAYS_A_PIXEL * side * side, RAYS_A_SAMPLE, RAYS_A_SAMPLE > 0.0)), 1.0);
    // The rays of four samples make up an even pattern together; other pixels have others.
    let are_four = SAMPLES == 4u && side < 1.0;
    let moved = moved_by(vec3f(select(position, floor(position), are_four), 0.0), vec3f(0.0));
    var numbers = RayNumbers(moved, 0u, 1u, rays);
    if are_four {
        numbers = RayNumbers(moved, ray, 4u, 4.0 * rays);
    }
    let place = PictureRay(position, cell, ray, side, samples, rays, numbers);
    let first = eye_segment(position, side);
    let hit = known_hit(hits[hit_index(cell, 0u, 0u)], first, ray, samples);
    return finite(light_along(first, hit, place));
}
