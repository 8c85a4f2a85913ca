// The views in flat mirrors: the scene mirrored, drawn by hardware where its mirror is seen.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "tiles/cells.wgsl"
//#include "confined.wgsl"

// The scene in a mirror.
struct MirrorPath {
    clip_from_scene: mat4x4f,
    // The mirror's plane: the product with (p, 1) is the distance of a point p in front of it.
    plane: vec4f,
    // The mirror, from 1; the number of the path in which it is seen, and this path's own.
    mirror: u32,
    parent: u32,
    number: u32,
    unused: u32,
}

// Triangles without holes first: at equal depth they are seen.
@group(1) @binding(0) var<storage, read> draw_order: array<u32>;
@group(2) @binding(0) var<uniform> path: MirrorPath;
// The mirror of every triangle, from 1; four a texel.
@group(2) @binding(1) var mirror_table: texture_2d<u32>;

fn mirror_of(triangle: u32) -> u32 {
    return textureLoad(mirror_table, row_of(triangle / 4u), 0)[triangle % 4u];
}

@vertex
fn confined_corner(@builtin(vertex_index) index: u32) -> Corner {
    let hit = draw_order[index / 3u];
    let triangle = triangle_of(hit);
    let place = index % 3u;
    let position = vec4f(vertex_of(corners_of(triangle)[place]).position, 1.0);
    var result: Corner;
    result.position = shifted(path.clip_from_scene * position);
    // A mirror never shows itself.
    if mirror_of(triangle) == path.mirror {
        result.position = vec4f(0.0, 0.0, -1.0, 1.0);
    }
    result.hit = hit;
    result.at = vec2f(f32(place == 1u), f32(place == 2u));
    result.height = dot(path.plane, position);
    result.blocks = 0u;
    return result;
}

// True where the path's mirror is seen.
fn is_seen(triangle: u32) -> bool {
    return mirror_of(triangle) == path.mirror;
}
