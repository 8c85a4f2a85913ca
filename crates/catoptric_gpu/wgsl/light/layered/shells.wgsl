// Shells around groups of reflectors, from their centres, and the texels of their textures: the twin of
// `methods/lookup/layered_environment_map/shells/shell` and `textures/texels`.

// A layer: the shape that stands in for its things, and where its tables begin.
struct Layer {
    center: vec3f,
    shape: u32,
    // The lower corner of a box; the radius of a sphere, and of a cylinder with its bottom and top; the middle of a
    // quad.
    low: vec3f,
    // Texels a side of the finest level.
    size: u32,
    // The upper corner of a box; the normal of a quad.
    high: vec3f,
    // Six, or one of a quad.
    faces: u32,
    // A quad's vectors to the right and (`up`) upwards, over their squared lengths.
    right: vec3f,
    // The smallest and the largest share of the shell at which anything is shown.
    least: f32,
    up: vec3f,
    most: f32,
    // Not 0: texels have depths.
    has_depths: u32,
    // The first word of these; what their codes count from, and in which steps.
    first_depth: u32,
    depth_base: u32,
    depth_shift: u32,
    // The first word of bounds of depths, or NONE, and how many levels they have.
    first_bound: u32,
    bound_levels: u32,
    unused: vec2u,
    // The first texel of each viewpoint's texture.
    first_texels: vec4u,
}

// Shapes.
const SHELL_INFINITE = 0u;
const SHELL_BOX = 1u;
const SHELL_SPHERE = 2u;
const SHELL_CYLINDER = 3u;
const SHELL_QUAD = 4u;

const LEAST_NUMBER = 1.1754944e-38;
// Surfaces are taken to be no more oblique than this, as a ratio of a footprint's lengths.
const MAX_OBLIQUE = 8.0;
// The largest ratio of a footprint's axes that is resolved by several look-ups.
const MOST_LAYER_PROBES = 4.0;

// Four half floats a texel: radiance times opacity, and opacity.
@group(3) @binding(2) var layer_texels: texture_2d<f32>;
// Depths, two codes a word, and bounds of them.
@group(3) @binding(3) var layer_words: texture_2d<u32>;

// A ray from a centre, with its changes from pixel to pixel.
struct ShellRay {
    origin: vec3f,
    direction: vec3f,
    moved: array<vec3f, 2>,
    turned: array<vec3f, 2>,
}

fn shell_ray(ray: Ray, change: RayDifferential, center: vec3f) -> ShellRay {
    return ShellRay(
        ray.origin - center,
        ray.direction,
        array<vec3f, 2>(change.origin_dx, change.origin_dy),
        array<vec3f, 2>(change.direction_dx, change.direction_dy),
    );
}

fn at_distance(ray: ShellRay, distance: f32) -> vec3f {
    return ray.origin + ray.direction * distance;
}

// How far a ray goes until it meets the shell; FAR where it never does.
fn shell_distance(layer: Layer, origin: vec3f, direction: vec3f) -> f32 {
    switch layer.shape {
        case SHELL_BOX: {
            return box_distance(layer.low, layer.high, origin, direction);
        }
        case SHELL_SPHERE: {
            return sphere_distance(layer.low.x, origin, direction);
        }
        case SHELL_CYLINDER: {
            return cylinder_distance(layer.low.x, layer.low.y, layer.low.z, origin, direction);
        }
        case SHELL_QUAD: {
            let distance = dot(layer.low - origin, layer.high) / dot(direction, layer.high);
            return select(FAR, distance, distance > 0.0 && distance < FAR);
        }
        default: {
            return FAR;
        }
    }
}

// The same where the shell is grown by a share about the centre.
fn grown_distance(layer: Layer, ray: ShellRay, share: f32) -> f32 {
    let distance = shell_distance(layer, ray.origin / share, ray.direction);
    return select(FAR, min(distance * share, FAR), distance < FAR);
}

// By what share the shell is to be grown about the centre to go through a place.
fn shell_scale(layer: Layer, place: vec3f) -> f32 {
    switch layer.shape {
        case SHELL_BOX: {
            let sides = abs(select(layer.low, layer.high, place > vec3f(0.0)));
            let shares = select(abs(place) / sides, vec3f(FAR), sides == vec3f(0.0));
            // Nothing over nothing is left out.
            let known = select(vec3f(0.0), shares, place != vec3f(0.0));
            return min(max(known.x, max(known.y, known.z)), FAR);
        }
        case SHELL_SPHERE: {
            return length(place) / layer.low.x;
        }
        case SHELL_CYLINDER: {
            let end = abs(place.y) / abs(select(layer.low.y, layer.low.z, place.y > 0.0));
            return min(max(length(place.xz) / layer.low.x, select(0.0, end, end > 0.0)), FAR);
        }
        case SHELL_QUAD: {
            return max(dot(place, layer.high / dot(layer.low, layer.high)), 0.0);
        }
        default: {
            return 0.0;
        }
    }
}

// The place of a quad that a ray meets. Rays that do not meet the plane are laid along it and meet it far away.
fn quad_place(layer: Layer, origin: vec3f, direction: vec3f) -> vec3f {
    let towards = dot(direction, layer.high);
    let distance = dot(layer.low - origin, layer.high) / towards;
    let met = origin + direction * distance - layer.low;
    let laid = (direction - layer.high * towards) * (1e3 * length(layer.low));
    let place = select(laid, met, distance > 0.0 && distance < FAR);
    return vec3f(dot(place, layer.right), dot(place, layer.up), 0.0);
}

fn unit_or(vector: vec3f, otherwise: vec3f) -> vec3f {
    let scale = 1.0 / sqrt(dot(vector, vector));
    return select(otherwise, vector * scale, scale > 0.0 && scale < FAR);
}

// Where a ray looks the shell up: a unit direction, or a place of the square.
fn shell_place(layer: Layer, origin: vec3f, direction: vec3f) -> vec3f {
    if layer.shape == SHELL_QUAD {
        return quad_place(layer, origin, direction);
    }
    let distance = shell_distance(layer, origin, direction);
    let found = origin + direction * distance;
    return unit_or(select(direction, found, distance < FAR && dot(found, found) > 0.0), direction);
}

// Where a place is looked up as it is seen from the centre.
fn seen_at(layer: Layer, place: vec3f) -> vec3f {
    if layer.shape == SHELL_QUAD {
        return quad_place(layer, vec3f(0.0), place);
    }
    return place;
}

// Where a look-up is, and how that changes from pixel to pixel.
struct LayerFootprint {
    place: vec3f,
    changes: array<vec3f, 2>,
}

fn layer_footprint(layer: Layer, ray: ShellRay) -> LayerFootprint {
    var result: LayerFootprint;
    result.place = shell_place(layer, ray.origin, ray.direction);
    var moved = ray.moved;
    var turned = ray.turned;
    for (var neighbour = 0u; neighbour < 2u; neighbour++) {
        let direction = unit_or(ray.direction + turned[neighbour], ray.direction);
        result.changes[neighbour] = shell_place(layer, ray.origin + moved[neighbour], direction) - result.place;
    }
    return result;
}

fn face_place(layer: Layer, place: vec3f) -> CubePlace {
    if layer.faces == 6u {
        return locate(place);
    }
    return CubePlace(0u, place.xy, 1.0);
}

// The texel of the finest level that a place lies in, or is nearest to: face, column and row.
fn in_texels(layer: Layer, located: CubePlace) -> vec3u {
    let place = (located.at + 1.0) * (0.5 * f32(layer.size));
    let within = floor(min(max(place, vec2f(0.0)), vec2f(f32(layer.size - 1u))));
    return vec3u(located.face, vec2u(within));
}

// The first texel of a level of all faces.
fn first_of_level(layer: Layer, level: u32) -> u32 {
    var first = 0u;
    for (var finer = 0u; finer < level; finer++) {
        first += layer.faces * (layer.size >> finer) * (layer.size >> finer);
    }
    return first;
}

// The direction to a place of a face of a cube.
fn direction_of(face: u32, at: vec2f) -> vec3f {
    switch face {
        case 0u: { return vec3f(1.0, -at.y, -at.x); }
        case 1u: { return vec3f(-1.0, -at.y, at.x); }
        case 2u: { return vec3f(at.x, 1.0, at.y); }
        case 3u: { return vec3f(at.x, -1.0, -at.y); }
        case 4u: { return vec3f(at.x, -at.y, 1.0); }
        default: { return vec3f(-at.x, -at.y, -1.0); }
    }
}

// A texel of a level, or that of the next face where it lies beyond an edge; NONE beyond the edge of a square.
fn texel_of_face(layer: Layer, first: u32, side: u32, face: u32, column: i32, row: i32) -> u32 {
    let last = i32(side) - 1;
    if column >= 0 && column <= last && row >= 0 && row <= last {
        return first + (face * side + u32(row)) * side + u32(column);
    }
    if layer.faces != 6u {
        return NONE;
    }
    let at = (vec2f(f32(column), f32(row)) + 0.5) * (2.0 / f32(side)) - 1.0;
    let next = locate(direction_of(face, at));
    let place = clamp((next.at + 1.0) * (0.5 * f32(side)), vec2f(0.0), vec2f(f32(side - 1u)));
    return first + (next.face * side + u32(place.y)) * side + u32(place.x);
}

fn layer_texel(index: u32) -> vec4f {
    return textureLoad(layer_texels, row_of(index), 0);
}

fn layer_bilinear(layer: Layer, texels: u32, located: CubePlace, level: u32) -> vec4f {
    let side = layer.size >> level;
    // Places far beyond a square read nothing.
    let place = clamp((located.at + 1.0) * (0.5 * f32(side)) - 0.5, vec2f(-2.0), vec2f(f32(side) + 1.0));
    let low = floor(place);
    let share = place - low;
    let first = texels + first_of_level(layer, level);
    var sum = vec4f(0.0);
    for (var corner = 0u; corner < 4u; corner++) {
        let aside = vec2u(corner & 1u, corner >> 1u);
        let weights = select(1.0 - share, share, aside == vec2u(1u));
        let index = vec2i(low) + vec2i(aside);
        let texel = texel_of_face(layer, first, side, located.face, index.x, index.y);
        if texel != NONE {
            sum += layer_texel(texel) * (weights.x * weights.y);
        }
    }
    return sum;
}

// Radiance times opacity, and opacity, over a footprint: trilinear look-ups side by side along its longer axis.
fn layer_seen(layer: Layer, texels: u32, footprint: LayerFootprint) -> vec4f {
    let row = probe_row(footprint.changes[0], footprint.changes[1], MOST_LAYER_PROBES);
    let last = firstLeadingBit(layer.size);
    var sum = vec4f(0.0);
    for (var probe = 0.0; probe < row.count; probe += 1.0) {
        let located = face_place(layer, footprint.place + row.axis * ((probe + 0.5) / row.count - 0.5));
        let wide = texels_across(row.spread, layer.size, located.secant2);
        // Between two levels the blend is linear in the width: exponent and mantissa are level and blend.
        let bits = bitcast<u32>(select(1.0, wide, wide > 1.0));
        let exponent = (bits >> 23u) - 127u;
        let level = min(exponent, last);
        let blend = select(0.0, bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u) - 1.0, exponent < last);
        sum += layer_bilinear(layer, texels, located, level) * ((1.0 - blend) / row.count);
        if blend > 0.0 {
            sum += layer_bilinear(layer, texels, located, level + 1u) * (blend / row.count);
        }
    }
    return sum;
}
