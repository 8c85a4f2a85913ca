// Draws the colours of a picture to a target of the caller's.

@group(0) @binding(0) var picture: texture_2d<f32>;

@vertex
fn whole_target(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // A triangle that covers everything.
    let corner = vec2f(f32(index / 2u), f32(index % 2u));
    return vec4f(corner * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn color(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureLoad(picture, vec2u(position.xy), 0);
}
