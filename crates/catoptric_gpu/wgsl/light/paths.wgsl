// Specular paths, from the eye to the diffuse surfaces that they end on: the twin of `light/path_tracer`.

const MIN_THROUGHPUT = 1e-5;
// Paths of more events are refused before anything is drawn.
const MAX_ORDER = 8u;

// A ray that waits to be traced.
struct Segment {
    ray: Ray,
    change: RayDifferential,
    throughput: vec3f,
    // Specular events so far.
    order: u32,
    absorption: vec3f,
    own: OwnRule,
    // Of a mirror whose reflection fades with distance: the surface, what it scatters itself, and its reflectance.
    deferred: u32,
    deferred_own: vec3f,
    deferred_reflectance: f32,
}

struct Paths {
    waiting: array<Segment, MAX_ORDER>,
    count: u32,
    sum: vec3f,
}

// Goes on at a triangle that a ray meets: adds light that ends the path there; children wait.
fn arrive(paths: ptr<function, Paths>, segment: Segment, triangle: u32, samples: u32) {
    let direction = segment.ray.direction;
    let met = drawn_encounter(triangle, segment.ray, segment.change, samples);
    let object = met.point.object;
    let role = surfaces[object].role;
    let flags = surfaces[object].flags;
    let at = facing(direction, met.point.geometric_normal, met.point.normal);
    let way = distance(segment.ray.origin, met.point.position);
    var throughput = segment.throughput;
    if segment.deferred != NONE {
        throughput *= settled(paths, segment, way);
    }
    let crossed = select(segment.absorption, surfaces[object].absorption, role == LENS && !at.outside);
    throughput *= transmittance(crossed, way);
    let last = segment.order >= frame.order;
    let texels = texels_at(met.point);
    let base = (surfaces[object].base_color * met.point.color * texels.values[BASE]).xyz;
    let tint = select(base, vec3f(surfaces[object].coat * texels.values[COAT].x), role == COATED);
    let step = light_step(object, tint, at, direction);
    var child = segment;
    child.order++;
    child.deferred = NONE;
    child.absorption = crossed;
    if role == DIFFUSE || (flags & OWN_LIGHT) != 0u {
        let is_deferred = !last && step.is_attenuated;
        let own_base = select(base, surfaces[object].own_color, (flags & OWN_COLOR) != 0u);
        let is_lit = step.scattered > 0.0 || is_deferred;
        let light = point_light(own_base, tint, met.point, texels, -direction, is_lit);
        (*paths).sum += throughput * light.highlights;
        if is_deferred {
            child.deferred = object;
            child.deferred_own = throughput * light.own;
            child.deferred_reflectance = step.reflectance;
        } else {
            (*paths).sum += throughput * step.scattered * light.own;
        }
    }
    if last || role == DIFFUSE {
        return;
    }
    for (var kind = REFLECT; kind <= TRANSMIT; kind++) {
        if kind == TRANSMIT && !(role == LENS && step.reflectance < 1.0) {
            continue;
        }
        push(paths, child, kind, throughput * select(step.reflected, step.transmitted, kind == TRANSMIT), met, step);
    }
}

// Settles the light of a mirror whose reflection fades with the distance of what it shows: adds the mirror's own, and
// returns the factor of the rest.
fn settled(paths: ptr<function, Paths>, segment: Segment, distance: f32) -> f32 {
    let weight = attenuation_weight(segment.deferred, distance);
    (*paths).sum += segment.deferred_own * (1.0 - segment.deferred_reflectance * weight);
    return weight;
}

// Adds the child of a path by an event.
fn push(
    paths: ptr<function, Paths>,
    parent: Segment,
    kind: u32,
    throughput: vec3f,
    met: SurfaceInteraction,
    step: LightStep,
) {
    if largest(throughput) < MIN_THROUGHPUT && parent.deferred == NONE {
        return;
    }
    let incoming = parent.ray.direction;
    let direction = outgoing(kind, step.facing, incoming, step.eta);
    if all(direction == vec3f(0.0)) || (*paths).count >= MAX_ORDER {
        return;
    }
    let object = met.point.object;
    let outside = step.facing.outside;
    var child = parent;
    child.throughput = throughput;
    child.change.origin_dx = met.position_dx;
    child.change.origin_dy = met.position_dy;
    child.change.direction_dx = direction_change(step, kind, incoming, parent.change.direction_dx, met.normal_dx);
    child.change.direction_dy = direction_change(step, kind, incoming, parent.change.direction_dy, met.normal_dy);
    if kind == TRANSMIT {
        child.absorption = select(vec3f(0.0), surfaces[object].absorption, outside);
    }
    // A little off the surface on the side that the ray leaves to.
    let offset = 16.0 * 1.1920929e-7 * max(met.point.coordinate_size, 1e-37);
    let geometric = met.point.geometric_normal;
    let side = select(offset, -offset, dot(direction, geometric) < 0.0);
    child.ray = Ray(met.point.position + geometric * side, direction);
    child.own = own_rule(object, kind, outside == (kind == REFLECT));
    (*paths).waiting[(*paths).count] = child;
    (*paths).count++;
}

// The radiance that arrives at a position of the picture, where a triangle (or NONE) is seen; changes are those of a
// part of a pixel with such a side.
fn path_radiance(position: vec2f, triangle: u32, side: f32, samples: u32) -> vec3f {
    var segment: Segment;
    segment.ray = eye_ray(position);
    let change = eye_ray_differential(position);
    segment.change = RayDifferential(
        change.origin_dx * side,
        change.origin_dy * side,
        change.direction_dx * side,
        change.direction_dy * side,
    );
    segment.throughput = vec3f(1.0);
    segment.deferred = NONE;
    segment.own = NO_RULE;
    var paths: Paths;
    paths.waiting[0] = segment;
    paths.count = 1u;
    var shown = triangle;
    var of_samples = samples;
    while paths.count > 0u {
        paths.count--;
        let next = paths.waiting[paths.count];
        // What is seen directly is known.
        if next.order > 0u {
            shown = nearest(next.ray, 0.0, FAR, next.own, false).triangle;
            of_samples = 1u;
        }
        if shown != NONE {
            arrive(&paths, next, shown, of_samples);
            continue;
        }
        var throughput = next.throughput;
        if next.deferred != NONE {
            throughput *= settled(&paths, next, FAR);
        }
        paths.sum += throughput * background(next.ray.direction);
    }
    return finite(paths.sum);
}
