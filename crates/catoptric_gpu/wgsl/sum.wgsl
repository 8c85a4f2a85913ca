// Adds the colours of a part of a picture's samples to those of the parts before.

override SHARE: f32 = 1.0;
// There are parts before.
override GOES_ON: bool = true;

@group(0) @binding(0) var part: texture_2d<f32>;
@group(0) @binding(1) var before: texture_2d<f32>;
@group(0) @binding(2) var sum: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn add(@builtin(global_invocation_id) invocation: vec3u) {
    let pixel = invocation.xy;
    if any(pixel >= textureDimensions(part)) {
        return;
    }
    var color = textureLoad(part, pixel, 0) * SHARE;
    if GOES_ON {
        color += textureLoad(before, pixel, 0);
    }
    textureStore(sum, pixel, color);
}
