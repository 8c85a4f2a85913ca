// The light from infinity and of other surfaces that arrives at places of surfaces: the twin of `scene/shading/sky/shares`.

// Behind the triangles lie nodes, which are triangles, whole or divided into four: the places of their corners' light,
// and of the first part, or 0. That light lies behind them.

struct ArrivingLight {
    // The share of the light from infinity.
    share: vec3f,
    // The irradiance by surfaces that emit light or scatter it.
    emitted: vec3f,
}

// The light at a corner, on the side of the normals or, for -1, on the other.
fn arriving_at(place: u32, side: f32) -> ArrivingLight {
    let first = bitcast<vec4f>(textureLoad(triangle_table, row_of(place), 0));
    let second = bitcast<vec4f>(textureLoad(triangle_table, row_of(place + 1u), 0));
    let third = bitcast<vec4f>(textureLoad(triangle_table, row_of(place + 2u), 0));
    if side < 0.0 {
        return ArrivingLight(vec3f(second.zw, third.x), third.yzw);
    }
    return ArrivingLight(first.xyz, vec3f(first.w, second.xy));
}

// The light at a point.
fn light_onto(point: SurfacePoint, side: f32) -> ArrivingLight {
    if !HAS_SKY || point.triangle == NONE {
        return ArrivingLight(vec3f(1.0), vec3f(0.0));
    }
    // A pixel's middle may lie beside the triangle that the pixel shows.
    var at = max(point.barycentrics, vec2f(0.0));
    at /= max(at.x + at.y, 1.0);
    var node = textureLoad(triangle_table, row_of(frame.maps[2].w + point.triangle), 0);
    while node.w != 0u {
        let first = 1.0 - at.x - at.y;
        var part = 3u;
        if first >= 0.5 {
            part = 0u;
            at *= 2.0;
        } else if at.x >= 0.5 {
            part = 1u;
            at = vec2f(2.0 * at.x - 1.0, 2.0 * at.y);
        } else if at.y >= 0.5 {
            part = 2u;
            at = vec2f(2.0 * at.x, 2.0 * at.y - 1.0);
        } else {
            at = 1.0 - 2.0 * at;
        }
        node = textureLoad(triangle_table, row_of(node.w + part), 0);
    }
    let a = arriving_at(node.x, side);
    let b = arriving_at(node.y, side);
    let c = arriving_at(node.z, side);
    return ArrivingLight(
        a.share + (b.share - a.share) * at.x + (c.share - a.share) * at.y,
        a.emitted + (b.emitted - a.emitted) * at.x + (c.emitted - a.emitted) * at.y,
    );
}
