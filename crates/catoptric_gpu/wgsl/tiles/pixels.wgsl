// Pixels that are shaded, of a picture whose hits are known.

@group(2) @binding(0) var<storage, read> hits: array<vec4u>;
@group(2) @binding(1) var colors: texture_storage_2d<rgba32float, write>;
// The tiles that are shaded path by path are in it: see `tiles/work.wgsl`.
@group(2) @binding(2) var<storage, read> work: array<u32>;

// Parts of one surface that meet in a pixel differ in depth by less than this share of it.
const SAME_DEPTH = 2e-3;

// Where a ray meets the plane of a triangle: the distance, and the least of the weights of its corners there, which is
// below 0 beside it.
fn place_in_plane(triangle: u32, ray: Ray) -> vec2f {
    let corners = corners_of(triangle);
    let a = vertex_of(corners.x).position;
    let ab = vertex_of(corners.y).position - a;
    let ac = vertex_of(corners.z).position - a;
    let face = cross(ab, ac);
    let distance = dot(a - ray.origin, face) / dot(ray.direction, face);
    let relative = ray.origin + ray.direction * distance - a;
    let weights = vec2f(dot(relative, cross(ac, face)), dot(relative, cross(face, ab))) / dot(face, face);
    return vec2f(distance, min(min(weights.x, weights.y), 1.0 - weights.x - weights.y));
}

// True if four hits on a path are of one surface: exact, or triangles that hang together; not if they show the
// environment, where there is one, as that is looked up without a filter.
fn are_of_one_surface(found: vec4u) -> bool {
    if all(found == vec4u(found.x)) {
        return !(HAS_ENVIRONMENT && found.x == 0u);
    }
    let goes_on_alike = all((found & vec4u(~HIT_TRIANGLE)) == vec4u(found.x & ~HIT_TRIANGLE));
    if !goes_on_alike || any(found == vec4u(0u)) || any(found == vec4u(UNRESOLVED)) || (frame.flags & APART) != 0u {
        return false;
    }
    let first = corners_of(triangle_of(found.x));
    let part = part_of(first.x);
    let is_exact = (surface_of(first.w).flags & EXACT) != 0u;
    for (var sample = 1u; sample < RAYS; sample++) {
        let other = corners_of(triangle_of(found[sample]));
        if other.w != first.w || !(is_exact || (part != 0u && part_of(other.x) == part)) {
            return false;
        }
    }
    return true;
}

// The one of four hits of one surface that a ray through the middle of their samples meets.
fn shared_hit(found: vec4u, ray: Ray) -> u32 {
    if all(found == vec4u(found.x)) {
        return found.x;
    }
    var best = found.x;
    var nearest_place = vec2f(0.0, -FAR);
    var distances: vec4f;
    for (var sample = 0u; sample < RAYS; sample++) {
        let place = place_in_plane(triangle_of(found[sample]), ray);
        distances[sample] = place.x;
        if place.y > nearest_place.y {
            nearest_place = place;
            best = found[sample];
        }
    }
    let depth = nearest_place.x;
    let are_near = all(abs(distances - vec4f(depth)) <= vec4f(SAME_DEPTH * abs(depth)));
    shows_several = shows_several || !are_near || !(nearest_place.y >= -HARDLY_BESIDE);
    return best;
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
        let here = place_in_plane(triangle_of(ids.x), ray).x;
        let there = place_in_plane(triangle_of(ids[sample]), ray).x;
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
