// Pixels that are shaded, of a picture whose hits are known.

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
    if (frame.flags & APART) != 0u {
        return others == 0u;
    }
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
        let is_exact = (head.flags & EXACT) != 0u;
        let is_part = head.role == DIFFUSE && part != 0u && part_of(other.x) == part;
        let ray = eye_ray(corner + four_samples[sample]);
        let here = plane_distance(triangle_of(ids.x), ray);
        let there = plane_distance(triangle_of(ids[sample]), ray);
        is_one = is_one && other.w == first.w && (is_exact || is_part) && abs(here - there) <= SAME_DEPTH * abs(there);
    }
    return is_one;
}

fn is_followed(hit: u32) -> bool {
    return frame.order > 0u && (hit & HIT_REFLECTS) != 0u;
}

fn is_in_picture(pixel: vec2u) -> bool {
    return pixel.x < frame.width && pixel.y < frame.height;
}

// The pixel of a thread in a tile that is shaded path by path, in the band.
fn followed_pixel(group: vec3u, local: vec3u) -> vec2u {
    let tile = work[frame.followed + group.x];
    let corner = vec2u(tile & 0xffffu, tile >> 16u) * select(1u, 2u, SAMPLES == 1u);
    let squares = select(2u, 4u, SAMPLES == 1u);
    return corner + vec2u(group.y % squares, group.y / squares) * 8u + local.xy;
}
