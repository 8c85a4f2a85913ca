// Filtered look-ups in textures: the twin of `scene/shading/filter` and `scene/shading/texture`.

const MAX_ANISOTROPY = 8.0;

// The places of 1, 2, 4 and 8 samples in a pixel, in sixteenths from its corner.
var<private> places_of_samples: array<vec2f, 15> = array<vec2f, 15>(
    vec2f(8.0, 8.0),
    vec2f(12.0, 12.0), vec2f(4.0, 4.0),
    vec2f(6.0, 2.0), vec2f(14.0, 6.0), vec2f(2.0, 10.0), vec2f(10.0, 14.0),
    vec2f(9.0, 5.0), vec2f(7.0, 11.0), vec2f(13.0, 9.0), vec2f(5.0, 3.0),
    vec2f(3.0, 13.0), vec2f(1.0, 7.0), vec2f(11.0, 15.0), vec2f(15.0, 1.0),
);

// Texture coordinates and their change with the pixel's column and row; a look-up stands for so many samples.
struct LookUp {
    uv: vec2f,
    dx: vec2f,
    dy: vec2f,
    samples: u32,
}

struct Taps {
    probes: f32,
    step: vec2f,
    level: u32,
    blend: f32,
    half: f32,
}

fn taps(texture: u32, dx: vec2f, dy: vec2f, side: f32) -> Taps {
    let size = texture_of(texture).size;
    let last_level = texture_of(texture).last_level;
    let nearest_level = texture_of(texture).nearest_level;
    let x = dx * size;
    let y = dy * size;
    let x2 = dot(x, x);
    let y2 = dot(y, y);
    let across = x2 >= y2;
    var major2 = select(y2, x2, across);
    let minor2 = max(select(x2, y2, across), 1e-20);
    let minified = major2 > 1.0 && major2 < 1e38;
    let mipped = minified && last_level >= 0.0;
    major2 = select(1.0, major2, mipped);
    let ratio2 = min(min(major2 / minor2, MAX_ANISOTROPY * MAX_ANISOTROPY), major2);
    var probes = max(ceil(sqrt(ratio2)), 1.0);
    let inverse = 1.0 / probes;
    let last = select(0.0, last_level, mipped);
    let level = min(max(0.5 * log2(major2 * inverse * inverse), 0.0), last);
    let whole = floor(level + 0.5 * nearest_level);
    if side <= 0.5 && probes > 4.0 {
        probes = ceil(0.5 * probes);
    }
    var result: Taps;
    result.probes = probes;
    result.level = u32(whole);
    result.blend = (level - whole) * (1.0 - nearest_level);
    result.half = select(texture_of(texture).magnified_half, texture_of(texture).minified_half, minified);
    result.step = select(vec2f(0.0), select(dy, dx, across), mipped);
    return result;
}

// A coordinate brought into 0..1.
fn folded(coordinate: f32, wrap: f32) -> f32 {
    let scaled = coordinate * wrap;
    let fraction = scaled - floor(scaled);
    let mirrored = 1.0 - abs(1.0 - 2.0 * fraction);
    let periodic = select(mirrored, fraction, wrap == 1.0);
    return clamp(select(periodic, coordinate, wrap == 0.0), 0.0, 1.0);
}

fn texel(index: u32) -> vec4f {
    return vec4f(textureLoad(texels, row_of(index), 0)) * (1.0 / 65535.0);
}

// The blend of four texels of a level; each row is followed by its last texel's right neighbour.
fn corners(level: Level, at: vec2f, wrap: vec2f, half: f32) -> vec4f {
    let blended = select(0.0, 1.0, half > 0.0);
    let position = at * level.size - half;
    let last = level.size - 1.0;
    let first = floor(position);
    let repeats = wrap == vec2f(1.0);
    let below = select(vec2f(0.0), last, repeats);
    let above = last - below;
    let inside = select(select(first, below, first < vec2f(0.0)), above, first > last);
    let second = select(first.y + 1.0, above.y, first.y + 1.0 > last.y);
    let edge = first.x < 0.0 && !repeats.x;
    let share = vec2f(select(position.x - first.x, 0.0, edge), position.y - first.y) * blended;
    let start = level.first + u32(inside.x);
    let upper = u32(inside.y) * level.stride + start;
    let lower = u32(max(second, 0.0)) * level.stride + start;
    let left = mix(texel(upper), texel(lower), share.y);
    let right = mix(texel(upper + 1u), texel(lower + 1u), share.y);
    return mix(left, right, share.x);
}

// The filtered value of a texture; white where the place is not finite.
fn sample_texture(texture: u32, at: LookUp) -> vec4f {
    if !(abs(at.uv.x) < 1e30 && abs(at.uv.y) < 1e30) {
        return vec4f(1.0);
    }
    let size = texture_of(texture).size;
    let wrap = texture_of(texture).wrap;
    let x = at.dx * size;
    let y = at.dy * size;
    let extent2 = max(dot(x, x), dot(y, y));
    let ramp = select(0.0, 0.3, texture_of(texture).magnified_half > 0.0);
    var places_log2 = u32(at.samples > 1u) + u32(at.samples > 2u) + u32(at.samples > 4u);
    places_log2 = select(places_log2, 2u, at.samples > 8u);
    places_log2 = select(places_log2, min(places_log2, 2u), extent2 < 1.0);
    places_log2 = select(places_log2, 0u, extent2 < ramp);
    let places = 1u << places_log2;
    let side = sqrt(1.0 / f32(places));
    let tap = taps(texture, at.dx * side, at.dy * side, side);
    let last_level = u32(max(texture_of(texture).last_level, 0.0));
    let finer = level_of(texture, min(tap.level, last_level));
    let coarser = level_of(texture, min(tap.level + 1u, last_level));
    var sum = vec4f(0.0);
    for (var place = 0u; place < places; place++) {
        let offset = places_of_samples[places - 1u + place] / 16.0 - 0.5;
        let uv = at.uv + at.dx * offset.x + at.dy * offset.y;
        for (var probe = 0.0; probe < tap.probes; probe += 1.0) {
            let along = uv + tap.step * ((probe + 0.5) / tap.probes - 0.5);
            let wrapped = vec2f(folded(along.x, wrap.x), folded(along.y, wrap.y));
            for (var step = 0u; step < select(1u, 2u, tap.blend > 0.0); step++) {
                let share = select(1.0 - tap.blend, tap.blend, step == 1u);
                var level = finer;
                if step == 1u {
                    level = coarser;
                }
                sum += share * corners(level, wrapped, wrap, tap.half);
            }
        }
    }
    return sum / (tap.probes * f32(places));
}
