// Means over the lobes of rough places, of what grids of sharp rays show: the twin of `draw/rough/blur`, `lobe` and
// `pyramid`.

//#include "scene/records.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "light/paths/lobes.wgsl"
//#include "rough/tables.wgsl"

// Directions of a lobe, and of one that covers less than so many of the finest cells across.
const DIRECTIONS = 32u;
const FEW_DIRECTIONS = 16u;
const FEW_CELLS = 2.0;
// Steps to the ray that passes where a direction goes: as the changes of the place's own ray say, and as those of the
// rays that are found on the way say. For lobes that are narrow, where changes are even, and for others.
const NEAR_STEPS = vec2u(2u, 0u);
const WIDE_STEPS = vec2u(1u, 3u);
// Lobes are narrow that cover less than so many of the finest cells across, and less than so many radians.
const NEAR_CELLS = 8.0;
const NEAR_WIDTH = 0.15;

// The first reduction: what the second grid knows, or else the first one; where all four of the finest cells show rough
// mirrors, their mean. The second one: the first grid or means of the first reduction. Others are means of four.
@compute @workgroup_size(8, 8)
fn reduce(@builtin(global_invocation_id) invocation: vec3u) {
    let place = grids.reductions[grids.reduction];
    let cell = invocation.xy;
    if any(cell >= place.xy) {
        return;
    }
    let level = GRIDS - 2u - min(grids.reduction, GRIDS - 2u);
    let of_grid = grids.reduction < GRIDS - 1u;
    var value = vec4f(0.0);
    if of_grid {
        value = rough_sharp[cell_index(level, cell)];
    }
    if grids.reduction == 0u {
        var is_known = false;
        for (var corner = 0u; corner < 4u; corner++) {
            let other = (cell / 2u) * 2u + vec2u(corner & 1u, corner >> 1u);
            is_known = is_known || rough_sharp[cell_index(level, other)].w != 0.0;
        }
        if !is_known {
            value = rough_sharp[cell_index(level - 1u, cell / 2u)];
        }
    }
    var sum = vec4f(0.0);
    for (var corner = 0u; corner < 4u; corner++) {
        let finer = cell * 2u + vec2u(corner & 1u, corner >> 1u);
        if grids.reduction == 0u {
            sum += rough_sharp[cell_index(GRIDS - 1u, finer)];
        } else {
            let below = grids.reductions[grids.reduction - 1u];
            if all(finer < below.xy) {
                sum += rough_reductions[below.z + finer.y * below.x + finer.x];
            }
        }
    }
    if !of_grid || sum.w == 4.0 {
        value = sum * 0.25;
    }
    rough_reductions[place.z + cell.y * place.x + cell.x] = value;
}

// The sum over the cells around a position, in cells of the finest level: radiance times the share that shows rough
// mirrors, and that share. Level 0 is the finest.
fn pyramid_at(position: vec2f, level: i32) -> vec4f {
    var sum = vec4f(0.0);
    if level <= 0 {
        let around = cells_around(position, grids.levels[GRIDS - 1u].xy);
        for (var corner = 0u; corner < 4u; corner++) {
            sum += rough_sharp[cell_index(GRIDS - 1u, around.cells[corner])] * around.weights[corner];
        }
        if sum.w > 1e-3 {
            return sum;
        }
    }
    let reduction = clamp(level, 1, i32(grids.reduction_count)) - 1;
    let place = grids.reductions[reduction];
    let around = cells_around(position * exp2(-f32(reduction + 1)), place.xy);
    sum = vec4f(0.0);
    for (var corner = 0u; corner < 4u; corner++) {
        let cell = around.cells[corner];
        sum += rough_reductions[place.z + cell.y * place.x + cell.x] * around.weights[corner];
    }
    return sum;
}

// The number of the cell at a position, in cells, if it shows an object; or else NONE.
fn place_at(position: vec2f, object: u32) -> u32 {
    let cell = vec2i(floor(position));
    let size = vec2i(grids.levels[grids.level].xy);
    if any(cell < vec2i(0)) || any(cell >= size) {
        return NONE;
    }
    let index = cell_index(grids.level, vec2u(cell));
    return select(NONE, index, bitcast<u32>(rough_passages[4u * index + 1u].w) == object);
}

// The number of cells to the right and down, from the ray to the neighbour that passes through a point; zero if
// neighbours do not spread over the plane.
fn cells_to(passage: Passage, point: vec3f) -> vec2f {
    let axes = axes_across(passage.direction);
    let missing = point - passage.position;
    let steps = steps_at(passage, max(dot(missing, passage.direction), 0.0));
    let aside = vec2f(dot(missing, axes[0]), dot(missing, axes[1]));
    let determinant = steps.x * steps.w - steps.y * steps.z;
    let right2 = dot(steps.xy, steps.xy);
    let down2 = dot(steps.zw, steps.zw);
    if !(determinant * determinant > 1e-12 * right2 * down2) {
        return vec2f(0.0);
    }
    let cells = vec2f(steps.w * aside.x - steps.z * aside.y, steps.x * aside.y - steps.y * aside.x) / determinant;
    return select(vec2f(0.0), cells, all(abs(cells) < vec2f(1e6)));
}

// Where in a grid the sharp ray is that passes where a direction from a place goes.
struct Found {
    // A position in cells.
    cell: vec2f,
    // How far away what it shows is from the place.
    distance: f32,
    follows: bool,
    // The cell where it was found, or NONE if it was not followed there.
    place: u32,
}

// The way, no longer than the longest: over more of the grid, rays hardly differ, and do not say where to go.
fn limited(way: vec2f) -> vec2f {
    let longest = 0.25 * f32(grids.levels[grids.level].x);
    let length2 = dot(way, way);
    return way * select(1.0, longest * inverseSqrt(max(length2, 1e-30)), length2 > longest * longest);
}

// Moved some way from a cell if the same mirror is there; else as far as it is seen on the way, and no further.
fn gone(found: Found, object: u32, start: vec2f, way: vec2f) -> Found {
    var next = found;
    next.place = NONE;
    if !found.follows {
        return next;
    }
    let place = place_at(start + way, object);
    if place != NONE {
        next.cell = start + way;
        next.place = place;
        return next;
    }
    if place_at(start + way * 0.5, object) != NONE {
        next.cell = start + way * 0.5;
    }
    next.follows = false;
    return next;
}

// Looks for the ray that passes where a direction from a place goes, with so many steps of both kinds.
fn find(own: Passage, middle: vec2f, direction: vec3f, steps: vec2u) -> Found {
    var found = Found(middle, own.distance, true, NONE);
    for (var step = 0u; step < steps.x; step++) {
        let goal = own.position + direction * found.distance;
        found = gone(found, own.object, middle, limited(cells_to(own, goal)));
        if found.place != NONE {
            let shown = passage_of(found.place);
            found.distance = distance(shown.position + shown.direction * shown.distance, own.position);
        }
    }
    if steps.y == 0u {
        return found;
    }
    var passage = own;
    let start = place_at(found.cell, own.object);
    if start != NONE {
        passage = passage_of(start);
    }
    for (var step = 0u; step < steps.y; step++) {
        let goal = own.position + direction * found.distance;
        found = gone(found, own.object, floor(found.cell) + 0.5, limited(cells_to(passage, goal)));
        if step + 1u < steps.y && found.follows {
            if found.place != NONE {
                passage = passage_of(found.place);
            }
            found.distance = distance(passage.position + passage.direction * passage.distance, own.position);
        }
    }
    return found;
}

// The mean over the lobe of a place, and whether anything of it is known.
fn lobe_mean(index: u32, cell: vec2u, few: bool, steps: vec2u) -> vec4f {
    let own = passage_of(index);
    let of_normal = rough_lobes[2u * index];
    let normal = of_normal.xyz;
    let alpha = of_normal.w;
    let geometric = rough_lobes[2u * index + 1u].xyz;
    let viewer = -eye_ray(middle_of_cell(grids.level, cell)).direction;
    let axes = axes_across(normal);
    let n_v = max(dot(viewer, normal), 1e-3);
    let local = vec3f(dot(viewer, axes[0]), dot(viewer, axes[1]), n_v);
    let count = select(DIRECTIONS, FEW_DIRECTIONS, few);
    let level = i32(GRIDS - 1u - grids.level);
    let side = exp2(f32(level));
    var all_shares = 0.0;
    var kept = 0.0;
    var sum = vec4f(0.0);
    for (var number = 0u; number < count; number++) {
        let at = hammersley(number, f32(count));
        let chosen = facet_number(at, f32(count));
        let part = chosen.y;
        let facet = visible_facet(alpha, local, disc_point(vec2f(chosen.x, at.y)));
        let light = facet * (2.0 * dot(local, facet)) - local;
        let direction = axes[0] * light.x + axes[1] * light.y + normal * light.z;
        let share = unshadowed_share(alpha, light.z, n_v) * part;
        all_shares += share;
        // Light from below the flat surface is lost.
        if !(share > 0.0) || dot(direction, geometric) <= 0.0 {
            continue;
        }
        kept += share;
        let found = find(own, vec2f(cell) + 0.5, direction, steps);
        let extent = extent_of_sample(alpha, facet.z, n_v, f32(count)) * part;
        // The base-4 logarithm of the cells that the direction's part covers, rounded down: cells overlap when they are
        // interpolated.
        let cells = extent / cell_extent(own, found.distance);
        let coarser = (i32(bitcast<u32>(cells) >> 23u) - 127) >> 1u;
        sum += pyramid_at(found.cell * side, level + coarser) * share;
    }
    return vec4f(sum.xyz * (kept / (max(all_shares, 1e-37) * max(sum.w, 1e-37))), sum.w);
}

// True if lobes cover fewer, or at least, so many cells of a grid across in a cell or beside it.
fn is_any_narrow(level: u32, cell: vec2u, cells: f32, is_wide: bool) -> bool {
    let grid = grids.levels[level];
    for (var beside = 0u; beside < 9u; beside++) {
        let other = vec2i(cell) + vec2i(i32(beside % 3u), i32(beside / 3u)) - 1;
        if any(other < vec2i(0)) || any(other >= vec2i(grid.xy)) {
            continue;
        }
        let shape = shape_of_cell(cell_index(level, vec2u(other)));
        if shape.object != 0u && (shape.width_px < cells * f32(grid.z)) != is_wide {
            return true;
        }
    }
    return false;
}

// Places of a grid that are seen where neither a coarser nor a finer grid has all of their light.
@compute @workgroup_size(8, 8)
fn blur(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    let index = own_cell(cell);
    if index == NONE {
        return;
    }
    let shape = shape_of_cell(index);
    let weight = rough_light[2u * index].w;
    // Without a width it has been found by rays of its own.
    if shape.object == 0u || shape.width_px == 0.0 || !(weight > 0.0) {
        return;
    }
    let level = grids.level;
    var between = BLURRED_CELLS;
    if level > 0u && !is_any_narrow(level - 1u, cell / 2u, between[level - 1u].y, false) {
        return;
    }
    if level + 1u < GRIDS && !is_any_narrow(level, cell, between[level].x, true) {
        return;
    }
    let finest_cells = shape.width_px / f32(grids.levels[GRIDS - 1u].z);
    let is_near = finest_cells < NEAR_CELLS && lobe_width(rough_lobes[2u * index].w) < NEAR_WIDTH;
    let mean = lobe_mean(index, cell, is_near && finest_cells < FEW_CELLS, select(WIDE_STEPS, NEAR_STEPS, is_near));
    let radiance = select(rough_sharp[index].xyz, mean.xyz, mean.w > 1e-3);
    rough_light[2u * index] = vec4f(finite_light(radiance) * weight, weight);
}

fn finite_light(radiance: vec3f) -> vec3f {
    return select(vec3f(0.0), radiance, all(abs(radiance) < vec3f(3e38)));
}
