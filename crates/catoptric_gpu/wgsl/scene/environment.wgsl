// Light from infinity: the twin of `scene/shading/environment`.

const GLOSSY_LEVELS = 7;

@group(0) @binding(6) var environment_picture: texture_2d<f32>;
// Maps one above the other, each with a border of one texel.
@group(0) @binding(7) var environment_maps: texture_2d<f32>;

fn environment_position(direction: vec3f) -> vec2f {
    let azimuth = atan2(direction.z, direction.x);
    let polar = atan2(length(direction.xz), direction.y);
    return vec2f(azimuth * (0.5 * FRAC_1_PI) + 0.5, polar * FRAC_1_PI);
}

fn environment_neighbours(size: vec2i, left: i32, row: i32) -> array<vec3f, 2> {
    let is_beyond = row < 0 || row >= size.y;
    var column = select(left, left + size.x / 2, is_beyond);
    column = (column + 2 * size.x) % size.x;
    let inside = clamp(row, 0, size.y - 1);
    return array<vec3f, 2>(
        textureLoad(environment_picture, vec2i(column, inside), 0).xyz,
        textureLoad(environment_picture, vec2i((column + 1) % size.x, inside), 0).xyz,
    );
}

fn environment_at(position: vec2f) -> vec3f {
    let size = vec2i(textureDimensions(environment_picture));
    let at = position * vec2f(size) - 0.5;
    let corner = vec2i(floor(at));
    let share = at - floor(at);
    let upper = environment_neighbours(size, corner.x, corner.y);
    let lower = environment_neighbours(size, corner.x, corner.y + 1);
    return mix(mix(upper[0], upper[1], share.x), mix(lower[0], lower[1], share.x), share.y);
}

// The value of a map at a position.
fn environment_map_at(map: u32, position: vec2f) -> vec3f {
    let place = frame.maps[map];
    let size = vec2f(place.xy);
    let at = clamp(position * size + 0.5, vec2f(0.0), size);
    let whole = vec2i(at);
    let share = at - vec2f(whole);
    let corner = whole + vec2i(0, i32(place.z));
    let upper = mix(
        textureLoad(environment_maps, corner, 0).xyz,
        textureLoad(environment_maps, corner + vec2i(1, 0), 0).xyz,
        share.x,
    );
    let lower = mix(
        textureLoad(environment_maps, corner + vec2i(0, 1), 0).xyz,
        textureLoad(environment_maps, corner + vec2i(1, 1), 0).xyz,
        share.x,
    );
    return mix(upper, lower, share.y);
}

fn environment_irradiance(normal: vec3f) -> vec3f {
    return environment_map_at(0u, environment_position(normal));
}

// The mean radiance over the highlight of a rough surface around a direction.
fn environment_glossy(direction: vec3f, alpha: f32) -> vec3f {
    let position = environment_position(direction);
    let sharpest = 1.0 / f32(1 << u32(GLOSSY_LEVELS - 1));
    if alpha < sharpest {
        let sharp = environment_at(position);
        let blurred = environment_map_at(u32(GLOSSY_LEVELS), position);
        return sharp + (blurred - sharp) * max(alpha / sharpest, 0.0);
    }
    let bits = bitcast<u32>(min(alpha, 1.0));
    let whole = 127 - i32(bits >> 23u);
    let mantissa = bitcast<f32>((bits & 0x007fffffu) | 0x3f800000u);
    let level = clamp(whole, 1, GLOSSY_LEVELS - 1);
    let share = select(mantissa - 1.0, 1.0, whole < 1);
    let sharp = environment_map_at(u32(level) + 1u, position);
    return sharp + (environment_map_at(u32(level), position) - sharp) * share;
}

fn background(direction: vec3f) -> vec3f {
    if !HAS_ENVIRONMENT {
        return vec3f(0.0);
    }
    return environment_at(environment_position(direction));
}
