// The hits of rays from the eye (see `tiles/cells.wgsl`), drawn by hardware.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "tiles/cells.wgsl"

// Triangles without holes first: at equal depth they are seen.
@group(1) @binding(0) var<storage, read> draw_order: array<u32>;

// A triangle without holes is the same at all samples of a pixel: its fragments are drawn once, and there is nothing to
// be interpolated. Both kinds have the same depths.
struct SolidCorner {
    @builtin(position) @invariant position: vec4f,
    @location(0) @interpolate(flat, either) hit: u32,
}

struct Corner {
    @builtin(position) @invariant position: vec4f,
    @location(0) @interpolate(flat, either) hit: u32,
    @location(1) @interpolate(perspective, sample) at: vec2f,
}

fn place_of_corner(triangle: u32, corner: u32) -> vec4f {
    let position = vec4f(vertex_of(corners_of(triangle)[corner]).position, 1.0);
    return shifted(frame.clip_from_world * position);
}

@vertex
fn solid_corner(@builtin(vertex_index) index: u32) -> SolidCorner {
    let hit = draw_order[index / 3u];
    return SolidCorner(place_of_corner(triangle_of(hit), index % 3u), hit);
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let hit = draw_order[index / 3u];
    let place = index % 3u;
    let at = vec2f(f32(place == 1u), f32(place == 2u));
    return Corner(place_of_corner(triangle_of(hit), place), hit, at);
}

fn halves(hit: u32) -> vec2u {
    return vec2u(hit & 0xffffu, hit >> 16u);
}

@fragment
fn solid(seen: SolidCorner) -> @location(0) vec2u {
    return halves(seen.hit);
}

// Surfaces with holes where their alpha is low, decided at every sample.
@fragment
fn with_holes(seen: Corner) -> @location(0) vec2u {
    let dx = dpdx(seen.at);
    let dy = dpdy(seen.at);
    if !is_present(triangle_of(seen.hit), Barycentrics(seen.at, dx, dy)) {
        discard;
    }
    return halves(seen.hit);
}
