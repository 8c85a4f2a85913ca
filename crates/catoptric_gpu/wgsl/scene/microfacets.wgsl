// Reflection by microscopic facets: the twin of `scene/shading/microfacets`.

const FRAC_1_PI = 0.31830988618;
const TAU = 6.28318530718;
const LEAST_ROUGHNESS = 0.03;
const LEAST_COSINE = 1e-4;
const TABLE_CELLS = 32.0;

// Row: roughness; column: cosine to the viewer. The share at normal incidence, at grazing angles, tilt and spread.
@group(0) @binding(8) var reflectance_table: texture_2d<f32>;

fn lobe(alpha: f32, half_cosine2: f32, half_sine2: f32, n_l: f32, n_v: f32) -> f32 {
    let alpha2 = alpha * alpha;
    let spread = max(half_sine2 + alpha2 * half_cosine2, 1e-9);
    let masking = n_l * sqrt(n_v * n_v * (1.0 - alpha2) + alpha2) + n_v * sqrt(n_l * n_l * (1.0 - alpha2) + alpha2);
    return (0.5 * FRAC_1_PI) * alpha2 / (spread * spread * max(masking, 1e-12));
}

fn grazing_share(cosine: f32) -> f32 {
    let m = max(1.0 - cosine, 0.0);
    let m2 = m * m;
    return m2 * m2 * m;
}

fn widened_alpha(alpha: f32, variance: f32) -> f32 {
    return min(sqrt(alpha * alpha + variance), 1.0);
}

fn variance_over_pixel(change2: f32) -> f32 {
    return min(change2 * (0.5 * FRAC_1_PI), 0.18);
}

fn variance_of_mean(length: f32) -> f32 {
    return 2.0 * max(1.0 - length - 4e-5, 0.0) / max(length, 0.1);
}

// A point of the unit disc for two numbers between 0 and 1; all of its parts are equally likely.
fn disc_point(number: vec2f) -> vec2f {
    let angle = TAU * number.y;
    return sqrt(number.x) * vec2f(cos(angle), sin(angle));
}

// The normal of the facet that belongs to a point of the unit disc, of those that a viewer sees, in a frame whose z axis
// is the surface's normal (Heitz 2018).
fn visible_facet(alpha: f32, towards_viewer: vec3f, disc: vec2f) -> vec3f {
    let view = normalize_or(vec3f(alpha * towards_viewer.xy, towards_viewer.z), vec3f(0.0, 0.0, 1.0));
    let length2 = dot(view.xy, view.xy);
    var across = vec3f(1.0, 0.0, 0.0);
    if length2 > 1e-14 {
        across = vec3f(-view.y, view.x, 0.0) * inverseSqrt(length2);
    }
    let along = cross(view, across);
    let share = 0.5 * (1.0 + view.z);
    let y = (1.0 - share) * sqrt(max(1.0 - disc.x * disc.x, 0.0)) + share * disc.y;
    let facet = across * disc.x + along * y + view * sqrt(max(1.0 - disc.x * disc.x - y * y, 0.0));
    return normalize(vec3f(alpha * facet.xy, max(facet.z, 1e-6)));
}

// The share of light from a facet that a viewer sees which arrives at the facet, too.
fn unshadowed_share(alpha: f32, cosine: f32, n_v: f32) -> f32 {
    let n_l = max(cosine, 0.0);
    let alpha2 = alpha * alpha;
    let slope_l = sqrt(alpha2 + (1.0 - alpha2) * n_l * n_l);
    let slope_v = sqrt(alpha2 + (1.0 - alpha2) * n_v * n_v);
    return n_l * (n_v + slope_v) / max(n_v * slope_l + n_l * slope_v, 1e-12);
}

// The solid angle that the light of one of `count` facets stands for.
fn extent_of_sample(alpha: f32, n_h: f32, n_v: f32, count: f32) -> f32 {
    let spread = 1.0 - n_h * n_h * (1.0 - alpha * alpha);
    let density = alpha * alpha * FRAC_1_PI / (spread * spread) / (4.0 * n_v);
    return 1.0 / (count * max(density, 1e-9));
}

fn reflected_surroundings(roughness: f32, n_v: f32) -> vec4f {
    let at = clamp(vec2f(n_v, roughness) * TABLE_CELLS, vec2f(0.0), vec2f(TABLE_CELLS - 1e-3));
    let cell = vec2i(at);
    let share = at - vec2f(cell);
    let upper = mix(
        textureLoad(reflectance_table, cell, 0),
        textureLoad(reflectance_table, cell + vec2i(1, 0), 0),
        share.x,
    );
    let lower = mix(
        textureLoad(reflectance_table, cell + vec2i(0, 1), 0),
        textureLoad(reflectance_table, cell + vec2i(1, 1), 0),
        share.x,
    );
    return mix(upper, lower, share.y);
}
