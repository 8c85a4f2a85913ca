// The tables of grids as passes write them.

//#include "rough/grids.wgsl"

// For each cell the rough mirror's triangle that its ray meets, and 1.
@group(2) @binding(0) var<storage, read_write> rough_met: array<u32>;
// For each cell the things that are near in its row: see `rough/cells.wgsl`.
@group(2) @binding(1) var<storage, read_write> rough_near: array<u32>;
@group(2) @binding(2) var<storage, read_write> rough_passages: array<vec4f>;
@group(2) @binding(3) var<storage, read_write> rough_light: array<vec4f>;
// The radiance that sharp rays show, and 1; 0 where there are none.
@group(2) @binding(4) var<storage, read_write> rough_sharp: array<vec4f>;
@group(2) @binding(6) var<storage, read_write> rough_lobes: array<vec4f>;
// Means of what sharp rays show, times the share of cells that show rough mirrors, and that share.
@group(2) @binding(7) var<storage, read_write> rough_reductions: array<vec4f>;

// A ray that leaves a mirror through a cell, how its neighbours in the grid differ, and how far it goes. In the plane
// across the ray, at a distance along it, the ray of the next cell of the row is away by the first pair of `start` plus
// the distance times that of `growth`; the second pairs are those of the next row. The twin of `draw/rough/passage`.
struct Passage {
    position: vec3f,
    direction: vec3f,
    start: vec4f,
    growth: vec4f,
    distance: f32,
    // The mirror that it leaves, and 1; 0: there is none.
    object: u32,
}

fn passage_of(index: u32) -> Passage {
    let first = rough_passages[4u * index];
    let second = rough_passages[4u * index + 1u];
    return Passage(
        first.xyz,
        second.xyz,
        rough_passages[4u * index + 2u],
        rough_passages[4u * index + 3u],
        first.w,
        bitcast<u32>(second.w),
    );
}

fn set_passage(index: u32, passage: Passage) {
    rough_passages[4u * index] = vec4f(passage.position, passage.distance);
    rough_passages[4u * index + 1u] = vec4f(passage.direction, bitcast<f32>(passage.object));
    rough_passages[4u * index + 2u] = passage.start;
    rough_passages[4u * index + 3u] = passage.growth;
}

// The steps to neighbours in the plane across the ray at a distance.
fn steps_at(passage: Passage, distance: f32) -> vec4f {
    return passage.start + passage.growth * distance;
}

// The solid angle, seen from where the ray starts, that a cell covers at a distance.
fn cell_extent(passage: Passage, distance: f32) -> f32 {
    let steps = steps_at(passage, distance);
    return max(abs(steps.x * steps.w - steps.y * steps.z) / (distance * distance), 1e-18);
}

fn set_light(index: u32, light: RoughLight) {
    rough_light[2u * index] = vec4f(light.radiance, light.weight);
    rough_light[2u * index + 1u] = vec4f(light.share, light.distance, light.width_px, bitcast<f32>(light.object));
}

// The number of a thread's cell in the grid that a pass works on; NONE beyond it.
fn own_cell(cell: vec2u) -> u32 {
    if any(cell >= grids.levels[grids.level].xy) {
        return NONE;
    }
    return cell_index(grids.level, cell);
}
