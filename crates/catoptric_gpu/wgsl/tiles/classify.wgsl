// Finds the tiles that have rays of a path.

//#include "scene/records.wgsl"
//#include "optics/step.wgsl"
//#include "tiles/cells.wgsl"
//#include "tiles/work.wgsl"

var<workgroup> is_active: atomic<u32>;

@compute @workgroup_size(16, 16)
fn classify(
    @builtin(workgroup_id) tile: vec3u,
    @builtin(global_invocation_id) invocation: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let cell = invocation.xy;
    if all(cell < frame.cells) {
        let parent = hits[hit_index(cell, tiling.events - 1u, tiling.kinds)];
        let kind = (tiling.kinds >> (tiling.events - 1u)) & 1u;
        for (var ray = 0u; ray < RAYS; ray++) {
            if goes_on(parent[ray], kind) {
                atomicStore(&is_active, 1u);
            }
        }
    }
    workgroupBarrier();
    if thread == 0u && atomicLoad(&is_active) != 0u {
        let place = atomicAdd(&work[WAITING_TILES], 1u);
        atomicStore(&work[tiling.queue + place], packed(tile.xy * TILE));
        if tiling.shade_queue != NONE {
            let shaded = atomicAdd(&work[SHADED], 1u);
            atomicStore(&work[tiling.shade_queue + shaded], packed(tile.xy * TILE));
        }
    }
}
