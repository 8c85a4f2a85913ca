// Where rays meet what the texels of a layer show: the twin of
// `methods/lookup/layered_environment_map/textures/distances` and `bounds`. What the numbers mean is said there.

const STEPS_A_LOGARITHM = 17.16;
const MOST_DEPTH_STEPS = 12.0;
const NEAREST_STEP = 1.0 / 64.0;
const REFINEMENTS = 8u;
const EXACT_TEXELS = 0.1;
const ALIKE = 1.1;
const EDGE = 1.03;
const MOST_EDGES = 3u;
const ON_SHELL = 1e-3;
// Texels a side of the smallest cells with bounds, as a power of two.
const FINEST_CELL = 2u;
// The code of what is infinitely far.
const FAR_CODE = 0xffffu;

// A ray as it meets what is shown.
struct LayerHit {
    distance: f32,
    // By what the shell is grown to go through the hit.
    share: f32,
    is_met: bool,
    // True if the ray meets the grown shell there from outside, towards the centre.
    is_inward: bool,
    // Where the ray leaves the grown shell.
    outward: f32,
}

// A place, by its share, and what is shown in its direction.
struct TexelDepth {
    own: f32,
    front: f32,
    back: f32,
}

struct SearchInterval {
    start: f32,
    furthest: f32,
    is_open: bool,
}

struct HiddenSurface {
    share: f32,
    // The last place before the edge that hides it.
    edge: f32,
}

struct Changed {
    distance: f32,
    is_met: bool,
    is_passed: bool,
    hidden: HiddenSurface,
}

// An interval along a ray that holds a change from before to behind a surface.
struct Bracket {
    near: f32,
    far: f32,
    shown_near: f32,
    above: f32,
    below: f32,
    is_flat: bool,
    from_behind: bool,
}

fn layer_word(index: u32) -> u32 {
    return textureLoad(layer_words, row_of(index), 0).x;
}

fn depth_of_code(layer: Layer, code: u32) -> f32 {
    return select(bitcast<f32>(layer.depth_base + (code << layer.depth_shift)), FAR, code == FAR_CODE);
}

// Depths of the texel in the direction of a place from the centre.
fn shown_at(layer: Layer, place: vec3f) -> TexelDepth {
    let located = face_place(layer, seen_at(layer, place));
    var result = TexelDepth(shell_scale(layer, place), FAR, FAR);
    if all(abs(located.at) <= vec2f(1.0)) {
        let texel = in_texels(layer, located);
        let word = layer_word(layer.first_depth + (texel.x * layer.size + texel.z) * layer.size + texel.y);
        result.front = depth_of_code(layer, word & 0xffffu);
        result.back = depth_of_code(layer, word >> 16u);
    }
    return result;
}

// The same, between the middles of texels where these show much the same.
fn smooth_at(layer: Layer, place: vec3f) -> TexelDepth {
    let located = face_place(layer, seen_at(layer, place));
    var result = TexelDepth(shell_scale(layer, place), FAR, FAR);
    if !all(abs(located.at) <= vec2f(1.0)) {
        return result;
    }
    let last = f32(layer.size - 1u);
    let at = min(max((located.at + 1.0) * (0.5 * f32(layer.size)) - 0.5, vec2f(0.0)), vec2f(last));
    let low = min(floor(at), vec2f(max(last - 1.0, 0.0)));
    let aside = at - low;
    let first = layer.first_depth + (located.face * layer.size + u32(low.y)) * layer.size + u32(low.x);
    let upper = vec2u(layer_word(first), layer_word(first + 1u));
    let lower = vec2u(layer_word(first + layer.size), layer_word(first + layer.size + 1u));
    let above = select(upper.x, upper.y, aside.x > 0.5);
    let below = select(lower.x, lower.y, aside.x > 0.5);
    let nearest_word = select(above, below, aside.y > 0.5);
    let a = depth_of_code(layer, upper.x & 0xffffu);
    let b = depth_of_code(layer, upper.y & 0xffffu);
    let c = depth_of_code(layer, lower.x & 0xffffu);
    let d = depth_of_code(layer, lower.y & 0xffffu);
    let least = min(min(a, b), min(c, d));
    let most = max(max(a, b), max(c, d));
    let is_smooth = most <= least * ALIKE && most < FAR;
    result.front = depth_of_code(layer, nearest_word & 0xffffu);
    result.back = depth_of_code(layer, nearest_word >> 16u);
    if is_smooth {
        let row = a + (b - a) * aside.x;
        let next_row = c + (d - c) * aside.x;
        result.front = row + (next_row - row) * aside.y;
    }
    return result;
}

// The interval along a ray in which surfaces between two shares may be hit.
fn search_interval(layer: Layer, ray: ShellRay, begin: f32, least: f32, most: f32) -> SearchInterval {
    let nearest_share = grown_distance(layer, ray, least * (1.0 - ON_SHELL));
    let furthest = grown_distance(layer, ray, most * (1.0 + ON_SHELL));
    let start = select(0.0, nearest_share, begin < least);
    return SearchInterval(start, furthest, furthest > start && furthest < FAR);
}

// The least share at which something is shown in a cell of a level, and the largest at which something ends.
fn bounds_of_cell(layer: Layer, level: u32, face: u32, column: u32, row: u32) -> vec2f {
    var first = 0u;
    for (var finer = 0u; finer < level; finer++) {
        let side = max(layer.size >> (FINEST_CELL + finer), 1u);
        first += layer.faces * side * side;
    }
    let side = max(layer.size >> (FINEST_CELL + level), 1u);
    let cell = first + (face * side + min(row, side - 1u)) * side + min(column, side - 1u);
    let place = layer.first_bound + 2u * cell;
    return vec2f(bitcast<f32>(layer_word(place)), bitcast<f32>(layer_word(place + 1u)));
}

// The bounds of what is shown wherever the way between two places passes: on one face it lies in the rectangle about
// them.
fn bounds_between(layer: Layer, start: vec3u, end: vec3u) -> vec2f {
    if start.x != end.x {
        return vec2f(0.0, FAR);
    }
    // Rounding may take places on the way to the next texel.
    let least = max(min(start.yz, end.yz), vec2u(1u)) - 1u;
    let low = least >> vec2u(FINEST_CELL);
    let high = min(max(start.yz, end.yz) + 1u, vec2u(layer.size - 1u)) >> vec2u(FINEST_CELL);
    let span = max(high.x - low.x, high.y - low.y);
    // The rectangle reaches into no more than two times two cells that are no smaller than itself.
    let wanted = select(0u, firstLeadingBit(span - 1u) + 1u, span > 1u);
    let level = min(wanted, layer.bound_levels - 1u);
    let first = low >> vec2u(level);
    let last = high >> vec2u(level);
    let a = bounds_of_cell(layer, level, start.x, first.x, first.y);
    let b = bounds_of_cell(layer, level, start.x, last.x, first.y);
    let c = bounds_of_cell(layer, level, start.x, first.x, last.y);
    let d = bounds_of_cell(layer, level, start.x, last.x, last.y);
    return vec2f(min(min(a.x, b.x), min(c.x, d.x)), max(max(a.y, b.y), max(c.y, d.y)));
}

// Places behind a surface that lie on it or within its extent.
fn is_on(depth: TexelDepth) -> bool {
    return depth.own <= depth.front * EDGE || depth.own <= depth.back;
}

// Where a bracket closes, after a number of steps or where that is exact.
fn refined(layer: Layer, ray: ShellRay, bracket: ptr<function, Bracket>, is_exact: ptr<function, bool>) -> f32 {
    let exact = EXACT_TEXELS * 2.0 / f32(layer.size);
    for (var refinement = 0u; refinement < REFINEMENTS; refinement++) {
        // By the rule of false position, and half way in turn; half way, too, where nothing is shown at one end.
        let ratio = (*bracket).above / ((*bracket).above + (*bracket).below);
        let part = select(0.5, ratio, ratio > 0.0 && ratio < 1.0 && refinement % 2u == 0u);
        let tried = (*bracket).near + ((*bracket).far - (*bracket).near) * part;
        let depth = smooth_at(layer, at_distance(ray, tried));
        let is_in = depth.front <= depth.own && (depth.own <= depth.back || !(*bracket).from_behind);
        if is_in {
            (*bracket).far = tried;
            (*bracket).below = depth.own - depth.front;
            (*bracket).is_flat = is_on(depth);
        } else {
            (*bracket).near = tried;
            (*bracket).above = depth.front - depth.own;
            (*bracket).shown_near = depth.front;
        }
        if abs(depth.front - depth.own) < depth.own * exact {
            *is_exact = true;
            return tried;
        }
    }
    return (*bracket).far;
}

// The first change, in an interval, from before to behind what is shown, or from behind a thing into it or to what it
// hides.
fn changed_within(layer: Layer, ray: ShellRay, start: f32, furthest: f32, hidden: HiddenSurface) -> Changed {
    // Steps of equal length in the inverse of about the distance from the centre.
    let offset = max(length(ray.origin), furthest * NEAREST_STEP);
    let first = 1.0 / (start + offset);
    let change = min(1.0 / (furthest + offset) - first, 0.0);
    let ratio = 1.0 + change / first;
    let steps = clamp(ceil((1.0 - ratio) / sqrt(ratio) * STEPS_A_LOGARITHM), 1.0, MOST_DEPTH_STEPS);
    let begin = shown_at(layer, at_distance(ray, start));
    var bracket = Bracket(start, start, begin.front, begin.front - begin.own, 0.0, false, false);
    var is_before = begin.front > begin.own;
    var is_beyond = begin.back < begin.own;
    var is_found = false;
    var reaches_hidden = false;
    var hidden_share = hidden.share;
    for (var step = 1.0; step <= steps && !is_found; step += 1.0) {
        let tried = max(1.0 / (first + change * min(step / steps, 1.0)) - offset, start);
        let depth = shown_at(layer, at_distance(ray, tried));
        let is_behind = depth.front <= depth.own;
        let is_within = is_behind && depth.own <= depth.back;
        hidden_share = select(FAR, hidden_share, is_behind);
        let is_at_hidden = is_beyond && depth.own >= hidden_share;
        let enters = (is_behind && is_before) || (is_within && is_beyond);
        is_found = enters || is_at_hidden;
        if is_found {
            bracket.from_behind = is_beyond;
            reaches_hidden = is_at_hidden;
            bracket.far = tried;
            bracket.below = depth.own - depth.front;
            bracket.is_flat = is_on(depth);
        } else {
            bracket.near = tried;
            bracket.shown_near = depth.front;
            bracket.above = depth.front - depth.own;
            is_before = !is_behind;
            is_beyond = is_behind && !is_within;
        }
    }
    if !is_found {
        return Changed(bracket.far, false, false, hidden);
    }
    var is_exact = reaches_hidden;
    var distance = hidden.edge;
    if !reaches_hidden {
        distance = refined(layer, ray, &bracket, &is_exact);
    }
    let is_there = is_exact || bracket.is_flat;
    return Changed(distance, is_there, !is_there, HiddenSurface(bracket.shown_near, bracket.near));
}

// Where a ray meets what a layer shows first.
fn layer_hit(layer: Layer, ray: ShellRay) -> LayerHit {
    if layer.most <= layer.least * (1.0 + ON_SHELL) {
        let share = max(layer.most, LEAST_NUMBER);
        let distance = grown_distance(layer, ray, share);
        return LayerHit(distance, share, layer.least <= layer.most, false, distance);
    }
    let begin = shell_scale(layer, ray.origin);
    var interval = search_interval(layer, ray, begin, layer.least, layer.most);
    if interval.is_open && layer.first_bound != NONE {
        let start = in_texels(layer, face_place(layer, seen_at(layer, at_distance(ray, interval.start))));
        let end = in_texels(layer, face_place(layer, seen_at(layer, at_distance(ray, interval.furthest))));
        let range = bounds_between(layer, start, end);
        interval.is_open = false;
        if range.x <= range.y {
            interval = search_interval(layer, ray, begin, max(layer.least, range.x), min(layer.most, range.y));
        }
    }
    var hit = LayerHit(interval.start, begin, false, false, interval.furthest);
    var hidden = HiddenSurface(FAR, interval.start);
    var start = interval.start;
    for (var edge = 0u; edge <= MOST_EDGES && interval.is_open; edge++) {
        let changed = changed_within(layer, ray, start, interval.furthest, hidden);
        if changed.is_met {
            hit.distance = changed.distance;
            hit.is_met = true;
        }
        // Past an edge: on from there.
        interval.is_open = changed.is_passed;
        start = changed.distance;
        hidden = changed.hidden;
    }
    if hit.is_met {
        hit.share = shell_scale(layer, at_distance(ray, hit.distance));
        // Shells are convex: a ray meets one on its way in, where it does not meet it on its way out.
        hit.outward = grown_distance(layer, ray, hit.share);
        hit.is_inward = hit.distance < hit.outward * (1.0 - ON_SHELL);
    }
    return hit;
}
