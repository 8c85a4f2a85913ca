// Look-ups in cube maps of reflectors: the twin of `light/cube_map`, `light/parallax_proxy` and
// `methods/reflector_maps`.

//#include "light/cubes.wgsl"
//#include "light/surrounds.wgsl"

// The map of an object: where it was captured, the shape of what surrounds it, and its cube.
struct ReflectorMap {
    center: vec3f,
    // In the table times 256 and with the number of the object's light field (from 1; 0: none): devices bind no more
    // than 16 tables.
    shape: u32,
    // The lower corner of a box (`high`: the upper one); the radius of a sphere in its first component.
    low: vec3f,
    // Texels a side; 0: the scene's background is read.
    size: u32,
    high: vec3f,
    // The first texel.
    first: u32,
}

const REFLECTOR_MAP_TEXELS = 3u;

// Shapes. Without any the object has no map.
const NO_MAP = 0u;
const INFINITE = 1u;
const BOX = 2u;
const SPHERE = 3u;

const MOST_PROBES = 8.0;
// Texels around each face of the finest level.
const MAP_BORDER = 1u;

@group(3) @binding(0) var map_table: texture_2d<u32>;
@group(3) @binding(1) var map_texels: texture_2d<f32>;

fn reflector_map_of(object: u32) -> ReflectorMap {
    let first = textureLoad(map_table, row_of(object * REFLECTOR_MAP_TEXELS), 0);
    let second = textureLoad(map_table, row_of(object * REFLECTOR_MAP_TEXELS + 1u), 0);
    let third = textureLoad(map_table, row_of(object * REFLECTOR_MAP_TEXELS + 2u), 0);
    return ReflectorMap(
        bitcast<vec3f>(first.xyz), first.w >> 8u,
        bitcast<vec3f>(second.xyz), second.w,
        bitcast<vec3f>(third.xyz), third.w,
    );
}

// The number of an object's light field, from 1; 0: it has none.
fn field_number_of(object: u32) -> u32 {
    return textureLoad(map_table, row_of(object * REFLECTOR_MAP_TEXELS), 0).w & 0xffu;
}

// The place of a level among the texels of a face; its size with the border.
fn level_place(size: u32, level: u32) -> vec2u {
    if level == 0u {
        return vec2u(0u, size + 2u * MAP_BORDER);
    }
    var first = (size + 2u * MAP_BORDER) * (size + 2u * MAP_BORDER);
    for (var finer = 1u; finer < level; finer++) {
        first += (size >> finer) * (size >> finer);
    }
    return vec2u(first, size >> level);
}

fn texels_of_face(size: u32) -> u32 {
    let last = level_place(size, firstLeadingBit(size));
    return last.x + last.y * last.y;
}

fn map_texel(index: u32) -> vec3f {
    return textureLoad(map_texels, row_of(index), 0).xyz;
}

fn bilinear(map: ReflectorMap, face: u32, level: u32, at: vec2f) -> vec3f {
    let place = level_place(map.size, level);
    let border = select(0u, MAP_BORDER, level == 0u);
    let side = place.y;
    let position = (at + 1.0) * (0.5 * f32(side - 2u * border)) + f32(border) - 0.5;
    let inside = clamp(position, vec2f(0.0), vec2f(f32(side) - 1.0));
    let share = inside - floor(inside);
    let low = vec2u(inside);
    let high = min(low + 1u, vec2u(side - 1u));
    let first = map.first + face * texels_of_face(map.size) + place.x;
    let upper = mix(map_texel(first + low.y * side + low.x), map_texel(first + low.y * side + high.x), share.x);
    let lower = mix(map_texel(first + high.y * side + low.x), map_texel(first + high.y * side + high.x), share.x);
    return mix(upper, lower, share.y);
}

// The radiance of a cube from a direction of any length above 0, blurred over a spread in radians.
fn cube_radiance(map: ReflectorMap, direction: vec3f, spread: f32) -> vec3f {
    let place = locate(direction);
    let texels = texels_across(spread, map.size, place.secant2);
    let last = firstLeadingBit(map.size);
    let level = select(0.0, min(log2(texels), f32(last)), texels > 1.0);
    let whole = u32(level);
    let blend = level - f32(whole);
    var sum = vec3f(0.0);
    for (var step = 0u; step < select(1u, 2u, blend > 0.0); step++) {
        let share = select(1.0 - blend, blend, step == 1u);
        sum += share * bilinear(map, place.face, min(whole + step, last), place.at);
    }
    return sum;
}

// Blurred over a footprint: the changes of the unit direction from pixel to pixel.
fn filtered_cube(map: ReflectorMap, direction: vec3f, dx: vec3f, dy: vec3f) -> vec3f {
    let row = probe_row(dx, dy, MOST_PROBES);
    var sum = vec3f(0.0);
    for (var probe = 0.0; probe < row.count; probe += 1.0) {
        sum += cube_radiance(map, direction + row.axis * ((probe + 0.5) / row.count - 0.5), row.spread);
    }
    return sum / row.count;
}

// How far a ray goes until it meets the shape of what surrounds a map; FAR where it never does.
fn proxy_distance(map: ReflectorMap, ray: Ray) -> f32 {
    switch map.shape {
        case BOX: { return box_distance(map.low, map.high, ray.origin, ray.direction); }
        case SPHERE: { return sphere_distance(map.low.x, ray.origin - map.center, ray.direction); }
        default: { return FAR; }
    }
}

// The direction of a map that a ray reads, not of unit length.
fn map_direction(map: ReflectorMap, ray: Ray) -> vec3f {
    let distance = proxy_distance(map, ray);
    let found = ray.origin - map.center + ray.direction * distance;
    return select(ray.direction, found, distance < FAR && dot(found, found) > 0.0);
}

// The radiance along a ray that leaves a reflector, of a pixel's footprint.
fn map_radiance(map: ReflectorMap, ray: Ray, change: RayDifferential) -> vec3f {
    if map.shape == NO_MAP {
        return vec3f(0.0);
    }
    var origins = array<vec3f, 3>(vec3f(0.0), change.origin_dx, change.origin_dy);
    var turns = array<vec3f, 3>(vec3f(0.0), change.direction_dx, change.direction_dy);
    var found: array<vec3f, 3>;
    for (var index = 0u; index < 3u; index++) {
        let direction = normalize_or(ray.direction + turns[index], ray.direction);
        let read = map_direction(map, Ray(ray.origin + origins[index], direction));
        found[index] = normalize_or(read, vec3f(0.0));
    }
    if map.size == 0u {
        return background(select(found[0], ray.direction, all(found[0] == vec3f(0.0))));
    }
    return filtered_cube(map, found[0], found[1] - found[0], found[2] - found[0]);
}
