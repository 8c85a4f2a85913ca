// Geometry that is drawn only where a picture shows something: hits one event further. The shader that includes this
// says which geometry: its `path` has a number and that of the path before (0: what is seen directly), its vertex stage
// is `confined_corner`, and `is_seen` is true where it is shown.

// The picture of one event before: hits in two halves, and the number of the path.
@group(2) @binding(2) var before: texture_2d<u32>;
@group(2) @binding(3) var before_samples: texture_multisampled_2d<u32>;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) hit: u32,
    @location(1) @interpolate(perspective, sample) at: vec2f,
    // Parts below 0 are cut off.
    @location(2) @interpolate(perspective, sample) height: f32,
    // The number of the choice of blocks where no geometry goes on from there, or 0.
    @location(3) @interpolate(flat, either) blocks: u32,
}

fn confined(corner: Corner, shown: vec4u) -> vec4u {
    let at = Barycentrics(corner.at, dpdx(corner.at), dpdy(corner.at));
    let triangle = triangle_of(shown.x | (shown.y << 16u));
    let is_there = corner.height > 0.0 && shown.z == path.parent && triangle != NONE && is_seen(triangle);
    if !is_there || (HAS_HOLES && corner.hit != 0u && !is_present(triangle_of(corner.hit), at)) {
        discard;
    }
    return vec4u(corner.hit & 0xffffu, corner.hit >> 16u, path.number, corner.blocks);
}

@fragment
fn confined_one_sample(corner: Corner) -> @location(0) vec4u {
    return confined(corner, textureLoad(before, vec2u(corner.position.xy), 0));
}

@fragment
fn confined_four_samples(corner: Corner, @builtin(sample_index) sample: u32) -> @location(0) vec4u {
    return confined(corner, textureLoad(before_samples, vec2u(corner.position.xy), sample));
}
