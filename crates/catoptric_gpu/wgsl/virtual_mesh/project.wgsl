// Vertices of the scene to where they appear in a reflector, and the pieces that its triangles begin as.

//#include "virtual_mesh/search.wgsl"
//#include "virtual_mesh/starts.wgsl"
//#include "virtual_mesh/work.wgsl"
//#include "virtual_mesh/points.wgsl"

@compute @workgroup_size(64)
fn take_rays(@builtin(global_invocation_id) invocation: vec3u) {
    let number = invocation.x;
    if number >= GRID_SIDE * GRID_SIDE {
        return;
    }
    let image_px = start_px(number);
    let triangle = triangle_at_px(image_px);
    var taken: StartRay;
    if triangle != NONE {
        let leaving = leaving_at(image_px, triangle);
        taken = StartRay(leaving.ray.origin, f32(leaving.is_there), leaving.ray.direction, 0.0);
    }
    start_rays[number] = taken;
}

// True for vertices or triangles of a reflector that shows nothing of itself.
fn is_skipped(number: u32, own: vec2u) -> bool {
    return reflection.shows_itself == 0u && number >= own.x && number < own.y;
}

@compute @workgroup_size(64)
fn project_vertices(@builtin(global_invocation_id) invocation: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let vertex = invocation.x + invocation.y * groups.x * 64u;
    if vertex >= reflection.vertex_count || is_skipped(vertex, reflection.own_vertices) {
        return;
    }
    points[vertex] = projected(vertex_of(vertex).position, vec2f(0.0), false);
}

@compute @workgroup_size(64)
fn start_pieces(@builtin(global_invocation_id) invocation: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let triangle = invocation.x + invocation.y * groups.x * 64u;
    if triangle >= reflection.triangle_count || is_skipped(triangle, reflection.own_triangles) {
        return;
    }
    // There is room for all.
    let place = atomicAdd(&work[PIECES_NEXT], 1u);
    next_pieces[place] = Piece(corners_of(triangle).xyz, triangle);
}
