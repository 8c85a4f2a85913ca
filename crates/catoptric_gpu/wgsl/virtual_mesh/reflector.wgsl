// A reflector's own picture: its triangles, whatever stands before it.

//#include "scene/records.wgsl"
//#include "virtual_mesh/reflection.wgsl"

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) number: u32,
}

@vertex
fn reflector_corner(@builtin(vertex_index) index: u32) -> Corner {
    let triangle = index / 3u;
    let position = vertex_of(corners_of(triangle)[index % 3u]).position;
    return Corner(reflection.clip_from_world * vec4f(position, 1.0), triangle + 1u);
}

@fragment
fn reflector_number(corner: Corner) -> @location(0) u32 {
    return corner.number;
}
