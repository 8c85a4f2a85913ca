// Grids of cells over a picture and a margin around it, for what rough mirrors would show if they were smooth and for
// their light. Each grid has cells of half the side of the one before. The twin of `draw/rough/grid`. The shader that
// includes this has the light of cells (`rough_light`).

//#include "light/paths/lobes.wgsl"

const GRIDS = 3u;
const MOST_REDUCTIONS = 16u;

// Lobes that cover less than the first number of the finest cells across are what the sharp ray shows, and from the
// second on blurred alone.
const SHARP_CELLS = vec2f(0.3, 1.4);
// Two numbers for each grid but the finest: lobes that cover more of its cells across than the second are blurred in
// it, and those that cover less than the first in a finer one.
const BLURRED_CELLS = array<vec2f, 2>(vec2f(3.0, 5.0), vec2f(1.75, 3.0));
// Distances beyond are none.
const NO_DISTANCE = 1e12;

struct Grids {
    // Width, height, the side of a cell in pixels, and the place of the first cell; the coarsest first.
    levels: array<vec4u, GRIDS>,
    // Width, height and first cell of means over ever more cells: over so many as the second grid's, the first one's,
    // and so on.
    reductions: array<vec4u, MOST_REDUCTIONS>,
    // The view's axis, and its near plane.
    forward: vec3f,
    near: f32,
    margin_px: f32,
    // Beyond, nothing moves in what a place sees.
    greatest_distance: f32,
    // The grid and the reduction that a pass works on.
    level: u32,
    reduction: u32,
    reduction_count: u32,
    unused0: u32,
    unused1: u32,
    unused2: u32,
}

@group(2) @binding(5) var<uniform> grids: Grids;

fn light_of_cell(index: u32) -> RoughLight {
    let first = rough_light[2u * index];
    let second = rough_light[2u * index + 1u];
    return RoughLight(first.xyz, first.w, second.x, second.y, second.z, bitcast<u32>(second.w));
}

// The same but for the mean.
fn shape_of_cell(index: u32) -> RoughLight {
    let second = rough_light[2u * index + 1u];
    return RoughLight(vec3f(0.0), 0.0, second.x, second.y, second.z, bitcast<u32>(second.w));
}

fn cell_index(level: u32, cell: vec2u) -> u32 {
    let grid = grids.levels[level];
    return grid.w + cell.y * grid.x + cell.x;
}

// A position of the picture, in cells.
fn in_cells(level: u32, position: vec2f) -> vec2f {
    return (position + grids.margin_px) / f32(grids.levels[level].z);
}

// The middle of a cell in the picture.
fn middle_of_cell(level: u32, cell: vec2u) -> vec2f {
    return (vec2f(cell) + 0.5) * f32(grids.levels[level].z) - grids.margin_px;
}

// The four cells of a grid around a position in cells, and their weights for what is in between; at its edges some are
// the same.
struct CellsAround {
    cells: array<vec2u, 4>,
    weights: vec4f,
}

fn cells_around(position: vec2f, size: vec2u) -> CellsAround {
    let at = position - 0.5;
    let low = floor(at);
    let share = at - low;
    let rest = 1.0 - share;
    let last = vec2i(size) - 1;
    let first = vec2u(clamp(vec2i(low), vec2i(0), last));
    let second = vec2u(clamp(vec2i(low) + 1, vec2i(0), last));
    return CellsAround(
        array<vec2u, 4>(first, vec2u(second.x, first.y), vec2u(first.x, second.y), second),
        vec4f(rest.x * rest.y, share.x * rest.y, rest.x * share.y, share.x * share.y),
    );
}

fn mixed_light(a: RoughLight, of_a: f32, b: RoughLight, of_b: f32) -> RoughLight {
    return RoughLight(
        a.radiance * of_a + b.radiance * of_b,
        a.weight * of_a + b.weight * of_b,
        a.share * of_a + b.share * of_b,
        min(a.distance, NO_DISTANCE) * of_a + min(b.distance, NO_DISTANCE) * of_b,
        a.width_px * of_a + b.width_px * of_b,
        max(a.object, b.object),
    );
}

// The light at a position of the picture, between the cells around it that show the same object.
fn rough_light_in(level: u32, object: u32, position: vec2f) -> RoughLight {
    let around = cells_around(in_cells(level, position), grids.levels[level].xy);
    var sum: RoughLight;
    var weights = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let light = light_of_cell(cell_index(level, around.cells[corner]));
        if light.object == object + 1u {
            // A rim's only cell counts even if the position is on the far side of it.
            let weight = max(around.weights[corner], 1e-4);
            sum = mixed_light(sum, 1.0, light, weight);
            weights += weight;
        }
    }
    var none: RoughLight;
    if weights == 0.0 {
        return none;
    }
    return mixed_light(sum, 1.0 / weights, none, 0.0);
}

// How much of the light at a position is that of the next finer grid, by what this one knows of it.
fn finer_share(level: u32, light: RoughLight) -> f32 {
    var cells = BLURRED_CELLS;
    let between = cells[level];
    return clamp((between.y - light.width_px / f32(grids.levels[level].z)) / (between.y - between.x), 0.0, 1.0);
}

// The light at a position of the picture where an object is seen; of object 0 where the grids do not know it.
fn rough_light_at(object: u32, position: vec2f) -> RoughLight {
    var light: RoughLight;
    for (var level = 0u; level < GRIDS; level++) {
        var share = 1.0;
        if light.object != 0u {
            share = finer_share(level - 1u, light);
            if share <= 0.0 {
                break;
            }
        }
        let found = rough_light_in(level, object, position);
        if found.object != 0u && light.object != 0u {
            light = mixed_light(light, 1.0 - share, found, share);
        } else if found.object != 0u {
            light = found;
        }
    }
    // Rays of their own are for the finest cells.
    light.object = select(light.object, 0u, light.width_px == 0.0 && light.weight == 0.0);
    return light;
}
