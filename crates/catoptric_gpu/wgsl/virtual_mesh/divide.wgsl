// Pieces of triangles, divided until they may be drawn straight. Whether an edge is divided depends on its two ends
// alone, so neighbours agree and no crack opens: the twin of the rules of `draw/virtual_mesh/edge`. What appears only
// in part is not cut where it ends, but left to tiles.

//#include "virtual_mesh/search.wgsl"
//#include "virtual_mesh/starts.wgsl"
//#include "virtual_mesh/work.wgsl"
//#include "virtual_mesh/points.wgsl"
//#include "tiles/cells.wgsl"

// As on the processor.
const LONGEST = 0.35;
const NEAREST = 0.1;
const JUMP = 4.0;
// Where an appearance ends on an edge, its pieces may be this many times the smallest size: what is left out there,
// tiles follow. Chosen, not measured.
const END_PIECES = 4.0;
// Pieces that reach further than this from a place in the reflector to one beside it, in pixels, are not drawn. Chosen,
// not measured.
const TORN_PX = 40.0;
// Areas that are left to tiles are larger than the pieces by this, in pixels, and nearer by this factor. Chosen, not
// measured.
const MARGIN_PX = 1.5;
const NEARER = 0.98;

// Edges are halved at most this often. A bound on time; chosen, not measured.
const MOST_ROUNDS = 14u;
// From then on what is followed from both ends of an edge is all that its middle shows. Chosen, not measured.
const SURE_ROUNDS = 3u;

// True if places all lie beyond one side of what is shown.
fn are_aside(a: vec2f, b: vec2f) -> bool {
    let below = (a < reflection.shown_low) & (b < reflection.shown_low);
    let above = (a > reflection.shown_high) & (b > reflection.shown_high);
    return any(below | above);
}

// How an appearance moves with a step of its point, to first order.
fn predicted_by(one: Appearance, step: vec3f) -> vec2f {
    return vec2f(dot(one.change_x, step), dot(one.change_y, step));
}

// How far two appearances at the ends of a step are from predicting each other, in pixels: seen in perspective they
// move the less the further away they get.
fn mismatch(one: Appearance, other: Appearance, step: vec3f) -> f32 {
    let between = other.image_px - one.image_px;
    let ahead = predicted_by(one, step) * (one.w / other.w) - between;
    let back = predicted_by(other, -step) * (other.w / one.w) + between;
    return max(length(ahead), length(back));
}

// The appearance at the other end of a step that belongs to one: that which is predicted best, if it predicts no other
// better in turn; NONE without one.
fn partner_of(number: u32, here: Point, there: Point) -> u32 {
    let one = appearances[number];
    let step = there.position - here.position;
    var best = NONE;
    var least = FARTHEST_STEP_PX;
    for (var index = there.first; index < there.first + there.count; index++) {
        let other = appearances[index];
        let apart = mismatch(one, other, step);
        if other.is_turned == one.is_turned && apart < least {
            least = apart;
            best = index;
        }
    }
    for (var index = here.first; index < here.first + here.count && best != NONE; index++) {
        let rival = appearances[index];
        if index != number && rival.is_turned == one.is_turned && mismatch(rival, appearances[best], step) < least {
            best = NONE;
        }
    }
    return best;
}

// True if two appearances at the ends of an edge must belong together.
fn are_sure(one: Appearance, other: Appearance, step: vec3f) -> bool {
    let size_px = distance(one.image_px, other.image_px);
    if one.state != other.state {
        return size_px <= TORN_PX;
    }
    // Edges that are divided no further are within a half of this.
    let allowed = max(8.0 * reflection.edge_error_px, 2.0 * reflection.piece_px);
    return one.state == BESIDE_IT || mismatch(one, other, step) <= allowed;
}

// The appearance at the other end of a step that belongs to one for sure; NONE without one.
fn sure_partner(number: u32, here: Point, there: Point) -> u32 {
    let other = partner_of(number, here, there);
    if other == NONE || !are_sure(appearances[number], appearances[other], there.position - here.position) {
        return NONE;
    }
    return other;
}

// True if an edge is divided because of an appearance at its first end.
fn is_divided_by(number: u32, here: Point, there: Point) -> bool {
    let one = appearances[number];
    let step = there.position - here.position;
    let ahead = predicted_by(one, step);
    let end_px = END_PIECES * reflection.piece_px;
    let partner = partner_of(number, here, there);
    if partner == NONE {
        return one.state == WITHIN && length(ahead) > end_px && !are_aside(one.image_px, one.image_px + ahead);
    }
    let other = appearances[partner];
    if are_aside(one.image_px, other.image_px) || (one.state == BESIDE_IT && other.state == BESIDE_IT) {
        return false;
    }
    let between = other.image_px - one.image_px;
    let distance_px = length(between);
    let back = predicted_by(other, -step);
    if one.state != other.state {
        // Beside the reflector places are only about known.
        let extent = select(length(back), length(ahead), one.state == WITHIN);
        return max(extent, min(distance_px, JUMP * extent)) > end_px;
    }
    let extent = max(length(ahead), length(back));
    if distance_px > JUMP * extent {
        return extent > end_px;
    }
    let deviation = max(length(ahead - between * (other.w / one.w)), length(back + between * (one.w / other.w)));
    return deviation * 0.25 > reflection.edge_error_px && max(distance_px, extent) > reflection.piece_px;
}

// True if nothing of a point is in the picture, over an edge.
fn is_aside(here: Point, there: Point) -> bool {
    let step = there.position - here.position;
    var result = true;
    for (var index = here.first; index < here.first + here.count; index++) {
        let one = appearances[index];
        result = result && are_aside(one.image_px, one.image_px + predicted_by(one, step));
    }
    return result;
}

fn is_divided(here: Point, there: Point) -> bool {
    let step = there.position - here.position;
    let size = length(step);
    if !(size > reflection.shortest) {
        return false;
    }
    let middle = (here.position + there.position) * 0.5;
    let beyond = length(max(max(reflection.box_low - middle, middle - reflection.box_high), vec3f(0.0)));
    let near_by = max(2.0 * beyond, NEAREST * reflection.radius);
    let center = (reflection.box_low + reflection.box_high) * 0.5;
    let apart = min(max(distance(middle, center), reflection.radius), near_by);
    if size > LONGEST * apart {
        let is_known = here.count > 0u && there.count > 0u;
        return !is_known || !is_aside(here, there) || !is_aside(there, here);
    }
    // By the appearances of both ends.
    for (var index = 0u; index < here.count + there.count; index++) {
        let is_first = index < here.count;
        let number = select(there.first + index - here.count, here.first + index, is_first);
        var from_point = here;
        var to_point = there;
        if !is_first {
            from_point = there;
            to_point = here;
        }
        if is_divided_by(number, from_point, to_point) {
            return true;
        }
    }
    return false;
}

// The weights of a corner in its piece's source.
fn weights_of(corner: u32, source: u32) -> vec2f {
    if corner >= reflection.vertex_count {
        return points[corner].weights;
    }
    let vertices = corners_of(source);
    return vec2f(f32(corner == vertices.y && corner != vertices.x), f32(corner == vertices.z && corner != vertices.y));
}

// Begins in the middle between appearances at the ends of an edge that belong together; true if there is no doubt that
// these are all. In the first rounds there is: edges are long.
fn start_between(here: Point, there: Point) -> bool {
    let is_late = reflection.shows_itself == 0u || atomicLoad(&work[ROUND]) > SURE_ROUNDS;
    var are_all = is_late && here.count == there.count;
    for (var number = here.first; number < here.first + here.count; number++) {
        let partner = partner_of(number, here, there);
        if partner == NONE {
            are_all = false;
            continue;
        }
        let one = appearances[number];
        let other = appearances[partner];
        let middle_px = (one.image_px + other.image_px) * 0.5;
        if one.state == WITHIN && other.state == WITHIN && triangle_at_px(middle_px) != NONE {
            add_start(middle_px);
        } else {
            are_all = false;
        }
    }
    return are_all;
}

// The middle of an edge as a corner; NONE where there is no room.
fn middle_of(a: u32, b: u32, source: u32) -> u32 {
    let place = atomicAdd(&work[POINTS], 1u);
    if place >= reflection.most_points {
        return NONE;
    }
    let here = points[a];
    let there = points[b];
    let position = (here.position + there.position) * 0.5;
    let are_all = start_between(here, there);
    points[place] = projected(position, (weights_of(a, source) + weights_of(b, source)) * 0.5, are_all);
    return place;
}

fn corner_in_clip(one: Appearance) -> vec4f {
    let size = vec2f(f32(frame.width), f32(frame.height));
    let at = one.image_px * one.w * 2.0 / size;
    let is_perspective = (frame.flags & PERSPECTIVE) != 0u;
    let depth = (reflection.far - one.depth) / (reflection.far - reflection.near);
    return vec4f(at.x - one.w, one.w - at.y, select(depth, reflection.near, is_perspective), one.w);
}

// A triangle to be drawn; without a hit: what is there is not known.
fn draw_triangle(corners: array<vec4f, 3>, weights: array<vec2f, 3>, hit: u32) {
    let place = atomicAdd(&work[DRAWN], 1u);
    if place >= reflection.most_drawn {
        atomicStore(&work[IS_FULL], 1u);
        return;
    }
    for (var corner = 0u; corner < 3u; corner++) {
        drawn[(place * 3u + corner) * 2u] = bitcast<vec4u>(corners[corner]);
        drawn[(place * 3u + corner) * 2u + 1u] = vec4u(bitcast<vec2u>(weights[corner]), hit, 0u);
    }
}

// Leaves an appearance to tiles that one corner of a piece has, but not all others: about there they follow rays.
// `numbers` has for each corner the appearance that belongs to it, or NONE.
fn leave_to_tiles(corner: u32, numbers: array<u32, 3>, piece: Piece) {
    let one = appearances[numbers[corner]];
    if one.state != WITHIN {
        return;
    }
    let here = points[piece.corners[corner]];
    var places: array<vec2f, 3>;
    for (var index = 0u; index < 3u; index++) {
        places[index] = one.image_px;
        if numbers[index] != NONE {
            places[index] = appearances[numbers[index]].image_px;
        } else {
            let moves = predicted_by(one, points[piece.corners[index]].position - here.position);
            places[index] += moves * min(1.0, TORN_PX / max(length(moves), 1e-20));
        }
    }
    if are_aside(places[0], places[1]) && are_aside(places[1], places[2]) && are_aside(places[2], places[0]) {
        return;
    }
    let middle = (places[0] + places[1] + places[2]) / 3.0;
    let reach = max(distance(places[0], middle), max(distance(places[1], middle), distance(places[2], middle)));
    // Small areas are left with all about them.
    let around = array<vec2f, 3>(vec2f(0.0, -2.0), vec2f(1.7320508, 1.0), vec2f(-1.7320508, 1.0));
    var shown = one;
    shown.depth *= NEARER;
    shown.w = select(1.0, one.w * NEARER, (frame.flags & PERSPECTIVE) != 0u);
    var corners: array<vec4f, 3>;
    for (var index = 0u; index < 3u; index++) {
        let outwards = places[index] - middle;
        let size = length(outwards);
        shown.image_px = middle + outwards * ((size + 2.0 * MARGIN_PX) / max(size, 1e-6));
        if reach < 4.0 * MARGIN_PX {
            shown.image_px = middle + around[index] * (reach + MARGIN_PX);
        }
        corners[index] = corner_in_clip(shown);
    }
    draw_triangle(corners, array<vec2f, 3>(), 0u);
}

// Every appearance of a piece, from its first corner that has it; what is not finished tiles follow.
fn draw_piece(piece: Piece, is_finished: bool) {
    let role = surface_of(object_of(piece.source)).role;
    let hit = (piece.source + 1u) | select(0u, HIT_REFLECTS, role != DIFFUSE) | select(0u, HIT_REFRACTS, role == LENS);
    for (var corner = 0u; corner < 3u; corner++) {
        let here = points[piece.corners[corner]];
        for (var index = 0u; index < here.count; index++) {
            var numbers = array<u32, 3>(NONE, NONE, NONE);
            numbers[corner] = here.first + index;
            let next = (corner + 1u) % 3u;
            let last = (corner + 2u) % 3u;
            // From this corner to both others, and between these.
            var agreed = NONE;
            for (var edge = 0u; edge < 3u; edge++) {
                let from_corner = select(corner, next, edge == 2u);
                let to_corner = select(last, next, edge == 0u);
                if numbers[from_corner] != NONE {
                    let there = points[piece.corners[to_corner]];
                    let partner = sure_partner(numbers[from_corner], points[piece.corners[from_corner]], there);
                    if edge == 2u {
                        agreed = partner;
                    } else {
                        numbers[to_corner] = partner;
                    }
                }
            }
            let is_drawn_before = (corner > 0u && numbers[0] != NONE) || (corner > 1u && numbers[1] != NONE);
            if is_drawn_before {
                continue;
            }
            let is_whole = numbers[next] != NONE && numbers[last] != NONE && agreed == numbers[last];
            if !is_finished || corner > 0u || !is_whole {
                leave_to_tiles(corner, numbers, piece);
                continue;
            }
            draw_whole(numbers, piece, hit);
        }
    }
}

// A triangle whose corners all have an appearance.
fn draw_whole(numbers: array<u32, 3>, piece: Piece, hit: u32) {
    let a = appearances[numbers[0]];
    let b = appearances[numbers[1]];
    let c = appearances[numbers[2]];
    let is_within = a.state == WITHIN || b.state == WITHIN || c.state == WITHIN;
    let are_all_aside = are_aside(a.image_px, b.image_px) && are_aside(b.image_px, c.image_px)
        && are_aside(c.image_px, a.image_px);
    if !is_within || are_all_aside {
        return;
    }
    let corners = array<vec4f, 3>(corner_in_clip(a), corner_in_clip(b), corner_in_clip(c));
    let weights = array<vec2f, 3>(
        weights_of(piece.corners.x, piece.source),
        weights_of(piece.corners.y, piece.source),
        weights_of(piece.corners.z, piece.source),
    );
    draw_triangle(corners, weights, hit);
}

// Between two rounds of division.
@compute @workgroup_size(1)
fn arrange() {
    // Where there is no room for all, nothing is drawn in the end.
    let is_full = atomicLoad(&work[IS_FULL]) != 0u;
    let count = select(min(atomicLoad(&work[PIECES_NEXT]), reflection.most_pieces), 0u, is_full);
    let groups = (count + 63u) / 64u;
    // A dispatch has at most 65,535 groups a dimension.
    let across = min(groups, 32768u);
    atomicStore(&work[GROUPS], across);
    atomicStore(&work[GROUPS + 1u], select((groups + across - 1u) / across, 0u, across == 0u));
    atomicStore(&work[GROUPS + 2u], 1u);
    atomicStore(&work[PIECES_NOW], count);
    atomicStore(&work[PIECES_NEXT], 0u);
    atomicAdd(&work[ROUND], 1u);
}

@compute @workgroup_size(64)
fn divide(@builtin(global_invocation_id) invocation: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = invocation.x + invocation.y * groups.x * 64u;
    if number >= atomicLoad(&work[PIECES_NOW]) {
        return;
    }
    let piece = pieces[number];
    let outcome = outcome_of(piece);
    if outcome != REPLACED {
        draw_piece(piece, outcome == FINISHED);
    }
}

// A piece need not be divided; it has been; or it could not be.
const FINISHED = 0u;
const REPLACED = 1u;
const LEFT_OVER = 2u;

// Divides a piece, where it has to be and may be.
fn outcome_of(piece: Piece) -> u32 {
    var sides: array<bool, 3>;
    var count = 0u;
    for (var side = 0u; side < 3u; side++) {
        let start = points[piece.corners[(side + 1u) % 3u]];
        let end = points[piece.corners[(side + 2u) % 3u]];
        sides[side] = is_divided(start, end);
        count += u32(sides[side]);
    }
    if count == 0u {
        return FINISHED;
    }
    if atomicLoad(&work[ROUND]) >= MOST_ROUNDS {
        atomicAdd(&work[UNFINISHED], 1u);
        return LEFT_OVER;
    }
    // Turned so that with one divided side this is opposite to the first corner, with two the other one is.
    var first = 0u;
    for (var side = 0u; side < 3u; side++) {
        if (count == 1u && sides[side]) || (count == 2u && !sides[side]) {
            first = side;
        }
    }
    let a = piece.corners[first];
    let b = piece.corners[(first + 1u) % 3u];
    let c = piece.corners[(first + 2u) % 3u];
    var middles = vec3u(NONE);
    var has_room = true;
    for (var side = 0u; side < 3u; side++) {
        let turned_side = (first + side) % 3u;
        if sides[turned_side] {
            let start = piece.corners[(turned_side + 1u) % 3u];
            let end = piece.corners[(turned_side + 2u) % 3u];
            middles[side] = middle_of(start, end, piece.source);
            has_room = has_room && middles[side] != NONE;
        }
    }
    var place = reflection.most_pieces;
    if has_room {
        place = atomicAdd(&work[PIECES_NEXT], count + 1u);
    }
    if place + count + 1u > reflection.most_pieces {
        atomicStore(&work[IS_FULL], 1u);
        return LEFT_OVER;
    }
    if count == 1u {
        next_pieces[place] = Piece(vec3u(a, b, middles.x), piece.source);
        next_pieces[place + 1u] = Piece(vec3u(a, middles.x, c), piece.source);
        return REPLACED;
    }
    // The top, and two triangles of what is below; all three if there are so many.
    next_pieces[place] = Piece(vec3u(a, middles.z, middles.y), piece.source);
    if count == 2u {
        next_pieces[place + 1u] = Piece(vec3u(middles.z, b, middles.y), piece.source);
        next_pieces[place + 2u] = Piece(vec3u(middles.y, b, c), piece.source);
    } else {
        next_pieces[place + 1u] = Piece(vec3u(middles.z, b, middles.x), piece.source);
        next_pieces[place + 2u] = Piece(vec3u(middles.y, middles.x, c), piece.source);
        next_pieces[place + 3u] = Piece(middles, piece.source);
    }
    return REPLACED;
}

// Before the first piece of a reflector.
@compute @workgroup_size(1)
fn begin() {
    atomicStore(&work[POINTS], reflection.vertex_count);
    atomicStore(&work[APPEARANCES], 0u);
    atomicStore(&work[ROUND], 0u);
    atomicStore(&work[PIECES_NEXT], 0u);
    atomicStore(&work[DRAWN_BEFORE], atomicLoad(&work[DRAWN]));
    atomicStore(&work[IS_FULL], 0u);
}

// After the last: what it is drawn with; nothing where there was no room for all: tiles follow its rays.
@compute @workgroup_size(1)
fn end() {
    let before = atomicLoad(&work[DRAWN_BEFORE]);
    let is_full = atomicLoad(&work[IS_FULL]) != 0u;
    let count = select(atomicLoad(&work[DRAWN]) - before, 0u, is_full);
    atomicStore(&work[DRAWN], before + count);
    atomicAdd(&work[LEFT_REFLECTORS], u32(is_full));
    let arguments = ARGUMENTS_AT + 4u * reflection.number;
    atomicStore(&work[arguments], count * 3u);
    atomicStore(&work[arguments + 1u], 1u);
    atomicStore(&work[arguments + 2u], before * 3u);
    atomicStore(&work[arguments + 3u], 0u);
    let own = select(reflection.own_vertices.y - reflection.own_vertices.x, 0u, reflection.shows_itself != 0u);
    let made = min(atomicLoad(&work[POINTS]), reflection.most_points);
    atomicAdd(&work[PROJECTED], made - own);
}
