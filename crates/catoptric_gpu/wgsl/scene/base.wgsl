// Base colours of surface points, and holes where their alpha is low.

// The place and the footprint of a point in a texture.
fn look_up(binding: Binding, point: SurfacePoint) -> LookUp {
    let is_second = binding.channel == 1u;
    let matrix = mat2x2f(binding.matrix.xy, binding.matrix.zw);
    var at: LookUp;
    at.uv = matrix * select(point.uvs.xy, point.uvs.zw, is_second) + binding.translation;
    at.dx = matrix * select(point.uvs_dx.xy, point.uvs_dx.zw, is_second);
    at.dy = matrix * select(point.uvs_dy.xy, point.uvs_dy.zw, is_second);
    at.samples = point.samples;
    return at;
}

fn sample_bound(binding: Binding, point: SurfacePoint) -> vec4f {
    if binding.texture == NONE {
        return vec4f(1.0);
    }
    return sample_texture(binding.texture, look_up(binding, point));
}

fn sample_binding(object: u32, index: u32, point: SurfacePoint) -> vec4f {
    return sample_bound(binding_of(object, index), point);
}

// All textures of a surface at a point; what is not bound is white.
struct Texels {
    values: array<vec4f, BINDINGS>,
}

fn texels_at(point: SurfacePoint) -> Texels {
    var result: Texels;
    // A loop, not one call a texture: compilers copy functions to each place that calls them.
    result.values = array<vec4f, BINDINGS>(
        vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0));
    for (var index = 0u; index < BINDINGS_USED; index++) {
        result.values[index] = sample_binding(point.object, index, point);
    }
    return result;
}

// True if a surface whose alpha is tested is there.
fn is_present(triangle: u32, at: Barycentrics) -> bool {
    let point = surface_point(triangle_at(triangle), at, 1u);
    let color = surface_of(point.object).base_color * point.color * sample_binding(point.object, BASE, point);
    return color.w >= surface_of(point.object).alpha_cutoff;
}
