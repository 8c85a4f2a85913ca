// Normals that a map turns, and mirrors and glass with such maps: the twin of `scene/shading/bumps`.

// The step over which the change of a normal is found, in pixels.
const BUMP_STEP_PX = 0.5;
// Bumps smaller than a pixel whose variance is below this share of the facets' own do not spread highlights.
const HARDLY_SPREAD = 0.1;

// A normal, and how much normals differ within its footprint.
struct TurnedNormal {
    normal: vec3f,
    variance: f32,
}

struct TurnedEncounter {
    met: SurfaceInteraction,
    variance: f32,
}

// A unit normal, turned by a mean of a map's normals.
fn turned(smooth_normal: vec3f, tangent: vec4f, side: f32, scale: f32, mean: vec3f) -> vec3f {
    let rejected = tangent.xyz - smooth_normal * dot(tangent.xyz, smooth_normal);
    let length2 = dot(rejected, rejected);
    if !(length2 > 1e-36) {
        return smooth_normal;
    }
    let along = rejected * inverseSqrt(length2);
    let bitangent = cross(smooth_normal, along) * (tangent.w * side);
    let slopes = mean.xy * (scale * side);
    return normalize_or(along * slopes.x + bitangent * slopes.y + smooth_normal * mean.z, smooth_normal);
}

// A part of a point's footprints in textures: so many pixels beside the middle, of a side in pixels.
fn part_of_textures(whole: SurfacePoint, offset: vec2f, side: f32) -> SurfacePoint {
    var point = whole;
    point.uvs += whole.uvs_dx * offset.x + whole.uvs_dy * offset.y;
    point.uvs_dx *= side;
    point.uvs_dy *= side;
    point.samples = 1u;
    return point;
}

// A part of what a ray meets, to first order.
fn part_of_encounter(whole: SurfaceInteraction, offset: vec2f, side: f32) -> SurfaceInteraction {
    var part = whole;
    part.point = part_of_textures(whole.point, offset, side);
    part.point.position += whole.position_dx * offset.x + whole.position_dy * offset.y;
    let turned_by = whole.normal_dx * offset.x + whole.normal_dy * offset.y;
    part.point.normal = normalize_or(whole.point.normal + turned_by, whole.point.normal);
    part.point.normal_change2 *= side * side;
    part.position_dx *= side;
    part.position_dy *= side;
    part.normal_dx *= side;
    part.normal_dy *= side;
    return part;
}

// The longer axis of a footprint in a texture, in texels.
fn texels_across_longer(binding: Binding, point: SurfacePoint) -> f32 {
    let size = texture_of(binding.texture).size;
    let at = look_up(binding, point);
    return max(length(at.dx * size), length(at.dy * size));
}

// The share of a map's variance that a point's footprint hides: within a texel normals are blended, which makes them
// shorter, but each is that of a place.
fn hidden_share(binding: Binding, point: SurfacePoint) -> f32 {
    return clamp(log2(max(texels_across_longer(binding, point), 1e-6)), 0.0, 1.0);
}

// The normal of a point by the map of its surface that turns rays.
fn normal_of_map(point: SurfacePoint) -> TurnedNormal {
    let place = surface_of(point.object).turning_map;
    if !HAS_NORMAL_MAPS || place == NONE || all(point.tangent.xyz == vec3f(0.0)) {
        return TurnedNormal(point.normal, 0.0);
    }
    let binding = binding_of(point.object, place);
    let scale = surface_of(point.object).turning_scale;
    let mean = sample_binding(point.object, place, point).xyz * 2.0 - 1.0;
    let variance = variance_of_mean(length(mean)) * (scale * scale) * hidden_share(binding, point);
    return TurnedNormal(turned(point.normal, point.tangent, 1.0, scale, mean), variance);
}

// The encounter of a ray, with the normal that the map turns and its change. The surface's own light is computed with
// the encounter before.
fn turned_encounter(met: SurfaceInteraction) -> TurnedEncounter {
    var result: TurnedEncounter;
    result.met = met;
    if !HAS_TURNS || surface_of(met.point.object).turning_map == NONE {
        return result;
    }
    var found: array<TurnedNormal, 3>;
    // A loop, not three calls: compilers copy functions to each place that calls them.
    for (var index = 0u; index < 3u; index++) {
        let step = vec2f(select(0.0, BUMP_STEP_PX, index == 1u), select(0.0, BUMP_STEP_PX, index == 2u));
        var point = met.point;
        point.uvs += point.uvs_dx * step.x + point.uvs_dy * step.y;
        point.normal = normalize_or(point.normal + met.normal_dx * step.x + met.normal_dy * step.y, point.normal);
        found[index] = normal_of_map(point);
    }
    result.met.point.normal = found[0].normal;
    result.met.normal_dx = (found[1].normal - found[0].normal) / BUMP_STEP_PX;
    result.met.normal_dy = (found[2].normal - found[0].normal) / BUMP_STEP_PX;
    result.variance = found[0].variance;
    return result;
}
