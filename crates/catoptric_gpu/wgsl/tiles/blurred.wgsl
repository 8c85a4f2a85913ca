// Marks what is hit on rough mirrors whose light is known: no ray needs to be followed from there.

//#include "scene/records.wgsl"
//#include "optics/step.wgsl"
//#include "tiles/cells.wgsl"
//#include "rough/grids.wgsl"

@group(2) @binding(0) var<storage, read_write> hits: array<vec4u>;
@group(2) @binding(3) var<storage, read> rough_light: array<vec4f>;

@compute @workgroup_size(8, 8)
fn mark_blurred(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    if any(cell >= frame.cells) {
        return;
    }
    let index = hit_index(cell, 0u, 0u);
    var found = hits[index];
    for (var ray = 0u; ray < RAYS; ray++) {
        if (found[ray] & HIT_REFLECTS) == 0u {
            continue;
        }
        let object = object_of(triangle_of(found[ray]));
        if is_rough(object) {
            let light = rough_light_at(object, position_of(cell, ray));
            found[ray] |= select(0u, HIT_BLURRED, light.object != 0u && light.weight >= 1.0);
        }
    }
    hits[index] = found;
}
