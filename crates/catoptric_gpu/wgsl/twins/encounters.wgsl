// Evaluates what rays meet, for a test that compares it with the library's.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "light/trace.wgsl"

struct TwinRay {
    origin: vec3f,
    unused0: f32,
    direction: vec3f,
    unused1: f32,
    origin_dx: vec3f,
    unused2: f32,
    origin_dy: vec3f,
    unused3: f32,
    direction_dx: vec3f,
    unused4: f32,
    direction_dy: vec3f,
    unused5: f32,
}

struct TwinEncounter {
    position: vec3f,
    triangle: u32,
    geometric_normal: vec3f,
    distance: f32,
    normal: vec3f,
    unused0: f32,
    position_dx: vec3f,
    unused1: f32,
    position_dy: vec3f,
    unused2: f32,
    normal_dx: vec3f,
    unused3: f32,
    normal_dy: vec3f,
    unused4: f32,
}

@group(0) @binding(20) var<storage, read> inputs: array<TwinRay>;
@group(0) @binding(21) var<storage, read_write> outputs: array<TwinEncounter>;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) invocation: vec3u) {
    let index = invocation.x;
    if index >= arrayLength(&inputs) {
        return;
    }
    let given = inputs[index];
    let ray = Ray(given.origin, given.direction);
    let change = RayDifferential(given.origin_dx, given.origin_dy, given.direction_dx, given.direction_dy);
    let meeting = nearest(frame.root, ray, 0.0, FAR, NO_RULE, 0u);
    var result: TwinEncounter;
    result.triangle = meeting.triangle;
    result.distance = meeting.distance;
    if meeting.triangle != NONE {
        let met = drawn_encounter(meeting.triangle, ray, change, 1u, 0u);
        result.position = met.point.position;
        result.geometric_normal = met.point.geometric_normal;
        result.normal = met.point.normal;
        result.position_dx = met.position_dx;
        result.position_dy = met.position_dy;
        result.normal_dx = met.normal_dx;
        result.normal_dy = met.normal_dy;
    }
    outputs[index] = result;
}
