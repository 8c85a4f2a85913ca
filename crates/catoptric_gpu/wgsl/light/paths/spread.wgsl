// Rays that leave rough mirrors, and mirrors and glass whose bumps are smaller than what a ray stands for: the twin of
// `light/path_tracer/rough` and `light/bumps`.

//#include "scene/bumps.wgsl"
//#include "light/paths/surface_lobes.wgsl"

// Ways to spread light: by facets of a rough surface, by bumps of a smooth one, and by lobes.
const NO_SPREAD = 0u;
const BY_FACETS = 1u;
const BY_BUMPS = 2u;
const BY_LOBES = 3u;

// Rays for a pixel where a path first meets what spreads light; later ones get one each.
const RAYS_A_PIXEL = 24.0;

// How a surface spreads the light of a path.
struct Spread {
    by: u32,
    // The width of the facets' distribution, and how much normals differ within what the path stands for.
    alpha: f32,
    variance: f32,
    // The path as it arrives, with the event counted.
    path: Segment,
    // Where it meets the surface: before a map turns the normal if bumps spread light, or else after that.
    met: SurfaceInteraction,
    step: LightStep,
    tint: vec3f,
    // By reflection and by refraction.
    goes_on: array<bool, 2>,
    lobes: SurfaceLobes,
}

// The numbers that choose rays: of so many in all every `step`th from the first, moved alike.
struct RayNumbers {
    moved: vec4f,
    first: u32,
    step: u32,
    total: f32,
}

fn spreads_light() -> bool {
    return HAS_TURNS || HAS_ROUGH || HAS_LOBES;
}

// The angle across a cone after an event, from bumps or facets of such a width.
fn cone_width_after(step: LightStep, kind: u32, incoming: vec3f, alpha: f32) -> f32 {
    if kind == REFLECT {
        return cone_width(alpha);
    }
    let cos_in = -dot(incoming, step.facing.normal);
    let cos_out = sqrt(max(1.0 - step.eta * step.eta * (1.0 - cos_in * cos_in), 0.0));
    return cone_width(alpha) * min(0.5 * abs(step.eta * cos_in / max(cos_out, 1e-3) - 1.0), 1.0);
}

// The change of rays that each stand for a cone of so many radians across.
fn widened(change: RayDifferential, direction: vec3f, width: f32) -> RayDifferential {
    let rejected = change.direction_dx - direction * dot(change.direction_dx, direction);
    let across = normalize_or(rejected, axes_across(direction)[0]);
    let along = cross(direction, across);
    var wide = change;
    wide.direction_dx = across * length(vec2f(length(change.direction_dx), width));
    wide.direction_dy = along * length(vec2f(dot(change.direction_dy, along), width));
    return wide;
}

// The width of the facets' distribution with which a mirror, coat or lens shows surfaces.
fn facets_alpha(object: u32, variance: f32) -> f32 {
    let roughness = surface_of(object).mirror_roughness;
    return widened_alpha(roughness * roughness, variance);
}

// True if facets spread light over more than the cone that a path stands for; the encounter is that before a map turns
// the normal: what bumps do from path to path says nothing of it.
fn shows_lobe(segment: Segment, alpha: f32, met: SurfaceInteraction, step: LightStep) -> bool {
    let incoming = segment.ray.direction;
    let dx = direction_change(step, REFLECT, incoming, segment.change.direction_dx, met.normal_dx);
    let dy = direction_change(step, REFLECT, incoming, segment.change.direction_dy, met.normal_dy);
    return lobe_width(alpha) > HIDDEN_LOBE * sqrt(length(cross(dx, dy)));
}

// Three numbers that look random, from three (Jarzynski, Olano 2020: pcg3d).
fn mixed(key: vec3u) -> vec3u {
    var v = key * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

fn unit_numbers(bits: vec2u) -> vec2f {
    return vec2f(bits >> vec2u(8u)) * (1.0 / 16777216.0);
}

// How far numbers are moved, by what they are for: the same path always has the same children.
fn moved_by(incoming: vec3f, at: vec3f) -> vec4f {
    let first = mixed(bitcast<vec3u>(incoming) ^ mixed(bitcast<vec3u>(at)));
    let second = mixed(first);
    return vec4f(unit_numbers(first.xy), unit_numbers(second.xy));
}

fn number_of(numbers: RayNumbers, index: u32) -> vec2f {
    return fract(hammersley(numbers.first + index * numbers.step, numbers.total) + numbers.moved.xy);
}

// The share of light that a facet reflects, from that at the mean normal.
fn reflected_by_facet(object: u32, reflected: vec3f, normal: vec3f, facet: vec3f, direction: vec3f) -> vec3f {
    let at_normal = -dot(direction, normal);
    let at_facet = -dot(direction, facet);
    let surface = surface_of(object);
    if HAS_COATS && surface.role == COATED {
        let eta = 1.0 / surface.ior;
        return reflected * (fresnel_dielectric(at_facet, eta) / max(fresnel_dielectric(at_normal, eta), 1e-6));
    }
    if (surface.flags & SCHLICK) != 0u {
        let mean = grazing_share(clamp(at_normal, 0.0, 1.0));
        let own = grazing_share(clamp(at_facet, 0.0, 1.0));
        let at_incidence = (reflected - mean) / max(1.0 - mean, 1e-3);
        return clamp(at_incidence + (1.0 - at_incidence) * own, vec3f(0.0), vec3f(1.0));
    }
    return reflected;
}

// One of `count` rays that leave a surface where it spreads light, by an event, for a part of a pixel of a side;
// without direction where no light goes.
fn spread_ray(spread: Spread, index: u32, count: f32, kind: u32, numbers: RayNumbers, side: f32) -> Segment {
    var child = spread.path;
    child.is_cone = true;
    child.is_single = true;
    child.deferred_own /= count;
    if HAS_ROUGH && spread.by == BY_FACETS {
        facet_ray(spread, &child, number_of(numbers, index), count, side);
    } else {
        bump_ray(spread, &child, index, count, kind, numbers);
    }
    child.throughput *= 1.0 / count;
    return child;
}

// By a facet of a rough mirror.
fn facet_ray(spread: Spread, child: ptr<function, Segment>, number: vec2f, count: f32, side: f32) {
    let incoming = spread.path.ray.direction;
    let object = spread.met.point.object;
    let at = spread.step.facing;
    let axes = axes_across(at.normal);
    let viewer = -vec3f(dot(incoming, axes[0]), dot(incoming, axes[1]), dot(incoming, at.normal));
    let chosen = facet_number(number, count);
    let local = visible_facet(spread.alpha, viewer, disc_point(vec2f(chosen.x, number.y)));
    let facet = axes[0] * local.x + axes[1] * local.y + at.normal * local.z;
    let direction = mirrored(incoming, facet);
    let share = unshadowed_share(spread.alpha, dot(direction, at.normal), viewer.z);
    // Light that goes on below the surface would meet another facet: it is lost, as masking has it.
    let is_kept = share > 0.0 && dot(direction, at.geometric) > 0.0;
    let reflected = reflected_by_facet(object, spread.step.reflected, at.normal, facet, incoming);
    var step = spread.step;
    step.facing.normal = facet;
    (*child).throughput *= reflected * (chosen.y * select(0.0, share, is_kept));
    (*child).change = change_after(step, REFLECT, incoming, spread.path.change, spread.met);
    // A cone for every ray: together they cover the lobe.
    let extent = extent_of_sample(spread.alpha, local.z, max(viewer.z, 1e-3), count) * chosen.y;
    (*child).change = widened((*child).change, direction, sqrt(extent) * side);
    (*child).ray = departing_ray(select(vec3f(0.0), direction, is_kept), spread.met.point);
    (*child).own = own_rule(object, REFLECT, at.outside);
}

// By a part of a smooth surface with bumps. Bumps that are smaller than the part, too, are as if their slopes were
// normally distributed.
fn bump_ray(
    spread: Spread,
    child: ptr<function, Segment>,
    index: u32,
    count: f32,
    kind: u32,
    numbers: RayNumbers,
) {
    let side = inverseSqrt(count);
    let offset = number_of(numbers, index) - 0.5;
    let part = part_of_encounter(spread.met, offset, side);
    let found = normal_of_map(part.point);
    let arriving = spread.path.ray.direction;
    let moved = spread.path.change.direction_dx * offset.x + spread.path.change.direction_dy * offset.y;
    let incoming = normalize_or(arriving + moved, arriving);
    // Two normally distributed numbers, the squares of which add up to this variance in the mean (Box and Muller).
    let slope = fract(vec2f(0.7548777, 0.5698403) * f32(numbers.first + index * numbers.step) + numbers.moved.zw);
    let axes = axes_across(found.normal);
    let far = sqrt(max(-found.variance * log(max(1.0 - slope.y, 1e-37)), 0.0));
    let aside = (axes[0] * cos(TAU * slope.x) + axes[1] * sin(TAU * slope.x)) * far;
    let normal = normalize_or(found.normal + aside, found.normal);
    let at = facing(incoming, part.point.geometric_normal, normal);
    let step = light_step(part.point.object, spread.tint, at, incoming);
    let change = change_after(step, kind, incoming, scaled_change(spread.path.change, side), part);
    (*child).ray = leaving_ray(kind, incoming, at, step.eta, part.point);
    // The parts' cones cover the lobe together.
    let width = cone_width_after(step, kind, incoming, sqrt(found.variance)) * side;
    (*child).change = widened(change, (*child).ray.direction, width);
    (*child).throughput *= select(step.reflected, step.transmitted, kind == TRANSMIT);
    (*child).own = own_rule(part.point.object, kind, at.outside == (kind == REFLECT));
    (*child).kinds |= kind << (spread.path.order - 1u);
    if kind == TRANSMIT {
        (*child).absorption = select(vec3f(0.0), surface_of(part.point.object).absorption, at.outside);
    }
}

// One of `count` rays of a lobe, by a number; by the lobe's middle if it is sharp. Without direction where no light
// goes.
fn lobe_ray(spread: Spread, index: u32, given: vec2f, count: f32, side: f32) -> Segment {
    let lobes = spread.lobes;
    let incoming = spread.path.ray.direction;
    let kind = kind_of_lobe(index);
    var step = lobe_step(lobes, index);
    let normal = step.facing.normal;
    var child = spread.path;
    child.own = NO_RULE;
    if !is_thin_lobe(lobes, index) {
        child.absorption = select(vec3f(0.0), surface_of(spread.met.point.object).absorption, lobes.facing.outside);
    }
    if lobes.ways[index] == SHARP {
        let direction = outgoing(kind, step.facing, incoming, step.eta);
        child.throughput *= lobe_weight(lobes, index, -dot(incoming, normal));
        child.change = change_after(step, kind, incoming, child.change, spread.met);
        child.ray = departing_ray(direction, spread.met.point);
        return child;
    }
    let found = ray_of_lobe(lobes, index, incoming, given, count);
    child.throughput *= found.weight / count;
    step.facing.normal = found.facet;
    child.change = change_after(step, kind, incoming, child.change, spread.met);
    // A cone for every ray: together they cover the lobe.
    var width = found.width * side;
    if !is_thin_lobe(lobes, index) {
        width = cone_width_after(step, kind, incoming, alpha_of_lobe(lobes, index)) * inverseSqrt(count) * side;
    }
    child.change = widened(child.change, found.direction, width);
    child.ray = departing_ray(found.direction, spread.met.point);
    child.counts_sky = lobes.counts_sky[index];
    if child.counts_sky {
        child.counted = child.throughput * lobes.taken[index];
        // A single ray shows what the lobe does as a whole, unless its one facet has chosen the lobe: wide cones would show
        // what no facet does. It shows lamps, too.
        let is_single = spread.path.is_single;
        if !is_single || (lobes.is_clear && index != OF_COAT) {
            let width = found.width * select(1.0, 0.5, is_single);
            child.counted *= sky_within(found, width, select(lobes.cones, 1e9, is_single));
        }
    }
    child.is_cone = true;
    child.is_single = true;
    return child;
}

// The cone that a rough mirror reflects, or what bumps of glass make of a refracted ray: its direction and change, and
// the share of light that facets neither mask nor shadow.
struct Cone {
    direction: vec3f,
    change: RayDifferential,
    share: f32,
}

fn cone_of(spread: Spread, kind: u32, incoming: vec3f, leaving: vec3f, change: RayDifferential) -> Cone {
    if kind == TRANSMIT {
        let width = cone_width_after(spread.step, kind, incoming, sqrt(spread.variance));
        return Cone(leaving, widened(change, leaving, width), 1.0);
    }
    let normal = spread.step.facing.normal;
    let lobe = reflected_surroundings(sqrt(spread.alpha), -dot(incoming, normal));
    let across = mirrored(incoming, normal);
    let direction = normalize_or(mix(normal, across, lobe.z), across);
    return Cone(direction, widened(change, direction, cone_width(spread.alpha) * lobe.w), lobe.x + lobe.y);
}
