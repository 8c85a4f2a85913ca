// The first triangle along a ray: the twin of `light/wide_hierarchy/rays` over a narrow hierarchy.

//#include "light/hierarchy.wgsl"

const MAX_DEPTH = 64u;

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
fn meet_triangle(triangle: LeafTriangle, ray: Ray) -> TriangleMet {
    let a = triangle.a - ray.origin;
    let b = triangle.b - ray.origin;
    let c = triangle.c - ray.origin;
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

struct Meeting {
    triangle: u32,
    distance: f32,
}

// The nearest triangle below a root along a ray between two distances, of those that have all of some flags; any that
// hides lights, if these are asked for.
fn nearest(root: u32, ray: Ray, near: f32, far: f32, own: OwnRule, flags: u32) -> Meeting {
    var best = Meeting(NONE, far);
    let inverse = safe_inverse(ray.direction);
    var waiting: array<u32, MAX_DEPTH>;
    var count = 0u;
    // NONE, too, has a leaf's bit.
    var current = root;
    loop {
        // Down to a leaf.
        while (current & LEAF) == 0u {
            let node = node_of(current);
            let first = meet_box(node.low0, node.high0, ray.origin, inverse);
            let second = meet_box(node.low1, node.high1, ray.origin, inverse);
            let meets_first = first.x <= first.y && first.y >= near && first.x < best.distance;
            let meets_second = second.x <= second.y && second.y >= near && second.x < best.distance;
            let first_is_nearer = meets_first && (!meets_second || first.x <= second.x);
            current = select(node.child1, node.child0, first_is_nearer);
            if meets_first && meets_second {
                waiting[count] = select(node.child0, node.child1, first_is_nearer);
                count = min(count + 1u, MAX_DEPTH - 1u);
            } else if !meets_first && !meets_second {
                current = NONE;
                if count > 0u {
                    count--;
                    current = waiting[count];
                }
            }
        }
        if current == NONE {
            break;
        }
        let start = (current & ~LEAF) >> 3u;
        for (var place = start; place < start + (current & 7u); place++) {
            let triangle = leaf_triangle_of(place);
            let distance = distance_to(triangle, ray, near, best.distance, own, flags);
            if distance < best.distance {
                best = Meeting(triangle.triangle, distance);
            }
        }
        if count == 0u || (flags == HIDES_LIGHTS && best.triangle != NONE) {
            break;
        }
        count--;
        current = waiting[count];
    }
    return best;
}

// Light on its way through glass: what has passed its surfaces so far, and what bodies absorb, as exponents: less where
// the ray enters one, more where it leaves it, each times the distance from the start.
var<private> passed: vec3f;
var<private> absorbed: vec3f;

fn pass_glass(triangle: LeafTriangle, ray: Ray, met: TriangleMet) {
    let normal = normalize_or(cross(triangle.b - triangle.a, triangle.c - triangle.a), ray.direction);
    let cosine = abs(dot(normal, ray.direction));
    let surface = triangle.object;
    passed *= surface_of(surface).base_color.xyz * (1.0 - fresnel_dielectric(cosine, 1.0 / surface_of(surface).ior));
    let leaves = met.along != ((triangle.flags & TURNED) != 0u);
    absorbed += surface_of(surface).absorption * select(-met.distance, met.distance, leaves);
}

// The share of light that goes on behind a surface which is no lens: the twin of `scene/shading/passing`.
fn passing(triangle: LeafTriangle, ray: Ray, met: TriangleMet) -> vec3f {
    let at = Barycentrics(met.weights, vec2f(0.0), vec2f(0.0));
    let point = surface_point(triangle_at(triangle.triangle), at, 1u);
    let surface = surface_of(point.object);
    let base = surface.base_color * point.color * sample_binding(point.object, BASE, point);
    if surface.lobes == NONE {
        return vec3f(1.0 - clamp(base.w, 0.0, 1.0));
    }
    let record = lobes_record_at(surface.lobes);
    let coverage = select(1.0, clamp(base.w, 0.0, 1.0), (record.flags & BLENDS) != 0u);
    let texture = binding_at(surface.lobes + LOBE_BINDINGS_AT + 2u * OF_TRANSMISSION);
    let transmission = record.transmission * sample_bound(texture, point).x;
    let metallic = surface.metallic * sample_binding(point.object, FACETS, point).z;
    let specular = largest(surface.specular);
    let reflected = specular + (surface.specular_at_grazing - specular) * grazing_share(abs(dot(ray.direction, point.normal)));
    return base.xyz * (transmission * (1.0 - metallic) * (1.0 - reflected) * coverage) + (1.0 - coverage);
}

// The share of light that goes straight on along a ray to a distance: nothing behind what hides lights, and what passes
// glass, as if it did not bend.
fn light_through(root: u32, ray: Ray, far: f32) -> vec3f {
    passed = vec3f(1.0);
    absorbed = vec3f(0.0);
    if nearest(root, ray, 0.0, far, NO_RULE, HIDES_LIGHTS).triangle != NONE {
        return vec3f(0.0);
    }
    return passed * exp(-max(absorbed, vec3f(0.0)));
}

// The distance at which a ray meets a triangle that is there for it; FAR if it does not.
fn distance_to(triangle: LeafTriangle, ray: Ray, near: f32, far: f32, own: OwnRule, flags: u32) -> f32 {
    let met = meet_triangle(triangle, ray);
    var distance = met.distance;
    // Not a number: no.
    let is_between = met.inside && distance >= near && distance < far;
    if HAS_LENSES && is_between && flags == HIDES_LIGHTS && (triangle.flags & REFRACTS) != 0u {
        pass_glass(triangle, ray, met);
    }
    var is_met = met.inside && distance >= near && (triangle.flags & flags) == flags;
    if HAS_LOBES && flags == HIDES_LIGHTS && (triangle.flags & PASSES) != 0u {
        if is_between {
            passed *= passing(triangle, ray, met);
        }
        is_met = false;
    }
    if triangle.object == own.object {
        // Along its outer normal a ray meets a triangle from within.
        let from_within = met.along != ((triangle.flags & TURNED) != 0u);
        is_met = is_met && !own.none && (from_within != own.outside || distance >= own.from_behind);
        distance = select(distance * (1.0 - TOUCHING), distance, own.outside);
    }
    is_met = is_met && distance < far;
    if HAS_HOLES && is_met && (triangle.flags & MAY_HAVE_HOLES) != 0u {
        is_met = is_present(triangle.triangle, Barycentrics(met.weights, vec2f(0.0), vec2f(0.0)));
    }
    return select(FAR, distance, is_met);
}
