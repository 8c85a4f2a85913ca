// The shading of pixels that show mirrors and glass, in the tiles that have some. What they show, and whether four samples
// are shaded at once, the shader says that includes this: `followed_radiance` and `is_shaded_once`.

@compute @workgroup_size(8, 8)
fn follow_one_sample(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let in_band = followed_pixel(group, local);
    let pixel = in_band + vec2u(0u, frame.first_row);
    let cell = in_band / 2u;
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let ray = (in_band.x & 1u) | ((in_band.y & 1u) << 1u);
    let hit = hits[hit_index(cell, 0u, 0u)][ray];
    if is_followed(hit) {
        let place = vec2f(pixel) + frame.sample_place;
        let color = followed_radiance(place, cell, ray, triangle_of(hit), frame.sample_side, 1u);
        textureStore(colors, pixel, vec4f(color, 1.0));
    }
}

@compute @workgroup_size(8, 8)
fn follow_four_samples(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let cell = followed_pixel(group, local);
    let pixel = cell + vec2u(0u, frame.first_row);
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let ids = hits[hit_index(cell, 0u, 0u)];
    if !is_followed(ids.x | ids.y | ids.z | ids.w) {
        return;
    }
    let is_one = is_shaded_once(ids, cell, pixel);
    let count = select(4u, 1u, is_one);
    let side = select(0.5, 1.0, is_one);
    var sum = vec3f(0.0);
    for (var ray = 0u; ray < count; ray++) {
        let place = vec2f(pixel) + select(four_samples[ray], vec2f(0.5), is_one);
        sum += followed_radiance(place, cell, ray, triangle_of(ids[ray]), side, select(1u, 4u, is_one));
    }
    textureStore(colors, pixel, vec4f(sum / f32(count), 1.0));
}
