// The first triangle along a ray: the twin of `light/wide_hierarchy/rays` over a narrow hierarchy, and of the tiles'
// `OwnRule`.

struct Node {
    low: vec3f,
    // The first of two children, or of the triangles of a leaf.
    first: u32,
    high: vec3f,
    // The number of triangles; 0: no leaf.
    count: u32,
}

@group(1) @binding(0) var<storage, read> nodes: array<Node>;
// The triangles of leaves.
@group(1) @binding(1) var<storage, read> leaf_triangles: array<u32>;

const MAX_DEPTH = 64u;
// Faces of an object that is not closed count from behind only at this share of its extent.
const AROUND = 0.05;
// Within a lens its surface is met before things that touch it from without.
const TOUCHING = 1e-4;
const FAR = 3e38;

// What of the object that a ray has left it can meet.
struct OwnRule {
    object: u32,
    none: bool,
    outside: bool,
    from_behind: f32,
}

fn own_rule(object: u32, kind: u32, outside: bool) -> OwnRule {
    let flags = surfaces[object].flags;
    let none = (flags & CONVEX) != 0u && outside && kind == REFLECT;
    let from_behind = select(AROUND * surfaces[object].extent, FAR, (flags & CLOSED) != 0u);
    return OwnRule(object, none, outside, from_behind);
}

struct TriangleMet {
    inside: bool,
    distance: f32,
    weights: vec2f,
    // The ray runs along the normal of the triangle's winding.
    along: bool,
}

fn edge_volume(p: vec3f, q: vec3f, direction: vec3f) -> f32 {
    return dot(cross(p + q, q - p), direction);
}

// Decided by the signed volumes that the ray spans with the edges.
fn meet_triangle(corners: vec4u, ray: Ray) -> TriangleMet {
    let a = vertices[corners.x].position - ray.origin;
    let b = vertices[corners.y].position - ray.origin;
    let c = vertices[corners.z].position - ray.origin;
    let va = edge_volume(b, c, ray.direction);
    let vb = edge_volume(c, a, ray.direction);
    let vc = edge_volume(a, b, ray.direction);
    let normal = cross(b - a, c - a);
    let cosine = dot(normal, ray.direction);
    let sum = va + vb + vc;
    var met: TriangleMet;
    met.distance = dot(normal, a) / cosine;
    met.inside = (min(va, min(vb, vc)) >= 0.0 || max(va, max(vb, vc)) <= 0.0) && sum != 0.0;
    met.weights = vec2f(vb, vc) / sum;
    met.along = cosine > 0.0;
    return met;
}

fn is_there(triangle: u32, weights: vec2f) -> bool {
    if (surfaces[triangles[triangle].w].flags & ALPHA_TESTED) == 0u {
        return true;
    }
    return is_present(triangle, Barycentrics(weights, vec2f(0.0), vec2f(0.0)));
}

fn safe_inverse(direction: vec3f) -> vec3f {
    let sign = select(vec3f(-1.0), vec3f(1.0), direction >= vec3f(0.0));
    return sign / max(abs(direction), vec3f(1e-20));
}

// The distances at which a ray enters and leaves a box.
fn meet_box(low: vec3f, high: vec3f, origin: vec3f, inverse: vec3f) -> vec2f {
    let t0 = (low - origin) * inverse;
    let t1 = (high - origin) * inverse;
    let nearer = min(t0, t1);
    let farther = max(t0, t1);
    // Widened by rounding, so that no ray slips past a box that it grazes.
    return vec2f(max(nearer.x, max(nearer.y, nearer.z)), min(farther.x, min(farther.y, farther.z)) * 1.000001);
}

const NO_RULE = OwnRule(NONE, false, true, 0.0);

struct Meeting {
    triangle: u32,
    distance: f32,
}

// The nearest triangle along a ray between two distances; with `casts_shadows`, any that does.
fn nearest(ray: Ray, near: f32, far: f32, own: OwnRule, casts_shadows: bool) -> Meeting {
    var best = Meeting(NONE, far);
    if frame.node_count == 0u {
        return best;
    }
    let inverse = safe_inverse(ray.direction);
    var waiting: array<u32, MAX_DEPTH>;
    var count = 1u;
    waiting[0] = 0u;
    while count > 0u {
        count--;
        var index = waiting[count];
        // Down to the nearer child while there is one.
        loop {
            let node = nodes[index];
            if node.count > 0u {
                for (var place = node.first; place < node.first + node.count; place++) {
                    let triangle = leaf_triangles[place];
                    let distance = distance_to(triangle, ray, near, best.distance, own, casts_shadows);
                    if distance < best.distance {
                        best = Meeting(triangle, distance);
                    }
                }
                break;
            }
            let left = nodes[node.first];
            let right = nodes[node.first + 1u];
            let of_left = meet_box(left.low, left.high, ray.origin, inverse);
            let of_right = meet_box(right.low, right.high, ray.origin, inverse);
            let goes_left = of_left.x <= of_left.y && of_left.y >= near && of_left.x < best.distance;
            let goes_right = of_right.x <= of_right.y && of_right.y >= near && of_right.x < best.distance;
            if !goes_left && !goes_right {
                break;
            }
            let first_is_left = goes_left && (!goes_right || of_left.x <= of_right.x);
            if goes_left && goes_right && count < MAX_DEPTH {
                waiting[count] = node.first + u32(first_is_left);
                count++;
            }
            index = node.first + u32(!first_is_left);
        }
        if casts_shadows && best.triangle != NONE {
            break;
        }
    }
    return best;
}

// The distance at which a ray meets a triangle that is there for it; FAR if it does not.
fn distance_to(triangle: u32, ray: Ray, near: f32, far: f32, own: OwnRule, casts_shadows: bool) -> f32 {
    let corners = triangles[triangle];
    if casts_shadows && (surfaces[corners.w].flags & CASTS_SHADOWS) == 0u {
        return FAR;
    }
    let met = meet_triangle(corners, ray);
    if !(met.inside && met.distance >= near && met.distance <= far * 1.001) {
        return FAR;
    }
    var distance = met.distance;
    if corners.w == own.object {
        let sum = vertices[corners.x].normal + vertices[corners.y].normal + vertices[corners.z].normal;
        let a = vertices[corners.x].position;
        let face = cross(vertices[corners.y].position - a, vertices[corners.z].position - a);
        // Along its outer normal a ray meets a triangle from within.
        let from_within = met.along != (dot(face, sum) < 0.0);
        if own.none || from_within == own.outside && distance < own.from_behind {
            return FAR;
        }
        distance = select(distance * (1.0 - TOUCHING), distance, own.outside);
    }
    if distance < far && is_there(triangle, met.weights) {
        return distance;
    }
    return FAR;
}
