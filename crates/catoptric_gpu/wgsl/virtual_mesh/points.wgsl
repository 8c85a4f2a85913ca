// Points with all their appearances.

// A point has no more appearances, and no more searches; a bound on time. Chosen, not measured.
const MOST_APPEARANCES_A_POINT = 8u;
const MOST_SEARCHES = 16u;
// Rays of the grid that pass a point by a greater angle lead to nothing: its cosine. Chosen, not measured.
const LEAST_FIT = 0.7;
// Two that are nearer than this, in pixels, are one.
const SAME_PX = 0.5;

// Places of the picture where the search for a point begins.
var<private> starts: array<vec2f, MOST_SEARCHES>;
var<private> start_count: u32;

fn add_start(image_px: vec2f) {
    if start_count < MOST_SEARCHES {
        starts[start_count] = image_px;
        start_count++;
    }
}

// How well a ray of the grid leads to a point: the cosine of the angle by which it passes; below 0 where there is none.
fn fit_of(number: u32, point: vec3f) -> f32 {
    let ray = start_rays[number];
    let offset = point - ray.origin;
    let cosine = dot(offset, ray.direction) * inverseSqrt(max(dot(offset, offset), 1e-37));
    return select(-1.0, cosine, ray.weight > 0.0);
}

// The ray of the grid that leads to the point best; if it may appear several times every one that does so better than
// those beside it.
fn start_by_rays(point: vec3f) {
    let is_single = reflection.shows_itself == 0u;
    var best = 0.0;
    var best_number = NONE;
    var above: array<f32, GRID_SIDE + 2u>;
    var here: array<f32, GRID_SIDE + 2u>;
    var below: array<f32, GRID_SIDE + 2u>;
    for (var column = 0u; column < GRID_SIDE + 2u; column++) {
        here[column] = -1.0;
        above[column] = -1.0;
        below[column] = -1.0;
    }
    for (var row = 0u; row <= GRID_SIDE; row++) {
        for (var column = 0u; column < GRID_SIDE; column++) {
            var fit = -1.0;
            if row < GRID_SIDE {
                fit = fit_of(row * GRID_SIDE + column, point);
            }
            if fit > best {
                best = fit;
                best_number = row * GRID_SIDE + column;
            }
            above[column + 1u] = here[column + 1u];
            here[column + 1u] = below[column + 1u];
            below[column + 1u] = fit;
        }
        for (var column = 1u; column <= GRID_SIDE && row > 0u && !is_single; column++) {
            let fit = here[column];
            let beside = max(max(here[column - 1u], here[column + 1u]), max(above[column], below[column]));
            let across = max(
                max(above[column - 1u], above[column + 1u]),
                max(below[column - 1u], below[column + 1u]),
            );
            if fit > LEAST_FIT && fit >= max(beside, across) {
                add_start(start_px((row - 1u) * GRID_SIDE + column - 1u));
            }
        }
    }
    if is_single && best_number != NONE {
        add_start(start_px(best_number));
    }
}

// A point with its appearances, looked for from the places that there are already; where these are not sure to be all,
// or lead to none, from those of the method.
fn projected(position: vec3f, weights: vec2f, are_all: bool) -> Point {
    var found: array<Appearance, MOST_APPEARANCES_A_POINT>;
    var count = 0u;
    for (var attempt = 0u; attempt < 2u && (count == 0u || !are_all); attempt++) {
        if attempt == 1u {
            start_count = 0u;
            if FROM_MAPS {
                let start = start_by_maps(position);
                starts[0] = start.xy;
                start_count = u32(start.z > 0.0);
            } else {
                start_by_rays(position);
            }
        }
        for (var number = 0u; number < start_count && count < MOST_APPEARANCES_A_POINT; number++) {
            let one = appearance_from(position, starts[number]);
            var is_new = one.state != NOWHERE;
            for (var index = 0u; index < count; index++) {
                is_new = is_new && distance(found[index].image_px, one.image_px) >= SAME_PX;
            }
            if is_new {
                found[count] = one;
                count++;
            }
        }
    }
    start_count = 0u;
    let first = atomicAdd(&work[APPEARANCES], count);
    if first + count > reflection.most_appearances {
        atomicStore(&work[IS_FULL], 1u);
        count = 0u;
    }
    for (var index = 0u; index < count; index++) {
        appearances[first + index] = found[index];
    }
    return Point(position, first, weights, count, 0u);
}
