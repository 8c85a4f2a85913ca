// The colours of surface points: the twin of `scene/shading/shade`, `lit_point` and `glossy`.

//#include "scene/lobes.wgsl"
//#include "scene/sky.wgsl"

const COAT_REFLECTANCE = 0.04;
const FAINTEST_HIGHLIGHT = 3e-5;
// Shadow rays start so far from the surface, in sizes of its coordinates.
const SHADOW_OFFSET = 32.0 * 1.1920929e-7;

// All lights, of which the first `frame.light_count` are in use.
struct Lights {
    lights: array<Light, MAX_LIGHTS>,
}

@group(0) @binding(9) var<uniform> scene: Lights;

fn finite(radiance: vec3f) -> vec3f {
    // Written so that what is not a number is black.
    let is_finite = abs(radiance.x) < 3e38 && abs(radiance.y) < 3e38 && abs(radiance.z) < 3e38;
    return select(vec3f(0.0), max(radiance, vec3f(0.0)), is_finite);
}

// The direction to a light, and the factor on its intensity that gives the irradiance of what faces it.
fn arriving(light: u32, position: vec3f) -> vec4f {
    let kind = scene.lights[light].kind;
    if kind == 0u {
        return vec4f(-scene.lights[light].direction, 1.0);
    }
    let offset = scene.lights[light].position - position;
    let distance2 = max(dot(offset, offset), 1e-12);
    let towards = offset * inverseSqrt(distance2);
    let range = scene.lights[light].range;
    let ratio2 = select(0.0, distance2 / (range * range), range > 0.0);
    var strength = max(1.0 - ratio2 * ratio2, 0.0) / distance2;
    if kind == 2u {
        let outer = scene.lights[light].outer_cos;
        let cosine = -dot(towards, scene.lights[light].direction);
        let fade = clamp((cosine - outer) / max(scene.lights[light].inner_cos - outer, 1e-4), 0.0, 1.0);
        strength *= fade * fade;
    }
    return vec4f(towards, strength);
}

// Where light is sought from: above the surface on the viewers' side, and from the bulge that corners' normals make.
fn shadow_start(point: SurfacePoint, side: f32) -> vec3f {
    if point.triangle == NONE {
        let offset = SHADOW_OFFSET * max(point.coordinate_size, 1e-37);
        return point.position + point.geometric_normal * (side * offset);
    }
    let corners = corners_of(point.triangle);
    var positions = array<vec3f, 3>(
        vertex_of(corners.x).position, vertex_of(corners.y).position, vertex_of(corners.z).position);
    var normals = array<vec3f, 3>(
        vertex_of(corners.x).normal, vertex_of(corners.y).normal, vertex_of(corners.z).normal);
    var at = max(point.barycentrics, vec2f(0.0));
    at /= max(at.x + at.y, 1.0);
    var weights = array<f32, 3>(1.0 - at.x - at.y, at.x, at.y);
    let position = positions[0] + (positions[1] - positions[0]) * at.x + (positions[2] - positions[0]) * at.y;
    let face = point.geometric_normal * side;
    var bulge = vec3f(0.0);
    for (var corner = 0u; corner < 3u; corner++) {
        let normal = normals[corner] * side;
        let below = dot(position - positions[corner], normal);
        if below < 0.0 && dot(normal, face) > 0.5 {
            bulge -= normal * (weights[corner] * below);
        }
    }
    return position + bulge + face * (SHADOW_OFFSET * max(point.coordinate_size, 1e-37));
}

// The share of a light that arrives at a place.
fn share_of_light(light: u32, start: vec3f) -> vec3f {
    if !HAS_SHADOWS {
        return vec3f(1.0);
    }
    var towards = vec3f(0.0);
    var distance = FAR;
    if scene.lights[light].kind == 0u {
        towards = -scene.lights[light].direction;
    } else {
        let step = scene.lights[light].position - start;
        distance = length(step);
        if distance < 1e-37 {
            return vec3f(1.0);
        }
        towards = step / distance;
    }
    return light_through(frame.root, Ray(start, towards), distance);
}

// The light that a point sends to its viewer by itself, and the highlights of lights on it as a mirror or coat.
struct PointLight {
    own: vec3f,
    highlights: vec3f,
}

// Properties of a point that say how it scatters light.
struct LitPoint {
    smooth_normal: vec3f,
    normal: vec3f,
    alpha: f32,
    coat_alpha: f32,
    // Reflectance of the dielectric at normal incidence, its largest channel, and at grazing angles.
    at_normal: f32,
    grazing: f32,
    reflectance: vec3f,
    at_grazing: f32,
    albedo: vec3f,
    coat_share: f32,
    // The share of light from infinity that arrives, and the irradiance by emitters.
    occlusion: vec3f,
    emitted: vec3f,
}

// Which light of a surface's facets is counted, where rays of its lobes find the rest.
struct LightOfFacets {
    // All of it is, and what follows is not there.
    is_all: bool,
    // The share of the light that enters which is scattered: the rest passes.
    scattering: f32,
    // The shares of the environment's reflection that are added, and of that in the coat.
    mirrored: f32,
    mirrored_by_coat: f32,
    at: LobesAt,
}

fn all_light() -> LightOfFacets {
    var light: LightOfFacets;
    light.is_all = true;
    light.mirrored = 1.0;
    light.mirrored_by_coat = 1.0;
    return light;
}

// The light of a point beside what its lobes show.
fn light_beside_lobes(at: LobesAt, mirrored: f32, mirrored_by_coat: f32) -> LightOfFacets {
    return LightOfFacets(false, 1.0 - at.transmission, mirrored, mirrored_by_coat, at);
}

fn lit_point(base: vec3f, point: SurfacePoint, texels: Texels, side: f32, light: LightOfFacets) -> LitPoint {
    let object = point.object;
    var smooth_variance = variance_over_pixel(point.normal_change2);
    var result: LitPoint;
    result.smooth_normal = point.normal * side;
    result.normal = result.smooth_normal;
    var variance = smooth_variance;
    if HAS_NORMAL_MAPS && binding_of(object, NORMALS).texture != NONE {
        let mean = texels.values[NORMALS].xyz * 2.0 - 1.0;
        let scale = surface_of(object).normal_scale;
        variance += variance_of_mean(length(mean)) * (scale * scale);
        result.normal = turned(result.smooth_normal, point.tangent, side, scale, mean);
    }
    // Without facets: a surface of Lambert's law.
    var metallic = 0.0;
    var roughness = 1.0;
    var specular = vec3f(0.0);
    var coat_roughness = LEAST_ROUGHNESS;
    if HAS_MICROFACETS && (surface_of(object).flags & MICROFACETS) != 0u {
        metallic = surface_of(object).metallic * texels.values[FACETS].z;
        roughness = max(surface_of(object).roughness * texels.values[FACETS].y, LEAST_ROUGHNESS);
        specular = surface_of(object).specular;
        result.grazing = surface_of(object).specular_at_grazing;
        result.coat_share = surface_of(object).facets_coat;
        coat_roughness = max(surface_of(object).facets_coat_roughness, LEAST_ROUGHNESS);
    }
    if HAS_LOBES && !light.is_all {
        specular = light.at.specular;
        result.grazing = light.at.grazing;
        // Coats are outside.
        result.coat_share = select(0.0, light.at.coat, side > 0.0);
        coat_roughness = max(sqrt(light.at.coat_alpha), LEAST_ROUGHNESS);
        result.smooth_normal = light.at.coat_normal * side;
        smooth_variance = 0.0;
    }
    result.occlusion = vec3f(1.0 + (texels.values[OCCLUSION].x - 1.0) * surface_of(object).occlusion_strength);
    if HAS_SKY {
        let arriving = light_onto(point, side);
        result.occlusion = min(result.occlusion, arriving.share);
        result.emitted = arriving.emitted;
    }
    result.alpha = widened_alpha(roughness * roughness, variance);
    result.coat_alpha = widened_alpha(coat_roughness * coat_roughness, smooth_variance);
    result.at_normal = largest(specular);
    result.at_grazing = result.grazing + (1.0 - result.grazing) * metallic;
    result.reflectance = specular + (base - specular) * metallic;
    result.albedo = base * (1.0 - metallic);
    if HAS_LOBES && !light.is_all {
        result.albedo *= light.scattering;
    }
    return result;
}

// A light of unit strength in a coat or mirror of facets, before Fresnel's share.
fn highlight(alpha: f32, normal: vec3f, towards: vec3f, viewer: vec3f) -> f32 {
    let half_vector = towards + viewer;
    let length2 = max(dot(half_vector, half_vector), 1e-12);
    let cosine = dot(normal, half_vector);
    let sine = cross(normal, half_vector);
    let n_l = dot(normal, towards);
    let n_v = max(dot(normal, viewer), LEAST_COSINE);
    return select(0.0, n_l * lobe(alpha, cosine * cosine / length2, dot(sine, sine) / length2, n_l, n_v), n_l > 0.0);
}

// The radiance by a light of this direction and strength, per intensity: scattered and reflected, and in the coat.
fn of_light(at: LitPoint, towards: vec3f, strength: f32, viewer: vec3f) -> array<vec3f, 2> {
    let half_vector = towards + viewer;
    let share = grazing_share(0.5 * sqrt(max(dot(half_vector, half_vector), 1e-12)));
    let irradiance = max(dot(at.normal, towards), 0.0) * strength;
    let scattered = irradiance * FRAC_1_PI * (1.0 - at.at_normal - (at.grazing - at.at_normal) * share);
    var reflected = 0.0;
    if HAS_MICROFACETS {
        reflected = strength * highlight(at.alpha, at.normal, towards, viewer);
    }
    let fresnel = at.reflectance + (at.at_grazing - at.reflectance) * share;
    var coat = 0.0;
    if HAS_MICROFACETS && at.coat_share > 0.0 {
        coat = strength * highlight(at.coat_alpha, at.smooth_normal, towards, viewer);
    }
    return array<vec3f, 2>(at.albedo * scattered + fresnel * reflected, vec3f(coat));
}

// The radiance by the environment and by emitters: scattered and reflected, and in the coat. The irradiance by suns is
// given.
fn of_environment(at: LitPoint, viewer: vec3f, light: LightOfFacets, by_suns: vec3f) -> array<vec3f, 2> {
    let counted = vec2f(light.mirrored, light.mirrored_by_coat);
    var alphas = array<f32, 2>(at.alpha, at.coat_alpha);
    var normals = array<vec3f, 2>(at.normal, at.smooth_normal);
    var shares = vec2f(0.0);
    var reflected = array<vec3f, 2>(vec3f(0.0), vec3f(0.0));
    for (var layer = 0u; HAS_MICROFACETS && layer < select(1u, 2u, at.coat_share > 0.0); layer++) {
        let normal = normals[layer];
        let n_v = dot(normal, viewer);
        let surroundings = reflected_surroundings(sqrt(alphas[layer]), max(n_v, LEAST_COSINE));
        let across = normal * (2.0 * n_v) - viewer;
        let middle = normalize_or(normal + (across - normal) * surroundings.z, normal);
        shares = select(shares, surroundings.xy, layer == 0u);
        // Without any reflection there is nothing to look up.
        if HAS_ENVIRONMENT && counted[layer] > 0.0 && (layer == 1u || at.grazing > 0.0 || largest(at.reflectance) > 0.0) {
            reflected[layer] = environment_glossy(middle, min(alphas[layer] * surroundings.w, 1.0));
        }
    }
    let entering = 1.0 - (at.at_normal * shares.x + at.grazing * shares.y);
    var scattered = vec3f(0.0);
    if HAS_ENVIRONMENT {
        scattered = environment_irradiance(at.normal) * (FRAC_1_PI * entering);
    }
    if HAS_LOBES && !light.is_all {
        reflected[0] *= counted.x;
        reflected[1] *= counted.y;
    }
    let reflectance = at.reflectance * shares.x + at.at_grazing * shares.y;
    var sum = at.occlusion * (at.albedo * scattered + reflectance * reflected[0]);
    if HAS_SKY {
        // Their shadows are known, and no texture's matter.
        sum += at.albedo * (by_suns + at.emitted) * (FRAC_1_PI * entering);
    }
    return array<vec3f, 2>(sum, at.occlusion * reflected[1]);
}

// The facets that mirror lights within a point's footprint: normals on the viewer's side, and the width of the
// distribution about each.
struct HighlightNormals {
    normals: array<vec3f, 4>,
    alphas: array<f32, 4>,
    count: u32,
}

// Where bumps spread highlights, and the point stands for several samples of a pixel, those at the places of four of
// them.
fn normals_of_highlights(point: SurfacePoint, alpha: f32, side: f32) -> HighlightNormals {
    let smooth_variance = variance_over_pixel(point.normal_change2);
    let whole = normal_of_map(point);
    var result: HighlightNormals;
    result.count = 1u;
    result.normals[0] = whole.normal * side;
    result.alphas[0] = widened_alpha(alpha, whole.variance + smooth_variance);
    if HAS_NORMAL_MAPS && point.samples > 1u && whole.variance > HARDLY_SPREAD * alpha * alpha {
        result.count = 4u;
        for (var place = 0u; place < 4u; place++) {
            // The places of four samples.
            let offset = places_of_samples[3u + place] / 16.0 - 0.5;
            let part = normal_of_map(part_of_textures(point, offset, 0.5));
            result.normals[place] = part.normal * side;
            result.alphas[place] = widened_alpha(alpha, part.variance + smooth_variance);
        }
    }
    return result;
}

// The light of a point: its own where `is_lit`, from this base colour, and the highlights of a mirror or coat of a tint
// (of coats: the share that they cover) where it has any; of facets so much as is counted.
fn point_light(
    base: vec3f,
    tint: vec3f,
    point: SurfacePoint,
    texels: Texels,
    viewer: vec3f,
    is_lit: bool,
    of_facets: LightOfFacets,
) -> PointLight {
    let object = point.object;
    let flags = surface_of(object).flags;
    var result: PointLight;
    if (flags & UNLIT) != 0u {
        result.own = finite(base);
        return result;
    }
    let side = select(1.0, -1.0, dot(point.geometric_normal, viewer) < 0.0);
    let at = lit_point(base, point, texels, side, of_facets);
    let roughness = surface_of(object).highlight_roughness;
    let is_blind = side > 0.0 && (flags & INSIDE) != 0u;
    let is_mirror = HAS_HIGHLIGHTS && roughness >= 0.0 && !is_blind;
    let least = max(roughness, LEAST_ROUGHNESS);
    var of_highlights: HighlightNormals;
    if is_mirror {
        of_highlights = normals_of_highlights(point, least * least, side);
    }
    var sum = vec3f(0.0);
    var coat_sum = vec3f(0.0);
    var highlights = vec3f(0.0);
    var start = vec3f(0.0);
    if HAS_SHADOWS {
        start = shadow_start(point, side);
    }
    var by_suns = vec3f(0.0);
    let light_count = frame.light_count + select(0u, frame.sun_count, HAS_SUNS);
    for (var light = 0u; (HAS_LIGHTS || HAS_SUNS) && light < light_count; light++) {
        let is_sun = HAS_SUNS && light >= frame.light_count;
        let arrives = arriving(light, point.position);
        let cosine = dot(at.normal, arrives.xyz);
        // Suns are a part of the environment, which makes their highlights.
        let faces = cosine > 0.0 || (dot(at.smooth_normal, arrives.xyz) > 0.0 && !is_sun);
        var of_mirror = vec3f(0.0);
        if is_mirror && !is_sun {
            let share = grazing_share(0.5 * length(arrives.xyz + viewer));
            var reflectance = tint;
            if surface_of(object).role == COATED {
                reflectance = tint * (COAT_REFLECTANCE + (1.0 - COAT_REFLECTANCE) * share);
            } else if (flags & SCHLICK) != 0u {
                reflectance = tint + (1.0 - tint) * share;
            }
            var reflected = 0.0;
            for (var place = 0u; place < of_highlights.count; place++) {
                reflected += highlight(of_highlights.alphas[place], of_highlights.normals[place], arrives.xyz, viewer);
            }
            let mirrored = reflectance * (reflected / f32(of_highlights.count));
            of_mirror = scene.lights[light].intensity * arrives.w * mirrored;
        }
        let shows = (is_lit && faces) || largest(of_mirror) > FAINTEST_HIGHLIGHT;
        if !(arrives.w > 0.0 && shows) {
            continue;
        }
        let share = share_of_light(light, start);
        let intensity = scene.lights[light].intensity * share;
        if is_sun {
            by_suns += intensity * cosine;
            continue;
        }
        let given = of_light(at, arrives.xyz, arrives.w, viewer);
        sum += intensity * given[0];
        coat_sum += intensity * given[1];
        highlights += share * select(vec3f(0.0), of_mirror, largest(of_mirror) > FAINTEST_HIGHLIGHT);
    }
    if (HAS_ENVIRONMENT || HAS_SKY) && is_lit {
        let given = of_environment(at, viewer, of_facets, by_suns);
        sum += given[0];
        coat_sum += given[1];
    }
    if HAS_MICROFACETS && at.coat_share > 0.0 {
        let share = grazing_share(max(dot(at.smooth_normal, viewer), 0.0));
        let fresnel = at.coat_share * (COAT_REFLECTANCE + (1.0 - COAT_REFLECTANCE) * share);
        sum = sum * (1.0 - fresnel) + coat_sum * fresnel;
    }
    // Without any light one travels with the path.
    if !HAS_LIGHTS && !HAS_ENVIRONMENT {
        sum = base * max(dot(at.normal, viewer), 0.0);
    }
    result.own = finite(sum + surface_of(object).emissive * texels.values[EMISSIVE].xyz);
    result.highlights = finite(highlights);
    return result;
}
