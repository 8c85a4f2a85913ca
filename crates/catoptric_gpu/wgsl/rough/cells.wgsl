// The tracing of a grid: which rough mirrors its rays meet, and what those would show if they were smooth. The twin of
// `draw/rough/trace`.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "scene/environment.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "scene/shade.wgsl"
//#include "light/trace.wgsl"
//#include "tiles/cells.wgsl"
//#include "light/paths/follow.wgsl"
//#include "light/paths/nothing_known.wgsl"
//#include "light/paths/whole_scene.wgsl"
//#include "rough/tables.wgsl"

// Rays from rough mirrors that are seen in rough mirrors: blurred once more, their noise hardly shows.
const RAYS_OF_SEEN = 4.0;
// Rays from each of the finest cells of a rough mirror with a map of normals: what rays of neighbouring cells show says
// little of each other.
const RAYS_OF_BUMPY = 16u;
// Lobes may look for cells that something hides, or beyond the picture, up to so many of the largest cells away, and
// where lobes are narrow in the next coarser grid, in its cells.
const MARGIN = 16;
const REACH = 6;
// Rays go through a finer grid where lobes cover fewer cells across.
const CELLS_OF_LOBE = 4.0;
// Bits of `rough_near`, for cells of the same row that are near: one where a rough mirror is seen; ones with narrow
// lobes within reach; and ones with narrow lobes right beside it.
const NEAR_SEEN = 1u;
const NEAR_REACHED = 2u;
const NEAR_NARROW = 4u;

// Everything is traced.
fn hit_on_path(segment: Segment, place: PictureRay) -> u32 {
    return traced_hit(segment);
}

// True if a bit of `rough_near` is set in a cell's column within so many rows.
fn is_near(level: u32, cell: vec2u, bit: u32, reach: i32) -> bool {
    let grid = grids.levels[level];
    let first = max(i32(cell.y) - reach, 0);
    let last = min(i32(cell.y) + reach, i32(grid.y) - 1);
    for (var row = first; row <= last; row++) {
        if (rough_near[cell_index(level, vec2u(cell.x, u32(row)))] & bit) != 0u {
            return true;
        }
    }
    return false;
}

// For each cell of a grid whose rays are known what is near in its row.
@compute @workgroup_size(8, 8)
fn find_near(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    let index = own_cell(cell);
    if index == NONE {
        return;
    }
    let grid = grids.levels[grids.level];
    var near = 0u;
    let first = max(i32(cell.x) - MARGIN, 0);
    let last = min(i32(cell.x) + MARGIN, i32(grid.x) - 1);
    for (var column = first; column <= last; column++) {
        let other = cell_index(grids.level, vec2u(u32(column), cell.y));
        let aside = abs(column - i32(cell.x));
        if (rough_met[other] & IS_SEEN) != 0u {
            near |= NEAR_SEEN;
        }
        let shape = shape_of_cell(other);
        if shape.object != 0u && shape.width_px < CELLS_OF_LOBE * f32(grid.z) {
            near |= select(0u, NEAR_REACHED, aside <= REACH + 1) | select(0u, NEAR_NARROW, aside <= 1);
        }
    }
    rough_near[index] = near;
}

// Bits of `rough_met`.
const IS_SEEN = 0x80000000u;
const MET_TRIANGLE = 0x7fffffffu;

fn near_distance(ray: Ray) -> f32 {
    return grids.near / max(dot(ray.direction, grids.forward), 1e-6);
}

// Rough mirrors that are seen.
@compute @workgroup_size(8, 8)
fn meet(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    let index = own_cell(cell);
    if index == NONE {
        return;
    }
    var none: RoughLight;
    set_light(index, none);
    rough_sharp[index] = vec4f(0.0);
    rough_passages[4u * index + 1u] = vec4f(0.0);
    rough_met[index] = 0u;
    let at = middle_of_cell(grids.level, cell);
    let is_inside = all(at >= vec2f(0.0)) && at.x < f32(frame.width) && at.y < f32(frame.height);
    if !is_inside {
        return;
    }
    if grids.level > 0u && !is_near(grids.level - 1u, cell / 2u, NEAR_NARROW, 1) {
        return;
    }
    let ray = eye_ray(at);
    let triangle = nearest(frame.root, ray, near_distance(ray), FAR, NO_RULE, 0u).triangle;
    if triangle != NONE && is_rough(object_of(triangle)) {
        rough_met[index] = (triangle + 1u) | IS_SEEN;
    }
}

// Rough mirrors that are not seen, in cells near those which are: something hides them, or they lie beyond the picture.
fn hidden_triangle(cell: vec2u) -> u32 {
    if grids.level == 0u && !is_near(0u, cell, NEAR_SEEN, MARGIN) {
        return NONE;
    }
    if grids.level > 0u && !is_near(grids.level - 1u, cell / 2u, NEAR_REACHED, REACH + 1) {
        return NONE;
    }
    let ray = eye_ray(middle_of_cell(grids.level, cell));
    return nearest(frame.root, ray, near_distance(ray), FAR, NO_RULE, IS_ROUGH).triangle;
}

// The places that were met, and what their sharp rays show.
@compute @workgroup_size(8, 8)
fn follow(@builtin(global_invocation_id) invocation: vec3u) {
    let cell = invocation.xy;
    let index = own_cell(cell);
    if index == NONE {
        return;
    }
    let is_seen = rough_met[index] != 0u;
    var triangle = (rough_met[index] & MET_TRIANGLE) - 1u;
    if !is_seen {
        triangle = hidden_triangle(cell);
    }
    if triangle == NONE {
        return;
    }
    let cell_px = f32(grids.levels[grids.level].z);
    let at = middle_of_cell(grids.level, cell);
    var path = eye_segment(at, cell_px);
    let incoming = path.ray.direction;
    let met = drawn_encounter(triangle, path.ray, path.change, 1u, 0u);
    let object = met.point.object;
    var step: LightStep;
    let turned = turned_encounter(met);
    step.facing = facing(incoming, met.point.geometric_normal, turned.met.point.normal);
    step.eta = 1.0;
    step.reflected = vec3f(1.0);
    let is_blind = step.facing.outside && (surface_of(object).flags & INSIDE) != 0u;
    if is_blind {
        return;
    }
    path.order = 1u;
    let alpha = facets_alpha(object, turned.variance);
    let is_bumpy = HAS_TURNS && surface_of(object).turning_map != NONE;
    var spread: Spread;
    spread.by = BY_FACETS;
    spread.alpha = alpha;
    spread.path = path;
    spread.met = turned.met;
    spread.step = step;
    let normal = step.facing.normal;
    let reflected = reflected_surroundings(sqrt(alpha), max(-dot(incoming, normal), 1e-3));
    var place: PictureRay;
    place.side = 1.0;
    place.samples = 1u;
    place.rays = RAYS_OF_SEEN;
    let moved = moved_by(vec3f(at, 0.0), vec3f(0.0));
    place.numbers = RayNumbers(moved, 0u, 1u, RAYS_OF_SEEN);
    // The mean of rays of the lobe where bumps are, at cells that are seen in the finest grid, or else the sharp ray's.
    let is_finest = grids.level == GRIDS - 1u;
    let lobe_rays = select(0u, RAYS_OF_BUMPY, is_finest && is_seen);
    let rays = select(1u, lobe_rays, is_bumpy);
    var child: Segment;
    var sum = vec4f(0.0);
    var met_at = FAR;
    for (var ray = 0u; ray < rays; ray++) {
        var share = 1.0;
        if is_bumpy {
            let count = f32(RAYS_OF_BUMPY);
            child = spread_ray(spread, ray, count, REFLECT, RayNumbers(moved, 0u, 1u, count), 1.0);
            share = child.throughput.x;
            child.throughput = vec3f(1.0);
        } else {
            child = departed(path, REFLECT, vec3f(1.0), met, step);
        }
        if !(share > 0.0) || all(child.ray.direction == vec3f(0.0)) {
            continue;
        }
        let first = nearest(frame.root, child.ray, 0.0, FAR, child.own, 0u);
        let radiance = finite(light_along(child, (first.triangle + 1u) | HIT_REFLECTS, place));
        sum += vec4f(radiance, 1.0) * share;
        met_at = min(met_at, first.distance);
    }
    let sharp = sum.xyz / max(sum.w, 1e-12);
    var light: RoughLight;
    light.share = reflected.x + reflected.y;
    light.distance = min(met_at, NO_DISTANCE);
    if is_seen {
        light.object = object + 1u;
    }
    if is_bumpy {
        // Cells of bumpy mirrors tell nothing of each other: they are not blurred.
        light.weight = select(0.0, 1.0, sum.w > 0.0);
        light.radiance = sharp;
        set_light(index, light);
        return;
    }
    var passage: Passage;
    let axes = axes_across(child.ray.direction);
    let dx = child.change.origin_dx;
    let dy = child.change.origin_dy;
    let turn_x = child.change.direction_dx;
    let turn_y = child.change.direction_dy;
    passage.position = child.ray.origin;
    passage.direction = child.ray.direction;
    passage.start = vec4f(dot(dx, axes[0]), dot(dx, axes[1]), dot(dy, axes[0]), dot(dy, axes[1]));
    passage.growth = vec4f(dot(turn_x, axes[0]), dot(turn_x, axes[1]), dot(turn_y, axes[0]), dot(turn_y, axes[1]));
    passage.distance = min(met_at, grids.greatest_distance);
    passage.object = object + 1u;
    set_passage(index, passage);
    rough_lobes[2u * index] = vec4f(normal, alpha);
    rough_lobes[2u * index + 1u] = vec4f(step.facing.geometric, 0.0);
    rough_sharp[index] = vec4f(sharp, 1.0);
    light.width_px = lobe_width(alpha) / sqrt(cell_extent(passage, passage.distance)) * cell_px;
    let finest_px = f32(grids.levels[GRIDS - 1u].z);
    let width_in_finest = light.width_px / finest_px;
    light.weight = clamp((width_in_finest - SHARP_CELLS.x) / (SHARP_CELLS.y - SHARP_CELLS.x), 0.0, 1.0);
    light.radiance = sharp * light.weight;
    set_light(index, light);
}
