// Traces the rays of paths that tiles could not follow, block by block.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "light/trace.wgsl"
//#include "tiles/cells.wgsl"
//#include "tiles/work.wgsl"
//#include "tiles/path_ray.wgsl"

// The hits of a block's rays.
var<workgroup> found: array<u32, 64>;

// A thread a ray of a block of sixteen cells.
@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    if thread == 0u {
        atomicAdd(&work[TRACED_BLOCKS], 1u);
    }
    let origin = unpacked(atomicLoad(&work[tiling.traced_queue + group.x]));
    let cell = origin + cell_in_tile(thread / RAYS);
    let is_in_picture = all(cell < frame.cells);
    let ray = thread % RAYS;
    let index = hit_index(cell, tiling.events, tiling.kinds);
    var hit = UNRESOLVED;
    if is_in_picture {
        hit = hits[index][ray];
    }
    if is_in_picture && hit == UNRESOLVED {
        let last = path_ray(cell, ray, chain_of(cell));
        if last.is_active {
            let triangle = nearest(frame.root, last.ray, 0.0, FAR, last.own, 0u).triangle;
            hit = 0u;
            if triangle != NONE {
                let object = object_of(triangle);
                let role = surface_of(object).role;
                let reflects = select(0u, HIT_REFLECTS, role != DIFFUSE);
                hit = (triangle + 1u) | reflects | select(0u, HIT_REFRACTS, role == LENS);
                hit |= select(0u, HIT_REFLECTS | HIT_BLURRED, has_lobes(object));
            }
        }
    }
    // A cell is written by one thread: a component of a vector is not a place of its own.
    found[thread] = hit;
    workgroupBarrier();
    if is_in_picture && ray == 0u {
        hits[index] = vec4u(found[thread], found[thread + 1u], found[thread + 2u], found[thread + 3u]);
    }
}
