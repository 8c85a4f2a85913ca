// Draws the colours of a picture, as they are displayed, to a target of the caller's. As `tone.rs` on the processor.

struct Display {
    // Two to the power of the exposure in stops.
    scale: f32,
    curve: u32,
}

const NEUTRAL: u32 = 1u;
const AGX: u32 = 2u;
const ACES: u32 = 3u;

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var<uniform> display: Display;

@vertex
fn whole_target(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // A triangle that covers everything.
    let corner = vec2f(f32(index / 2u), f32(index % 2u));
    return vec4f(corner * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn color(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let color = textureLoad(picture, vec2u(position.xy), 0);
    let exposed = color.rgb * display.scale;
    switch display.curve {
        case NEUTRAL: {
            return vec4f(neutral(exposed), color.a);
        }
        case AGX: {
            return vec4f(agx(exposed), color.a);
        }
        case ACES: {
            return vec4f(aces(exposed), color.a);
        }
        default: {
            return vec4f(exposed, color.a);
        }
    }
}

// Khronos PBR Neutral (Khronos 2024).
fn neutral(radiance: vec3f) -> vec3f {
    let least = min(radiance.r, min(radiance.g, radiance.b));
    let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
    let color = radiance - offset;
    let peak = max(color.r, max(color.g, color.b));
    let start = 0.8 - 0.04;
    if peak < start {
        return color;
    }
    let rest = 1.0 - start;
    let new_peak = 1.0 - rest * rest / (peak + rest - start);
    let grey = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3f(new_peak), grey);
}

// AgX (Sobotka), in the polynomial form of Wrensch 2023.
fn agx(radiance: vec3f) -> vec3f {
    let inset = mat3x3f(
        0.84247906, 0.042328242, 0.042375655,
        0.0784336, 0.87846864, 0.0784336,
        0.079223745, 0.07916613, 0.879143,
    );
    let outset = mat3x3f(
        1.196879, -0.05289685, -0.05297164,
        -0.09802088, 1.151903, -0.09804345,
        -0.09902974, -0.09896118, 1.1510737,
    );
    let least = -12.47393;
    let stops = clamp(log2(max(inset * radiance, vec3f(1e-10))), vec3f(least), vec3f(4.026069));
    let x = (stops - least) / (4.026069 - least);
    let contrast = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232);
    return pow(clamp(outset * max(contrast, vec3f(0.0)), vec3f(0.0), vec3f(1.0)), vec3f(2.2));
}

// The Academy's reference transforms, fitted by Hill 2016.
fn aces(radiance: vec3f) -> vec3f {
    let input = mat3x3f(
        0.59719, 0.076, 0.0284,
        0.35458, 0.90834, 0.13383,
        0.04823, 0.01566, 0.83777,
    );
    let output = mat3x3f(
        1.60475, -0.10208, -0.00327,
        -0.53108, 1.10813, -0.07276,
        -0.07367, -0.00605, 1.07602,
    );
    let v = input * radiance;
    let curve = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.432951) + 0.238081);
    return clamp(output * curve, vec3f(0.0), vec3f(1.0));
}
