// The two passes of a frame: what is seen directly, and its colours.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "scene/environment.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "scene/shade.wgsl"
//#include "light/trace.wgsl"
//#include "light/paths.wgsl"

@group(2) @binding(0) var seen: texture_2d<u32>;
@group(2) @binding(1) var colors: texture_storage_2d<rgba32float, write>;
@group(2) @binding(2) var seen_samples: texture_multisampled_2d<u32>;

// The places of four samples, from the corner of the pixel.
var<private> four_samples: array<vec2f, 4> =
    array<vec2f, 4>(vec2f(0.375, 0.125), vec2f(0.875, 0.375), vec2f(0.125, 0.625), vec2f(0.625, 0.875));

fn id_of(halves: vec4u) -> u32 {
    return halves.x | (halves.y << 16u);
}

// Parts of one surface that meet in a pixel differ in depth by less than this share of it.
const SAME_DEPTH = 2e-3;

// The distance along a ray of the plane of a triangle.
fn plane_distance(triangle: u32, ray: Ray) -> f32 {
    let corners = triangles[triangle];
    let a = vertices[corners.x].position;
    let face = cross(vertices[corners.y].position - a, vertices[corners.z].position - a);
    return dot(a - ray.origin, face) / dot(ray.direction, face);
}

// True if four samples of a pixel show parts of one smooth surface whose look does not depend on the triangle: of
// meshes those that are neither mirror nor lens.
fn is_one_surface(ids: vec4u, corner: vec2f) -> bool {
    if any(ids == vec4u(0u)) {
        return false;
    }
    let first = triangles[ids.x - 1u];
    let is_exact = (surfaces[first.w].flags & QUADRIC) != 0u;
    let part = vertices[first.x].part;
    let is_smooth = is_exact || surfaces[first.w].role == DIFFUSE && part != 0u;
    for (var sample = 1u; sample < 4u; sample++) {
        if ids[sample] == ids.x {
            continue;
        }
        let other = triangles[ids[sample] - 1u];
        if !is_smooth || other.w != first.w || !is_exact && vertices[other.x].part != part {
            return false;
        }
        let ray = eye_ray(corner + four_samples[sample]);
        let here = plane_distance(ids.x - 1u, ray);
        let there = plane_distance(ids[sample] - 1u, ray);
        if !(abs(here - there) <= SAME_DEPTH * abs(there)) {
            return false;
        }
    }
    return true;
}

@compute @workgroup_size(8, 8)
fn shade_one_sample(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = vec2u(invocation.x, invocation.y + frame.first_row);
    if pixel.x >= frame.width || pixel.y >= frame.height {
        return;
    }
    let id = id_of(textureLoad(seen, pixel, 0));
    // Of nothing: 0, and so no triangle.
    textureStore(colors, pixel, vec4f(path_radiance(vec2f(pixel) + 0.5, id - 1u, 1.0, 1u), 1.0));
}

@compute @workgroup_size(8, 8)
fn shade_four_samples(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = vec2u(invocation.x, invocation.y + frame.first_row);
    if pixel.x >= frame.width || pixel.y >= frame.height {
        return;
    }
    var ids: vec4u;
    for (var sample = 0u; sample < 4u; sample++) {
        ids[sample] = id_of(textureLoad(seen_samples, pixel, sample));
    }
    let is_one = all(ids == vec4u(0u)) || is_one_surface(ids, vec2f(pixel));
    // What mirrors show differs from sample to sample; all else that is one surface is shaded once.
    let is_plain = is_one && (ids.x == 0u || surfaces[triangles[ids.x - 1u].w].role == DIFFUSE);
    let count = select(4u, 1u, is_plain);
    let side = select(0.5, 1.0, is_plain);
    var sum = vec3f(0.0);
    for (var sample = 0u; sample < count; sample++) {
        let place = select(four_samples[sample], vec2f(0.5), is_plain);
        sum += path_radiance(vec2f(pixel) + place, ids[sample] - 1u, side, select(1u, 4u, is_plain));
    }
    textureStore(colors, pixel, vec4f(sum / f32(count), 1.0));
}
