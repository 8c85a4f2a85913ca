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

// A thread a ray of a block of sixteen cells.
@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    if thread == 0u {
        atomicAdd(&work[TRACED_BLOCKS], 1u);
    }
    let origin = unpacked(atomicLoad(&work[tiling.traced_queue + group.x]));
    let cell = origin + cell_in_tile(thread / RAYS);
    let ray = thread % RAYS;
    if any(cell >= frame.cells) {
        return;
    }
    let index = hit_index(cell, tiling.events, tiling.kinds);
    if hits[index][ray] != UNRESOLVED {
        return;
    }
    let last = path_ray(cell, ray, chain_of(cell));
    if !last.is_active {
        return;
    }
    let triangle = nearest(last.ray, 0.0, FAR, last.own, false).triangle;
    var hit = 0u;
    if triangle != NONE {
        let role = surface_of(object_of(triangle)).role;
        hit = (triangle + 1u) | select(0u, HIT_REFLECTS, role != DIFFUSE) | select(0u, HIT_REFRACTS, role == LENS);
    }
    hits[index][ray] = hit;
}
