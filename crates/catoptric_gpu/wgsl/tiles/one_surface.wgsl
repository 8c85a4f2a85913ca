// Four samples that show one surface are shaded at once: see `tiles/followed.wgsl`.

fn is_shaded_once(ids: vec4u, cell: vec2u, pixel: vec2u) -> bool {
    return is_one_surface(ids, vec2f(pixel));
}
