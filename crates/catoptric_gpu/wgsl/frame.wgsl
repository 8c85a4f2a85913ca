// The colours of a picture, from what every ray hits.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "scene/environment.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "scene/shade.wgsl"
//#include "light/trace.wgsl"
//#include "tiles/cells.wgsl"
//#include "light/paths.wgsl"

@group(2) @binding(0) var<storage, read> hits: array<vec4u>;
@group(2) @binding(1) var colors: texture_storage_2d<rgba32float, write>;
// The tiles that are shaded path by path are in it: see `tiles/work.wgsl`.
@group(2) @binding(2) var<storage, read> work: array<u32>;

// Parts of one surface that meet in a pixel differ in depth by less than this share of it.
const SAME_DEPTH = 2e-3;

// The distance along a ray of the plane of a triangle.
fn plane_distance(triangle: u32, ray: Ray) -> f32 {
    let corners = corners_of(triangle);
    let a = vertex_of(corners.x).position;
    let face = cross(vertex_of(corners.y).position - a, vertex_of(corners.z).position - a);
    return dot(a - ray.origin, face) / dot(ray.direction, face);
}

// True if four samples of a pixel show parts of one smooth surface whose look does not depend on the triangle: of
// meshes those that are neither mirror nor lens.
fn is_one_surface(ids: vec4u, corner: vec2f) -> bool {
    // A bit a sample that shows another triangle than the first.
    var others = dot(select(vec4u(0u), vec4u(1u, 2u, 4u, 8u), ids != vec4u(ids.x)), vec4u(1u));
    var is_one = true;
    while others != 0u {
        let sample = firstTrailingBit(others);
        others &= others - 1u;
        if ids[sample] == 0u || ids.x == 0u {
            return false;
        }
        let first = corners_of(triangle_of(ids.x));
        let other = corners_of(triangle_of(ids[sample]));
        let head = surface_of(first.w);
        let part = part_of(first.x);
        let is_exact = (head.flags & QUADRIC) != 0u;
        let is_part = head.role == DIFFUSE && part != 0u && part_of(other.x) == part;
        let ray = eye_ray(corner + four_samples[sample]);
        let here = plane_distance(triangle_of(ids.x), ray);
        let there = plane_distance(triangle_of(ids[sample]), ray);
        is_one = is_one && other.w == first.w && (is_exact || is_part) && abs(here - there) <= SAME_DEPTH * abs(there);
    }
    return is_one;
}

// True if four samples hit the same triangles on all paths.
fn is_one_bundle(cell: vec2u) -> bool {
    // Of the paths whose hits are known: in the order of the table.
    var known = 1u;
    var is_one = frame.order <= frame.tiled_events;
    for (var events = 0u; events <= frame.order && is_one; events++) {
        for (var kinds = 0u; kinds < select(1u, 1u << events, HAS_LENSES); kinds++) {
            let first = select(events, (1u << events) - 1u, HAS_LENSES);
            if (known & (1u << (first + kinds))) == 0u {
                continue;
            }
            let all_hits = hits[hit_index(cell, events, kinds)];
            is_one = is_one && all(all_hits == vec4u(all_hits.x));
            let next = select(events + 1u, (2u << events) - 1u, HAS_LENSES);
            known |= select(0u, 1u << (next + kinds), goes_on(all_hits.x, REFLECT));
            if HAS_LENSES {
                known |= select(0u, 1u << (next + kinds + (1u << events)), goes_on(all_hits.x, TRANSMIT));
            }
        }
    }
    return is_one;
}

fn is_followed(hit: u32) -> bool {
    return frame.order > 0u && (hit & HIT_REFLECTS) != 0u;
}

fn is_in_picture(pixel: vec2u) -> bool {
    return pixel.x < frame.width && pixel.y < frame.height;
}

@compute @workgroup_size(8, 8)
fn shade_one_sample(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = vec2u(invocation.x, invocation.y + frame.first_row);
    if !is_in_picture(pixel) {
        return;
    }
    let cell = invocation.xy / 2u;
    let ray = (invocation.x & 1u) | ((invocation.y & 1u) << 1u);
    let hit = hits[hit_index(cell, 0u, 0u)][ray];
    if !is_followed(hit) {
        let color = seen_radiance(vec2f(pixel) + 0.5, triangle_of(hit), 1.0, 1u);
        textureStore(colors, pixel, vec4f(color, 1.0));
    }
}

@compute @workgroup_size(8, 8)
fn shade_four_samples(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = vec2u(invocation.x, invocation.y + frame.first_row);
    if !is_in_picture(pixel) {
        return;
    }
    let ids = hits[hit_index(invocation.xy, 0u, 0u)];
    if is_followed(ids.x | ids.y | ids.z | ids.w) {
        return;
    }
    // One surface is shaded once.
    let is_one = is_one_surface(ids, vec2f(pixel));
    let count = select(4u, 1u, is_one);
    var sum = vec3f(0.0);
    for (var ray = 0u; ray < count; ray++) {
        let place = vec2f(pixel) + select(four_samples[ray], vec2f(0.5), is_one);
        sum += seen_radiance(place, triangle_of(ids[ray]), select(0.5, 1.0, is_one), select(1u, 4u, is_one));
    }
    textureStore(colors, pixel, vec4f(sum / f32(count), 1.0));
}

// The pixel of a thread in a tile that is shaded path by path, in the band.
fn followed_pixel(group: vec3u, local: vec3u) -> vec2u {
    let tile = work[frame.followed + group.x];
    let corner = vec2u(tile & 0xffffu, tile >> 16u) * select(1u, 2u, SAMPLES == 1u);
    let squares = select(2u, 4u, SAMPLES == 1u);
    return corner + vec2u(group.y % squares, group.y / squares) * 8u + local.xy;
}

@compute @workgroup_size(8, 8)
fn follow_one_sample(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let in_band = followed_pixel(group, local);
    let pixel = in_band + vec2u(0u, frame.first_row);
    let cell = in_band / 2u;
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let ray = (in_band.x & 1u) | ((in_band.y & 1u) << 1u);
    if is_followed(hits[hit_index(cell, 0u, 0u)][ray]) {
        textureStore(colors, pixel, vec4f(path_radiance(vec2f(pixel) + 0.5, cell, ray, 1.0, 1u), 1.0));
    }
}

@compute @workgroup_size(8, 8)
fn follow_four_samples(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let cell = followed_pixel(group, local);
    let pixel = cell + vec2u(0u, frame.first_row);
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let ids = hits[hit_index(cell, 0u, 0u)];
    if !is_followed(ids.x | ids.y | ids.z | ids.w) {
        return;
    }
    let is_one = is_one_bundle(cell);
    let count = select(4u, 1u, is_one);
    var sum = vec3f(0.0);
    for (var ray = 0u; ray < count; ray++) {
        let place = vec2f(pixel) + select(four_samples[ray], vec2f(0.5), is_one);
        sum += path_radiance(place, cell, ray, select(0.5, 1.0, is_one), select(1u, 4u, is_one));
    }
    textureStore(colors, pixel, vec4f(sum / f32(count), 1.0));
}
