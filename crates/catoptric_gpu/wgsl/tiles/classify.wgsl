// Finds the tiles that have rays of a path.

//#include "scene/records.wgsl"
//#include "optics/step.wgsl"
//#include "tiles/cells.wgsl"
//#include "tiles/work.wgsl"

// Rays that show mirrors or glass, and those on the path whose hits are not known.
const SHOWN = 1u;
const WAITING = 2u;

var<workgroup> found: atomic<u32>;

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
        var known = vec4u(UNRESOLVED);
        if tiling.some_known != 0u {
            known = hits[hit_index(cell, tiling.events, tiling.kinds)];
        }
        var here = 0u;
        for (var ray = 0u; ray < RAYS; ray++) {
            let is_shown = parent[ray] != UNRESOLVED && (parent[ray] & (HIT_REFLECTS | HIT_REFRACTS)) != 0u;
            let is_waiting = goes_on(parent[ray], kind) && known[ray] == UNRESOLVED;
            here |= select(0u, SHOWN, is_shown) | select(0u, WAITING, is_waiting);
        }
        if here != 0u {
            atomicOr(&found, here);
        }
    }
    workgroupBarrier();
    if thread == 0u {
        let all_found = atomicLoad(&found);
        if (all_found & WAITING) != 0u {
            let place = atomicAdd(&work[WAITING_TILES], 1u);
            atomicStore(&work[tiling.queue + place], packed(tile.xy * TILE));
        }
        if all_found != 0u && tiling.shade_queue != NONE {
            let shaded = atomicAdd(&work[SHADED], 1u);
            atomicStore(&work[tiling.shade_queue + shaded], packed(tile.xy * TILE));
        }
    }
}
