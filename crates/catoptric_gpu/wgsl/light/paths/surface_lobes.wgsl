// The lobes of a point of a surface, and rays that follow them: the twin of `light/path_tracer/lobes`.

//#include "scene/lobes.wgsl"
//#include "light/paths/lobes.wgsl"

// Lobes of the coat, of what facets reflect, and of what passes.
const LOBES = 3u;
const OF_COAT = 0u;
const OF_FACETS = 1u;
const OF_PASSING = 2u;

// How a lobe is followed: not at all, by one ray as by a mirror, or by rays of facets.
const UNSEEN = 0u;
const SHARP = 1u;
const SPREAD = 2u;

// The index of refraction of coats.
const COAT_IOR = 1.5;

// Reflections of dielectrics from the first perceptual roughness on become those of the environment alone, which all
// of them are from the second one on.
const WIDE_ROUGHNESS = vec2f(0.5, 0.75);

// A lobe that can add no more than this share of the light before it is not followed.
const LEAST_SHARE = 1.0 / 1024.0;

// All lobes of a point, for a ray's direction.
struct SurfaceLobes {
    flags: u32,
    // The side of arrival, with the normal of the facets, and that of the coat.
    facing: Facing,
    coat_normal: vec3f,
    alpha: f32,
    coat_alpha: f32,
    eta: f32,
    specular: vec3f,
    grazing: f32,
    base: vec3f,
    metallic: f32,
    // Light passes: a ray that meets several facets leaves the surface on one side or the other.
    is_clear: bool,
    // The factors on the lobes' light.
    factors: array<vec3f, LOBES>,
    // The share of the facets' reflection that is the environment's.
    mirrored: f32,
    // The share of light that goes each way, and how it is followed.
    shares: array<vec3f, LOBES>,
    ways: array<u32, LOBES>,
    // How many cones look for lamps.
    cones: f32,
    // Whether the light from infinity that a lobe shows is counted where it begins, and the factor on what rays find of
    // it that makes all of them together take away as much as was counted.
    counts_sky: array<bool, LOBES>,
    taken: array<vec3f, LOBES>,
}

// Fresnel's curve between the reflectances that a material names.
fn dielectric_share(specular: vec3f, grazing: f32, eta: f32, is_plate: bool, cosine: f32) -> vec3f {
    let at_normal = fresnel_dielectric(1.0, eta);
    let rise = (fresnel_dielectric(cosine, eta) - at_normal) / max(1.0 - at_normal, 1e-6);
    let bare = specular + (vec3f(grazing) - specular) * rise;
    return select(bare, 2.0 * bare / (1.0 + bare), is_plate);
}

// The factor of a lobe's light by a facet that is met at this cosine.
fn lobe_weight(lobes: SurfaceLobes, index: u32, cosine: f32) -> vec3f {
    let factor = lobes.factors[index];
    if index == OF_COAT {
        let eta = 1.0 / COAT_IOR;
        return factor * dielectric_share(vec3f(fresnel_dielectric(1.0, eta)), 1.0, eta, false, cosine);
    }
    let is_plate = (lobes.flags & PLATE) != 0u;
    let dielectric = dielectric_share(lobes.specular, lobes.grazing, lobes.eta, is_plate, cosine);
    if index == OF_PASSING {
        return factor * (1.0 - dielectric);
    }
    let metal = lobes.base + (1.0 - lobes.base) * grazing_share(clamp(cosine, 0.0, 1.0));
    return factor * mix(dielectric, metal, lobes.metallic);
}

fn is_thin_lobe(lobes: SurfaceLobes, index: u32) -> bool {
    return index != OF_PASSING || (lobes.flags & THIN) != 0u;
}

fn kind_of_lobe(index: u32) -> u32 {
    return select(REFLECT, TRANSMIT, index == OF_PASSING);
}

fn alpha_of_lobe(lobes: SurfaceLobes, index: u32) -> f32 {
    return select(lobes.alpha, lobes.coat_alpha, index == OF_COAT);
}

// The step whose directions are those of a lobe's middle.
fn lobe_step(lobes: SurfaceLobes, index: u32) -> LightStep {
    var step: LightStep;
    step.facing = lobes.facing;
    if index == OF_COAT {
        step.facing.normal = lobes.coat_normal;
    }
    step.eta = select(lobes.eta, 1.0, is_thin_lobe(lobes, index));
    return step;
}

// The lobes that a ray meets.
fn met_lobes(at: LobesAt, point: SurfacePoint, direction: vec3f) -> SurfaceLobes {
    var lobes: SurfaceLobes;
    lobes.flags = at.flags;
    lobes.facing = facing(direction, point.geometric_normal, at.normal);
    lobes.alpha = at.alpha;
    lobes.coat_alpha = at.coat_alpha;
    let ior = surface_of(point.object).ior;
    lobes.eta = select(1.0 / ior, relative_index(ior, lobes.facing.outside), (at.flags & HAS_INSIDE) != 0u);
    lobes.specular = at.specular;
    lobes.grazing = at.grazing;
    lobes.base = at.base;
    lobes.metallic = at.metallic;
    lobes.is_clear = at.transmission > 0.0;
    let cosine = -dot(direction, lobes.facing.normal);
    var below = 1.0;
    if at.coat > 0.0 && lobes.facing.outside {
        lobes.coat_normal = facing(direction, point.geometric_normal, at.coat_normal).normal;
        lobes.factors[OF_COAT] = vec3f(at.coat);
        lobes.shares[OF_COAT] = lobe_weight(lobes, OF_COAT, -dot(direction, lobes.coat_normal));
        below -= lobes.shares[OF_COAT].x;
    }
    // Light that facets send to each other leaves the surface in the end (Turquin 2019).
    let roughness = sqrt(at.alpha);
    let surroundings = reflected_surroundings(roughness, cosine);
    let kept = clamp(surroundings.x + surroundings.y, 0.05, 1.0);
    let missing = select(1.0 / kept - 1.0, 0.0, lobes.is_clear);
    let wide = clamp((roughness - WIDE_ROUGHNESS.x) / (WIDE_ROUGHNESS.y - WIDE_ROUGHNESS.x), 0.0, 1.0);
    lobes.mirrored = wide * max(1.0 - 10.0 * at.metallic, 0.0) * (1.0 - at.transmission);
    let compensation = 1.0 + mix(at.specular, at.base, at.metallic) * missing;
    lobes.factors[OF_FACETS] = compensation * (below * (1.0 - lobes.mirrored));
    lobes.factors[OF_PASSING] = at.base * ((1.0 - at.metallic) * at.transmission * below);
    // Facets that lean away from the normal may reflect all where others let all pass, and the other way round.
    let leaning = vec3f(select(0.0, 0.5 * at.alpha, lobes.is_clear));
    for (var index = OF_FACETS; index <= OF_PASSING; index++) {
        let factor = lobes.factors[index];
        lobes.shares[index] = max(lobe_weight(lobes, index, cosine), leaning * factor);
    }
    return lobes;
}

// The lobes of a point, of which it is decided how a path follows them.
fn with_ways(given: SurfaceLobes, segment: Segment, throughput: vec3f) -> SurfaceLobes {
    var lobes = given;
    let incoming = segment.ray.direction;
    // Of a ray that stands for a part of a lobe all parts count.
    let least = select(LEAST_SHARE, 0.0, segment.is_single);
    for (var index = 0u; index < LOBES; index++) {
        let step = lobe_step(lobes, index);
        let kind = kind_of_lobe(index);
        // A part of a lobe is wide itself, but its one ray must not stand for all facets. How the surface bends within
        // a pixel makes rays of facets no narrower, either.
        var across = 0.0;
        if !segment.is_cone {
            let dx = direction_change(step, kind, incoming, segment.change.direction_dx, vec3f(0.0));
            let dy = direction_change(step, kind, incoming, segment.change.direction_dy, vec3f(0.0));
            across = sqrt(length(cross(dx, dy)));
        }
        let is_sharp = lobe_width(alpha_of_lobe(lobes, index)) <= max(HIDDEN_LOBE * across, 1e-4);
        let is_seen = largest(throughput * lobes.shares[index]) > least;
        lobes.ways[index] = select(UNSEEN, select(SPREAD, SHARP, is_sharp), is_seen);
    }
    return lobes;
}

// The rays of a lobe, of which so many stand for all that the brightest would have.
fn rays_of_lobe(lobes: SurfaceLobes, index: u32, throughput: vec3f, rays: f32) -> u32 {
    let share = min(largest(throughput * lobes.shares[index]), 1.0);
    return select(0u, u32(clamp(ceil(rays * sqrt(share)), 1.0, rays)), lobes.ways[index] == SPREAD);
}

// The lobe by which a path goes on that follows one alone, and the factor on its light: by its share. LOBES: none is
// seen.
struct ChosenLobe {
    index: u32,
    factor: f32,
}

fn chosen_lobe(lobes: SurfaceLobes, number: f32) -> ChosenLobe {
    var shares: array<f32, LOBES>;
    var total = 0.0;
    for (var index = 0u; index < LOBES; index++) {
        shares[index] = select(largest(lobes.shares[index]), 0.0, lobes.ways[index] == UNSEEN);
        total += shares[index];
    }
    var rest = number * total;
    var chosen = ChosenLobe(LOBES, 0.0);
    for (var index = 0u; index < LOBES; index++) {
        if shares[index] > 0.0 && rest >= 0.0 {
            chosen = ChosenLobe(index, total / shares[index]);
        }
        rest -= shares[index];
    }
    return chosen;
}

// The direction after an event of a lobe at a facet, on the side where it belongs; zero where there is none.
fn leaving_facet(lobes: SurfaceLobes, index: u32, normal: vec3f, incoming: vec3f, facet: vec3f) -> vec3f {
    let kind = kind_of_lobe(index);
    let sign = select(1.0, -1.0, kind == TRANSMIT);
    var direction = mirrored(incoming, facet);
    if kind == TRANSMIT {
        if is_thin_lobe(lobes, index) {
            direction -= normal * (2.0 * dot(direction, normal));
        } else {
            direction = refracted(incoming, facet, lobes.eta);
            if all(direction == vec3f(0.0)) {
                return direction;
            }
        }
    }
    let height = dot(direction, normal) * sign;
    if height <= 0.0 {
        // Light that meets another facet: the compensation gives it back.
        if index == OF_COAT || !lobes.is_clear {
            return vec3f(0.0);
        }
        direction -= normal * (2.0 * height * sign);
    }
    // On the other side of the flat surface alone: it stays on its side.
    let side = lobes.facing.geometric * sign;
    let depth = dot(direction, side);
    return select(direction, direction - side * (2.0 * depth), depth < 0.0);
}

// A ray of a lobe by a facet: without direction where no light goes.
struct LobeRay {
    direction: vec3f,
    facet: vec3f,
    // The factor on its light, where all rays together have the lobe's.
    weight: vec3f,
    // The angle across the part of the lobe that it stands for, and how densely all lie there, a solid angle.
    width: f32,
    density: f32,
}

// One of `count` rays of a lobe, by two numbers.
fn ray_of_lobe(lobes: SurfaceLobes, index: u32, incoming: vec3f, given: vec2f, count: f32) -> LobeRay {
    let number = facet_number(given, count);
    var ray = part_of_lobe(lobes, index, incoming, vec2f(number.x, given.y), count);
    ray.weight *= number.y;
    ray.width *= sqrt(number.y);
    return ray;
}

// The same with numbers that choose all parts of the lobe alike.
fn part_of_lobe(lobes: SurfaceLobes, index: u32, incoming: vec3f, number: vec2f, count: f32) -> LobeRay {
    let step = lobe_step(lobes, index);
    let normal = step.facing.normal;
    let alpha = alpha_of_lobe(lobes, index);
    let axes = axes_across(normal);
    let viewer = -vec3f(dot(incoming, axes[0]), dot(incoming, axes[1]), dot(incoming, normal));
    let local = visible_facet(alpha, viewer, disc_point(number));
    let facet = axes[0] * local.x + axes[1] * local.y + normal * local.z;
    let direction = leaving_facet(lobes, index, normal, incoming, facet);
    let is_clear = lobes.is_clear && index != OF_COAT;
    let share = select(unshadowed_share(alpha, dot(direction, normal), viewer.z), 1.0, is_clear);
    let is_there = any(direction != vec3f(0.0));
    let weight = lobe_weight(lobes, index, -dot(incoming, facet)) * select(0.0, share, is_there);
    let extent = extent_of_sample(alpha, local.z, max(viewer.z, 1e-3), count);
    let density = unmasked_share(alpha, viewer.z) / (extent * count);
    return LobeRay(direction, facet, weight, sqrt(extent), density);
}

// The share of facets that are not masked for a ray.
fn unmasked_share(alpha: f32, cosine: f32) -> f32 {
    return 2.0 * cosine / (cosine + sqrt(alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine));
}

// True if light from infinity arrives over a lobe: none does within a body.
fn sees_sky(lobes: SurfaceLobes, index: u32) -> bool {
    let is_within = (lobes.flags & HAS_INSIDE) != 0u && !lobes.facing.outside;
    return HAS_ENVIRONMENT && !is_within && is_thin_lobe(lobes, index);
}

// Cones that gather the light from infinity over a lobe, at all places of a pixel together, and at one of them at
// least; each is wider by this factor than what there is to it, so that they show no gaps between them.
const MOST_CONES = 64.0;
const LEAST_CONES = 16.0;
const OVERLAP = 1.8;

// How many of them there are at one place.
fn cone_count(places: u32, share: f32) -> u32 {
    return u32(clamp(MOST_CONES * sqrt(share) / f32(places), LEAST_CONES, MOST_CONES));
}

// The light from infinity within a part of a lobe that so many cones cover.
fn sky_within(part: LobeRay, width: f32, cones: f32) -> vec3f {
    return environment_beside_lamps(part.direction, width, 1.0 - share_by_lamps(part.density * cones));
}

// The light of lamps over a lobe, as far as cones leave it out, and those that numbers choose, each as likely as it is
// bright.
struct LampLight {
    light: vec3f,
    chosen: vec4u,
}

fn light_of_lamps(lobes: SurfaceLobes, index: u32, incoming: vec3f, numbers: vec4f) -> LampLight {
    let normal = lobe_step(lobes, index).facing.normal;
    let alpha = alpha_of_lobe(lobes, index);
    let sign = select(1.0, -1.0, index == OF_PASSING);
    let cosine = -dot(incoming, normal);
    let unmasked = unmasked_share(alpha, cosine);
    let is_clear = lobes.is_clear && index != OF_COAT;
    var found: LampLight;
    var total = 0.0;
    var rest = numbers;
    for (var place = 0u; place < lamp_count(); place++) {
        let lamp = lamp_at(place);
        let height = dot(lamp.towards, normal) * sign;
        if height <= 0.0 || dot(lamp.towards, lobes.facing.geometric) * sign <= 0.0 {
            continue;
        }
        let towards = select(lamp.towards, lamp.towards - normal * (2.0 * dot(lamp.towards, normal)), sign < 0.0);
        let facet = normalize_or(towards - incoming, normal);
        let density = unmasked / extent_of_sample(alpha, dot(facet, normal), max(cosine, 1e-3), 1.0);
        let share = select(unshadowed_share(alpha, height, cosine), 1.0, is_clear);
        let weight = lobe_weight(lobes, index, -dot(incoming, facet)) * share;
        let light = weight * lamp.light * (density * share_by_lamps(density * lobes.cones));
        let brightness = light.x + light.y + light.z;
        if !(brightness > 0.0 && brightness < 3e38) {
            continue;
        }
        found.light += light;
        total += brightness;
        // One number chooses among all: what is left of it chooses among the next.
        let likely = brightness / total;
        let is_chosen = rest < vec4f(likely);
        rest = select((rest - likely) / max(1.0 - likely, 1e-6), rest / likely, is_chosen);
        found.chosen = select(found.chosen, vec4u(place), is_chosen);
    }
    return found;
}

// The mean of the light from infinity over a lobe, as if nothing stood before it.
fn sky_over_lobe(lobes: SurfaceLobes, index: u32, incoming: vec3f) -> vec3f {
    let normal = lobe_step(lobes, index).facing.normal;
    let alpha = alpha_of_lobe(lobes, index);
    let surroundings = reflected_surroundings(sqrt(alpha), -dot(incoming, normal));
    let across = mirrored(incoming, normal);
    var middle = normalize_or(mix(normal, across, surroundings.z), across);
    if index == OF_PASSING {
        middle -= normal * (2.0 * dot(middle, normal));
    }
    return environment_glossy(middle, min(alpha * surroundings.w, 1.0));
}
