// Reflection by microscopic facets: the twin of `scene/shading/microfacets`.

const FRAC_1_PI = 0.31830988618;
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
