// Specular paths, from the eye to the diffuse surfaces that they end on: the twin of `light/path_tracer`.

//#include "light/paths/bounce.wgsl"
//#include "light/paths/spread.wgsl"

// Light divides at the first glass alone, and goes on by the stronger branch from then on.
override TWO_PATHS: bool = false;

const MIN_THROUGHPUT = 1e-5;
// Surfaces that a path passes or whose lobes it follows, at most.
const MOST_BESIDE_TILES = 64u;
// The numbers that choose what a single ray meets, and the lobe that it follows.
const CHOICE = vec3f(0.6180340, 0.7548777, 0.5698403);
// Set where four samples that are shaded as one turn out to show different places: what is found then does not count.
var<private> shows_several: bool;
// Paths of more events are refused before anything is drawn.
const MAX_ORDER = 16u;

// A ray that waits to be traced.
struct Segment {
    ray: Ray,
    change: RayDifferential,
    throughput: vec3f,
    // Specular events so far, and their kinds: a bit each, set where light is refracted.
    order: u32,
    kinds: u32,
    absorption: vec3f,
    own: OwnRule,
    // True once the path has met glass.
    has_divided: bool,
    // True for one of several rays that left a surface which spreads light: it stands for a cone.
    is_cone: bool,
    // Surfaces that spread light have but one ray of it.
    is_single: bool,
    // Surfaces on the path since lobes or straight passages made it one that tiles know nothing of; 0: they may.
    beside_tiles: u32,
    // The light from infinity has been counted where the ray began, and is taken away if it meets something.
    counts_sky: bool,
    counted: vec3f,
    // The last mirror, if its reflection fades with distance: the surface, what it scatters itself, and its
    // reflectance.
    deferred: u32,
    deferred_own: vec3f,
    deferred_reflectance: f32,
}

// Where a path goes on from a surface: by reflection and by refraction.
struct Children {
    segments: array<Segment, 2>,
    goes_on: array<bool, 2>,
    // Where it spreads, in place of these children.
    spread: Spread,
    // The path straight on, where a surface is not there or leaves light uncovered.
    passing: Segment,
    passes: bool,
    // Light that ends here.
    sum: vec3f,
}

// The ways on of a path from a triangle that its ray meets, and the light that ends there; no ways on where
// `last` is true.
fn arrive(segment: Segment, triangle: u32, samples: u32, last: bool) -> Children {
    var children: Children;
    let direction = segment.ray.direction;
    let met = drawn_encounter(triangle, segment.ray, segment.change, samples, segment.order);
    let object = met.point.object;
    let role = surface_of(object).role;
    let flags = surface_of(object).flags;
    let turned = turned_encounter(met);
    let at = facing(direction, met.point.geometric_normal, turned.met.point.normal);
    let way = distance(segment.ray.origin, met.point.position);
    var throughput = segment.throughput;
    if HAS_ATTENUATION && segment.deferred != NONE {
        let weight = attenuation_weight(segment.deferred, way);
        children.sum += settled(segment, weight);
        throughput *= weight;
    }
    var crossed = segment.absorption;
    if HAS_LENSES || HAS_LOBES {
        crossed = select(segment.absorption, surface_of(object).absorption, has_medium(object) && !at.outside);
        throughput *= transmittance(crossed, way);
    }
    let texels = texels_at(met.point);
    let color = surface_of(object).base_color * met.point.color * texels.values[BASE];
    let base = color.xyz;
    var tint = base;
    if HAS_COATS && role == COATED {
        tint = vec3f(surface_of(object).coat * texels.values[COAT].x);
    }
    let step = light_step(object, tint, at, direction);
    var child = segment;
    child.order++;
    child.deferred = NONE;
    child.absorption = crossed;
    if HAS_LOBES && segment.counts_sky {
        children.sum -= segment.counted;
        child.counts_sky = false;
        child.counted = vec3f(0.0);
    }
    if role == DIFFUSE || (flags & OWN_LIGHT) != 0u {
        let is_deferred = HAS_ATTENUATION && !last && step.is_attenuated;
        var own_base = select(base, surface_of(object).own_color, (flags & OWN_COLOR) != 0u);
        var is_lit = step.scattered > 0.0 || is_deferred;
        var of_facets = all_light();
        if has_lobes(object) {
            var of_lobes = lobes_at(met.point, texels, color);
            throughput *= covered_share(&children, segment, throughput, of_lobes.coverage, met);
            is_lit = any(throughput > vec3f(0.0));
            if last {
                // The environment stands for all that rays would have found.
                of_lobes.transmission = 0.0;
            }
            let lobes = met_lobes(of_lobes, met.point, direction);
            of_facets = light_beside_lobes(of_lobes, select(lobes.mirrored, 1.0, last), select(0.0, 1.0, last));
            if !HAS_LIGHTS && !HAS_ENVIRONMENT {
                // A headlight shows what scatters it.
                own_base *= (1.0 - of_lobes.metallic) * (1.0 - of_lobes.transmission);
            }
            children.spread.by = select(BY_LOBES, NO_SPREAD, last || !is_lit || (flags & UNLIT) != 0u);
            children.spread.lobes = lobes;
        }
        let light = point_light(own_base, tint, met.point, texels, -direction, is_lit, of_facets);
        children.sum += throughput * light.highlights;
        if is_deferred {
            child.deferred = object;
            child.deferred_own = throughput * light.own;
            child.deferred_reflectance = step.reflectance;
        } else {
            children.sum += throughput * step.scattered * light.own;
        }
    }
    if HAS_LOBES && children.spread.by == BY_LOBES {
        children.spread.lobes = with_ways(children.spread.lobes, segment, throughput);
        children.spread.path = child;
        children.spread.path.throughput = throughput;
        children.spread.path.beside_tiles++;
        children.spread.met = met;
    }
    if ENDS_IN_ENVIRONMENT && last && role != DIFFUSE && segment.order >= frame.order {
        children.sum += throughput * light_from_infinity(step, direction, facets_alpha(object, turned.variance));
    }
    if last || role == DIFFUSE {
        return children;
    }
    var goes_on = array<bool, 2>(true, HAS_LENSES && role == LENS && step.reflectance < 1.0);
    if TWO_PATHS && HAS_LENSES && role == LENS {
        let prefers_reflection = step.reflectance > 0.5 || all(step.transmitted == vec3f(0.0));
        goes_on[REFLECT] = !segment.has_divided || prefers_reflection;
        goes_on[TRANSMIT] = goes_on[TRANSMIT] && !(segment.has_divided && prefers_reflection);
        child.has_divided = true;
    }
    if spreads_light() {
        let alpha = facets_alpha(object, turned.variance);
        let is_rough = HAS_ROUGH && surface_of(object).mirror_roughness > 0.0;
        children.spread.alpha = alpha;
        children.spread.variance = turned.variance;
        children.spread.step = step;
        if is_rough || (HAS_TURNS && alpha > 0.0 && shows_lobe(segment, alpha, met, step)) {
            children.spread.by = select(BY_BUMPS, BY_FACETS, is_rough);
            children.spread.path = child;
            children.spread.path.throughput = throughput;
            children.spread.met = met;
            if is_rough {
                children.spread.met = turned.met;
            }
            children.spread.tint = tint;
            children.spread.goes_on = goes_on;
        }
    }
    children.segments[REFLECT] = departed(child, REFLECT, throughput * step.reflected, turned.met, step);
    children.goes_on[REFLECT] = goes_on[REFLECT] && carries_light(children.segments[REFLECT]);
    if HAS_LENSES {
        children.segments[TRANSMIT] = departed(child, TRANSMIT, throughput * step.transmitted, turned.met, step);
        children.goes_on[TRANSMIT] = goes_on[TRANSMIT] && carries_light(children.segments[TRANSMIT]);
    }
    return children;
}

// The share of light that meets what covers a point; the path straight on has the rest. A single ray does one of the
// two.
fn covered_share(
    children: ptr<function, Children>,
    segment: Segment,
    throughput: vec3f,
    coverage: f32,
    met: SurfaceInteraction,
) -> f32 {
    var covered = coverage;
    if segment.is_single && covered > 0.0 && covered < 1.0 {
        covered = select(0.0, 1.0, fract(moved_by(segment.ray.direction, met.point.position).w + CHOICE.x) < covered);
    }
    if covered < 1.0 && segment.beside_tiles < MOST_BESIDE_TILES {
        (*children).passing = segment;
        (*children).passing.ray = departing_ray(segment.ray.direction, met.point);
        (*children).passing.change.origin_dx = met.position_dx;
        (*children).passing.change.origin_dy = met.position_dy;
        (*children).passing.throughput = throughput * (1.0 - covered);
        (*children).passing.own = NO_RULE;
        (*children).passing.deferred = NONE;
        (*children).passing.counts_sky = false;
        (*children).passing.counted = vec3f(0.0);
        (*children).passing.beside_tiles++;
        (*children).passes = carries_light((*children).passing);
    }
    return covered;
}

// The light from infinity by all events, as if nothing stood before it, against a ray's direction: by facets of this
// width.
fn light_from_infinity(step: LightStep, incoming: vec3f, alpha: f32) -> vec3f {
    var sum = step.reflected * environment_glossy(outgoing(REFLECT, step.facing, incoming, step.eta), alpha);
    if HAS_LENSES && any(step.transmitted != vec3f(0.0)) {
        let direction = outgoing(TRANSMIT, step.facing, incoming, step.eta);
        if any(direction != vec3f(0.0)) {
            sum += step.transmitted * environment_glossy(direction, alpha);
        }
    }
    return sum;
}

// The own light of a mirror whose reflection fades with the distance of what it shows, at this weight.
fn settled(segment: Segment, weight: f32) -> vec3f {
    return segment.deferred_own * (1.0 - segment.deferred_reflectance * weight);
}

fn carries_light(segment: Segment) -> bool {
    var counts = largest(segment.throughput) >= MIN_THROUGHPUT || (HAS_ATTENUATION && segment.deferred != NONE);
    counts = counts || (HAS_LOBES && largest(segment.counted) >= MIN_THROUGHPUT);
    return counts && any(segment.ray.direction != vec3f(0.0));
}

// The child of a path, which counts the event already; without a direction on total internal reflection.
fn departed(parent: Segment, kind: u32, throughput: vec3f, met: SurfaceInteraction, step: LightStep) -> Segment {
    let incoming = parent.ray.direction;
    let object = met.point.object;
    let outside = step.facing.outside;
    var child = parent;
    child.throughput = throughput;
    child.change = change_after(step, kind, incoming, parent.change, met);
    child.kinds |= kind << (parent.order - 1u);
    if kind == TRANSMIT {
        child.absorption = select(vec3f(0.0), surface_of(object).absorption, outside);
    }
    child.ray = leaving_ray(kind, incoming, step.facing, step.eta, met.point);
    child.own = own_rule(object, kind, outside == (kind == REFLECT));
    return child;
}

// A path that starts at the eye; changes are those of a part of a pixel with such a side.
fn eye_segment(position: vec2f, side: f32) -> Segment {
    var segment: Segment;
    segment.ray = eye_ray(position);
    segment.change = scaled_change(eye_ray_differential(position), side);
    segment.throughput = vec3f(1.0);
    segment.deferred = NONE;
    segment.own = NO_RULE;
    return segment;
}

// The radiance of what is seen at a position of the picture, a triangle or NONE, and of nothing that it shows.
fn seen_radiance(position: vec2f, triangle: u32, side: f32, samples: u32) -> vec3f {
    let segment = eye_segment(position, side);
    if triangle == NONE {
        return finite(background(segment.ray.direction));
    }
    return finite(arrive(segment, triangle, samples, true).sum);
}
