// Evaluates functions that have twins, for a test that feeds both the same inputs.

//#include "scene/records.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"

struct TwinInput {
    direction: vec3f,
    eta: f32,
    geometric: vec3f,
    cosine: f32,
    shading: vec3f,
    alpha: f32,
    direction_change: vec3f,
    half_cosine2: f32,
    normal_change: vec3f,
    n_v: f32,
}

struct TwinOutput {
    reflected: vec3f,
    fresnel: f32,
    refracted: vec3f,
    lobe: f32,
    reflected_change: vec3f,
    widened: f32,
    refracted_change: vec3f,
    outside: f32,
}

@group(0) @binding(20) var<storage, read> inputs: array<TwinInput>;
@group(0) @binding(21) var<storage, read_write> outputs: array<TwinOutput>;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) invocation: vec3u) {
    let index = invocation.x;
    if index >= arrayLength(&inputs) {
        return;
    }
    let given = inputs[index];
    let at = facing(given.direction, given.geometric, given.shading);
    var result: TwinOutput;
    result.reflected = outgoing(REFLECT, at, given.direction, given.eta);
    result.refracted = outgoing(TRANSMIT, at, given.direction, given.eta);
    result.fresnel = fresnel_dielectric(given.cosine, given.eta);
    result.lobe = lobe(given.alpha, given.half_cosine2, 1.0 - given.half_cosine2, given.cosine, given.n_v);
    result.widened = widened_alpha(given.alpha, given.n_v);
    result.reflected_change =
        reflected_change(given.direction, given.direction_change, at.normal, given.normal_change);
    result.refracted_change =
        refracted_change(given.direction, given.direction_change, at.normal, given.normal_change, given.eta);
    result.outside = f32(at.outside);
    outputs[index] = result;
}
