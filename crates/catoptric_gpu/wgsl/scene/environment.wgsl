// Light from infinity: the twin of `scene/shading/environment`.

const GLOSSY_LEVELS = 7;

@group(0) @binding(6) var environment_picture: texture_2d<f32>;
// Maps one above the other, each with a border of one texel.
@group(0) @binding(7) var environment_maps: texture_2d<f32>;

fn environment_position(direction: vec3f) -> vec2f {
    let azimuth = atan2(direction.z, direction.x);
    let polar = atan2(length(direction.xz), direction.y);
    // The environment may be turned about the y axis.
    let across = azimuth * (0.5 * FRAC_1_PI) + 0.5 + bitcast<f32>(frame.maps[1].w);
    return vec2f(select(across, across - 1.0, across > 1.0), polar * FRAC_1_PI);
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
    return environment_place_at(frame.maps[map], position);
}

// The same of a map at a place: its width, height and first row.
fn environment_place_at(place: vec4u, position: vec2f) -> vec3f {
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

// The most places at which the picture is read for a cone, and the largest change of its direction.
const MOST_PLACES = 16.0;
const LARGEST_CHANGE = 0.25;
// The widest cone whose light is looked up at one place.
const LARGEST_CONE = 1.2;
// The solid angle of a lamp, at most.
const LAMP_SOLID_ANGLE = 0.0096382;

// The radiance at a position of a reduction; 0: the picture as it is.
fn environment_at_whole_level(position: vec2f, level: u32) -> vec3f {
    let count = frame.maps[0].w;
    if level == 0u || count == 0u {
        return environment_at(position);
    }
    return environment_place_at(frame.reductions[min(level, count) - 1u], position);
}

// The mean radiance over a cone: from a direction that changes so much.
fn environment_over(direction: vec3f, dx: vec3f, dy: vec3f) -> vec3f {
    // Larger changes say little of what lies half of them away.
    let change_x = dx * min(1.0, LARGEST_CHANGE / max(length(dx), 1e-12));
    let change_y = dy * min(1.0, LARGEST_CHANGE / max(length(dy), 1e-12));
    let texels_per_radian = f32(textureDimensions(environment_picture).x) / TAU;
    let texels = vec2f(length(change_x), length(change_y)) * texels_per_radian;
    let is_across = texels.x >= texels.y;
    let long = max(texels.x, texels.y);
    let short = min(texels.x, texels.y);
    var places = 1.0;
    var level = 0.0;
    // Within half a texel the picture is a ramp; what is not a number is read as one place.
    if long >= 0.5 {
        places = ceil(clamp(2.0 * long / max(short, 0.5), 4.0, MOST_PLACES));
        level = min(log2(max(max(0.5 * short, long / places), 1.0)), f32(frame.maps[0].w));
    }
    let whole = u32(level);
    let share = level - f32(whole);
    var sum = vec3f(0.0);
    for (var place = 0.0; place < places; place += 1.0) {
        var towards = direction;
        if places > 1.0 {
            // Places follow each other along the longer side, every second one nearer to one end of the shorter side.
            let along = (place + 0.5) / places - 0.5;
            let aside = select(0.25, -0.25, u32(place) % 2u == 0u);
            let step = select(change_y * along + change_x * aside, change_x * along + change_y * aside, is_across);
            towards = normalize_or(direction + step, direction);
        }
        let position = environment_position(towards);
        for (var finer = 0u; finer < select(1u, 2u, share > 0.0); finer++) {
            let weight = select(1.0 - share, share, finer == 1u);
            sum += weight * environment_at_whole_level(position, whole + finer);
        }
    }
    return sum / places;
}

// The reduction whose texels are as wide as an angle; 0: the picture itself.
fn level_within(across: f32) -> f32 {
    // Between texels of a reduction the picture is as smooth as over a cone that is wider by this factor.
    let smoothing = 1.732;
    let texels_per_radian = f32(textureDimensions(environment_picture).x) / TAU;
    let texels = max(min(across, LARGEST_CONE) * texels_per_radian / smoothing, 1.0);
    return min(log2(texels), f32(frame.maps[0].w));
}

// The mean radiance within an angle across, on all sides of a direction.
fn environment_within(direction: vec3f, across: f32) -> vec3f {
    let level = level_within(across);
    let whole = u32(level);
    let position = environment_position(direction);
    let fine = environment_at_whole_level(position, whole);
    return mix(fine, environment_at_whole_level(position, whole + 1u), level - f32(whole));
}

// Small bright parts of the environment, which are looked at one by one: the twin of `environment/lamps`.

fn lamp_count() -> u32 {
    return frame.maps[3].w & 0xffffu;
}

struct Lamp {
    towards: vec3f,
    brightness: f32,
    light: vec3f,
}

fn lamp_number(index: u32) -> vec4f {
    let columns = textureDimensions(environment_maps).x;
    return textureLoad(environment_maps, vec2u(index % columns, frame.maps[4].w + index / columns), 0);
}

fn lamp_at(index: u32) -> Lamp {
    let first = lamp_number(2u * index);
    return Lamp(first.xyz, first.w, lamp_number(2u * index + 1u).xyz);
}

// The share of lamps' light that is looked at lamp by lamp, where cones of a lobe lie so densely, a solid angle: many
// cones find lamps themselves, few may not.
fn share_by_lamps(density: f32) -> f32 {
    let ratio = density * LAMP_SOLID_ANGLE;
    return 1.0 / (1.0 + ratio * ratio);
}

// `environment_within` of which lamps have a share, between 0 and 1.
fn environment_beside_lamps(direction: vec3f, across: f32, share_of_lamps: f32) -> vec3f {
    let all = environment_within(direction, across);
    if lamp_count() == 0u {
        return all;
    }
    let finest = frame.maps[3].w >> 16u;
    let level = max(level_within(across), f32(finest));
    let whole = u32(level);
    let position = environment_position(direction);
    var rest = array<vec3f, 2>(vec3f(0.0), vec3f(0.0));
    for (var coarser = 0u; coarser < 2u; coarser++) {
        let place = frame.reductions[min(whole + coarser, frame.maps[0].w) - 1u];
        rest[coarser] = environment_place_at(vec4u(place.xy, place.w, 0u), position);
    }
    let without = mix(rest[0], rest[1], level - f32(whole));
    return without + max(all - without, vec3f(0.0)) * share_of_lamps;
}

// The background over a cone.
fn background_over(direction: vec3f, dx: vec3f, dy: vec3f) -> vec3f {
    if !HAS_ENVIRONMENT {
        return vec3f(0.0);
    }
    return environment_over(direction, dx, dy);
}

fn background(direction: vec3f) -> vec3f {
    if !HAS_ENVIRONMENT {
        return vec3f(0.0);
    }
    return environment_at(environment_position(direction));
}
