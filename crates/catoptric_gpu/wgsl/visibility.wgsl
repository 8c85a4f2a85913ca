// What is seen directly: the triangles' numbers, drawn by hardware.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"

// Triangles without holes first: at equal depth they are seen.
@group(1) @binding(0) var<storage, read> draw_order: array<u32>;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) triangle: u32,
    @location(1) @interpolate(perspective, sample) at: vec2f,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let triangle = draw_order[index / 3u];
    let place = index % 3u;
    var result: Corner;
    result.position = frame.clip_from_world * vec4f(vertices[triangles[triangle][place]].position, 1.0);
    result.triangle = triangle;
    result.at = vec2f(f32(place == 1u), f32(place == 2u));
    return result;
}

fn id_halves(triangle: u32) -> vec2u {
    let id = triangle + 1u;
    return vec2u(id & 0xffffu, id >> 16u);
}

@fragment
fn solid(seen: Corner) -> @location(0) vec2u {
    return id_halves(seen.triangle);
}

// Surfaces with holes where their alpha is low, decided at every sample.
@fragment
fn with_holes(seen: Corner) -> @location(0) vec2u {
    let dx = dpdx(seen.at);
    let dy = dpdy(seen.at);
    if !is_present(seen.triangle, Barycentrics(seen.at, dx, dy)) {
        discard;
    }
    return id_halves(seen.triangle);
}
