// Evaluates how points of surfaces look, for a test that compares it with the library's.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "scene/environment.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "scene/shade.wgsl"
//#include "light/trace.wgsl"

struct TwinPoint {
    position: vec3f,
    object: u32,
    geometric_normal: vec3f,
    normal_change2: f32,
    normal: vec3f,
    samples: u32,
    viewer: vec3f,
    alpha: f32,
    tangent: vec4f,
    uvs: vec4f,
    uvs_dx: vec4f,
    uvs_dy: vec4f,
    // The change of a direction.
    change_x: vec3f,
    unused0: f32,
    change_y: vec3f,
    unused1: f32,
}

struct TwinLight {
    base: vec4f,
    own: vec3f,
    variance: f32,
    highlights: vec3f,
    unused0: f32,
    turned: vec3f,
    unused1: f32,
    background: vec3f,
    unused2: f32,
    over: vec3f,
    unused3: f32,
    glossy: vec3f,
    unused4: f32,
    irradiance: vec3f,
    unused5: f32,
}

@group(0) @binding(20) var<storage, read> inputs: array<TwinPoint>;
@group(0) @binding(21) var<storage, read_write> outputs: array<TwinLight>;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) invocation: vec3u) {
    let index = invocation.x;
    if index >= arrayLength(&inputs) {
        return;
    }
    let given = inputs[index];
    var point: SurfacePoint;
    point.object = given.object;
    point.triangle = NONE;
    point.position = given.position;
    point.geometric_normal = given.geometric_normal;
    point.normal = given.normal;
    point.normal_change2 = given.normal_change2;
    point.uvs = given.uvs;
    point.uvs_dx = given.uvs_dx;
    point.uvs_dy = given.uvs_dy;
    point.samples = given.samples;
    point.color = vec4f(1.0);
    point.tangent = given.tangent;
    let texels = texels_at(point);
    let object = given.object;
    let base = surface_of(object).base_color * texels.values[BASE];
    var tint = base.xyz;
    if surface_of(object).role == COATED {
        tint = vec3f(surface_of(object).coat * texels.values[COAT].x);
    }
    let own_base = select(base.xyz, surface_of(object).own_color, (surface_of(object).flags & OWN_COLOR) != 0u);
    let light = point_light(own_base, tint, point, texels, given.viewer, true, all_light());
    let turned = normal_of_map(point);
    var result: TwinLight;
    result.base = base;
    result.own = light.own;
    result.highlights = light.highlights;
    result.turned = turned.normal;
    result.variance = turned.variance;
    result.background = background(given.viewer);
    result.over = background_over(given.viewer, given.change_x, given.change_y);
    result.glossy = environment_glossy(given.viewer, given.alpha);
    result.irradiance = environment_irradiance(given.viewer);
    outputs[index] = result;
}
