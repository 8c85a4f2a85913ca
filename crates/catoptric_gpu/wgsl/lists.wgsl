// Virtual geometry, drawn by hardware: the appearances at the ends of paths, where the processor has found them.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "tiles/cells.wgsl"
//#include "confined.wgsl"

// The geometry of a path.
struct PathList {
    // The object of the path's last event, and the number of the path before that.
    object: u32,
    parent: u32,
    // The path's own number, from 1.
    number: u32,
    unused: u32,
}

@group(2) @binding(0) var<uniform> path: PathList;

@vertex
fn confined_corner(
    @location(0) position: vec4f,
    @location(1) at: vec2f,
    @location(2) hit: u32,
    @location(3) blocks: u32,
) -> Corner {
    return Corner(shifted(position), hit, at, 1.0, blocks);
}

// True where the object is seen that the path's last event is at.
fn is_seen(triangle: u32) -> bool {
    return object_of(triangle) == path.object;
}
