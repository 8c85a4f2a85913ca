// Which triangle each ray of a tile hits: a beam about all of its rays finds the triangles that they can hit in the
// hierarchy, and every ray is tested against those that beams about blocks of the tile let through.
//
// Rays and triangles are in the tile's frame: its axes are the mean direction and two across it, its origin is the mean
// of where rays start. A ray is there (ox, oy, 0) + z (sx, sy, 1) from its start on.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "light/hierarchy.wgsl"
//#include "tiles/cells.wgsl"
//#include "tiles/work.wgsl"
//#include "tiles/path_ray.wgsl"

// Threads of a tile: one a cell.
const THREADS = 256u;

// Every tile has this many blocks, each with a beam of its own.
const BLOCKS = 16u;
// The most leaves of the hierarchy that a tile looks at, and how many triangles each has.
const MAX_LEAVES = 384u;
const LEAF_SIZE = 4u;
// The most nodes that wait, and triangles in a tile's beam.
const MAX_WAITING = 512u;
const MAX_TRIANGLES = 768u;
// Triangles that blocks look at at a time: what rays ask of each is found once, in `scratch`.
const BATCH = 64u;
const WORDS = 2u;
// Rays of tiles that spread further from the mean are traced.
const LEAST_COSINE_TO_MEAN = 0.25;
// Beams are wider by this share of the scene's size, for rounding.
const ROUNDING = 2e-6;

var<workgroup> scratch: array<vec4f, 512>;
// The numbers and objects of the triangles of a batch.
var<workgroup> batch_ids: array<vec2u, BATCH>;
// Two values of all blocks, the first of each before the second ones; and the two of the tile.
var<workgroup> of_blocks: array<vec4f, 32>;
var<workgroup> total: array<vec4f, 2>;
var<workgroup> leaves: array<u32, MAX_LEAVES>;
var<workgroup> waiting: array<u32, MAX_WAITING>;
var<workgroup> places: array<u32, MAX_TRIANGLES>;
var<workgroup> leaf_count: atomic<u32>;
var<workgroup> triangle_count: atomic<u32>;
var<workgroup> waiting_count: atomic<u32>;
var<workgroup> to_do: u32;
var<workgroup> is_failed: u32;
// The triangles of a batch that each block can see: a bit each.
var<workgroup> seen_by_block: array<atomic<u32>, BLOCKS * WORDS>;
var<workgroup> pair_count: atomic<u32>;
// Blocks that have rays to be traced.
var<workgroup> is_traced: array<atomic<u32>, 16>;
var<workgroup> tile_of_group: u32;

// Four rays in the tile's frame.
struct Rays {
    ox: vec4f,
    oy: vec4f,
    sx: vec4f,
    sy: vec4f,
    // Where they start.
    start: vec4f,
    // The length of (sx, sy, 1).
    length: vec4f,
}

// Sums or minima of two values over each block, into `of_blocks`, and over the tile, into `total`.
fn gather_over_tile(thread: u32, first: vec4f, second: vec4f, is_first_sum: bool, is_second_sum: bool) {
    scratch[thread] = first;
    scratch[THREADS + thread] = second;
    workgroupBarrier();
    let count = THREADS / BLOCKS;
    for (var item = thread; item < 2u * BLOCKS; item += THREADS) {
        let is_sum = select(is_second_sum, is_first_sum, item < BLOCKS);
        var value = scratch[item * count];
        for (var index = item * count + 1u; index < (item + 1u) * count; index++) {
            value = select(min(value, scratch[index]), value + scratch[index], is_sum);
        }
        of_blocks[item] = value;
    }
    workgroupBarrier();
    if thread < 2u {
        let is_sum = select(is_second_sum, is_first_sum, thread == 0u);
        var value = of_blocks[thread * BLOCKS];
        for (var index = thread * BLOCKS + 1u; index < (thread + 1u) * BLOCKS; index++) {
            value = select(min(value, of_blocks[index]), value + of_blocks[index], is_sum);
        }
        total[thread] = value;
    }
    workgroupBarrier();
}

// The tile's frame: its origin, and unit vectors.
struct TileFrame {
    origin: vec3f,
    across: vec3f,
    along: vec3f,
    forward: vec3f,
}

fn in_frame(tile: TileFrame, position: vec3f) -> vec3f {
    let relative = position - tile.origin;
    return vec3f(dot(relative, tile.across), dot(relative, tile.along), dot(relative, tile.forward));
}

// A part of space that holds some rays: beyond a plane across them, and on the inner side of four planes. Bounds are
// the least u and v, and the least -u and -v, at the depth where rays start and at one beyond all that they can hit; as
// rays are straight, the planes through both hold them between.
struct Beam {
    near: vec4f,
    slope: vec4f,
    start: f32,
}

fn beam(near: vec4f, far: vec4f, start: f32, end: f32) -> Beam {
    return Beam(near - ROUNDING * frame.extent, (far - near) / (end - start), start);
}

// How far a point in the frame is on the inner sides.
fn inside(bounds: Beam, point: vec3f) -> vec4f {
    return vec4f(point.xy, -point.xy) - bounds.near - bounds.slope * (point.z - bounds.start);
}

// A child of a node of the hierarchy.
struct WideChild {
    low: vec3f,
    code: u32,
    high: vec3f,
    unused: u32,
}

const WIDTH = 8u;
const WIDE_CHILD_TEXELS = 2u;

fn wide_child_of(index: u32) -> WideChild {
    let first = textureLoad(wide_table, row_of(index * WIDE_CHILD_TEXELS), 0);
    let second = textureLoad(wide_table, row_of(index * WIDE_CHILD_TEXELS + 1u), 0);
    return WideChild(bitcast<vec3f>(first.xyz), first.w, bitcast<vec3f>(second.xyz), 0u);
}

// True if a box may hold a part of a beam.
fn may_hold(child: WideChild, bounds: Beam, tile: TileFrame) -> bool {
    let low = child.low - tile.origin;
    let high = child.high - tile.origin;
    let forward = tile.forward;
    let farthest = select(low, high, forward >= vec3f(0.0));
    let is_beyond = dot(farthest, forward) >= bounds.start - ROUNDING * frame.extent;
    // For each side of the beam the corner of the box that lies furthest within.
    let normals = array<vec3f, 4>(
        tile.across - forward * bounds.slope.x,
        tile.along - forward * bounds.slope.y,
        -tile.across - forward * bounds.slope.z,
        -tile.along - forward * bounds.slope.w,
    );
    let furthest = vec4f(
        dot(select(low, high, normals[0] >= vec3f(0.0)), normals[0]),
        dot(select(low, high, normals[1] >= vec3f(0.0)), normals[1]),
        dot(select(low, high, normals[2] >= vec3f(0.0)), normals[2]),
        dot(select(low, high, normals[3] >= vec3f(0.0)), normals[3]),
    );
    return is_beyond && all(furthest >= bounds.near - bounds.slope * bounds.start);
}

// True if all triangles of a leaf belong to an object.
fn is_all_of(leaf: u32, object: u32) -> bool {
    let first = (leaf & ~LEAF) >> 3u;
    var is_all = true;
    for (var place = first; place < first + (leaf & 7u); place++) {
        is_all = is_all && leaf_triangle_of(place).object == object;
    }
    return is_all;
}

// Finds the leaves of the hierarchy that a beam meets; none that belong to an object that all rays have left for good.
fn walk(thread: u32, bounds: Beam, tile: TileFrame, left: u32) {
    if thread == 0u {
        atomicStore(&leaf_count, 0u);
        atomicStore(&triangle_count, 0u);
        waiting[0] = 0u;
        to_do = 1u;
        is_failed = 0u;
    }
    loop {
        let size = workgroupUniformLoad(&to_do);
        if size == 0u {
            break;
        }
        // A thread a child.
        let taken = min(size, THREADS / WIDTH);
        if thread == 0u {
            atomicStore(&waiting_count, size - taken);
        }
        var index = 0u;
        if thread / WIDTH < taken {
            index = waiting[size - taken + thread / WIDTH];
        }
        workgroupBarrier();
        if thread / WIDTH < taken {
            let child = wide_child_of(index * WIDTH + thread % WIDTH);
            if may_hold(child, bounds, tile) {
                if (child.code & LEAF) == 0u {
                    let place = atomicAdd(&waiting_count, 1u);
                    if place < MAX_WAITING {
                        waiting[place] = child.code;
                    }
                } else if !is_all_of(child.code, left) {
                    let place = atomicAdd(&leaf_count, 1u);
                    if place < MAX_LEAVES {
                        leaves[place] = child.code;
                    }
                }
            }
        }
        workgroupBarrier();
        if thread == 0u {
            let still = atomicLoad(&waiting_count);
            let is_too_long = still > MAX_WAITING || atomicLoad(&leaf_count) > MAX_LEAVES;
            is_failed = select(0u, 1u, is_too_long);
            to_do = select(still, 0u, is_too_long);
        }
    }
}

// The corners of a triangle in the tile's frame.
struct Corners {
    a: vec3f,
    b: vec3f,
    c: vec3f,
}

fn corners_in_frame(triangle: LeafTriangle, tile: TileFrame) -> Corners {
    return Corners(in_frame(tile, triangle.a), in_frame(tile, triangle.b), in_frame(tile, triangle.c));
}

// True if a triangle may meet rays of a beam.
fn is_met(corners: Corners, bounds: Beam) -> bool {
    let farthest = max(corners.a.z, max(corners.b.z, corners.c.z));
    let best = max(inside(bounds, corners.a), max(inside(bounds, corners.b), inside(bounds, corners.c)));
    return all(best >= vec4f(0.0)) && farthest >= bounds.start - ROUNDING * frame.extent;
}

// Finds the triangles of all leaves that a beam meets; none of an object that all rays have left for good.
fn collect(thread: u32, bounds: Beam, tile: TileFrame, left: u32) {
    let count = atomicLoad(&leaf_count) * LEAF_SIZE;
    for (var index = thread; index < count; index += THREADS) {
        let leaf = leaves[index / LEAF_SIZE];
        let in_leaf = index % LEAF_SIZE;
        let place = ((leaf & ~LEAF) >> 3u) + in_leaf;
        if in_leaf >= (leaf & 7u) {
            continue;
        }
        let triangle = leaf_triangle_of(place);
        if triangle.object != left && is_met(corners_in_frame(triangle, tile), bounds) {
            let found = atomicAdd(&triangle_count, 1u);
            if found < MAX_TRIANGLES {
                places[found] = place;
            }
        }
    }
    workgroupBarrier();
    if thread == 0u && atomicLoad(&triangle_count) > MAX_TRIANGLES {
        is_failed = 1u;
    }
}

// The first hits of four rays.
struct Best {
    id: vec4u,
    depth: vec4f,
}

struct OwnRules {
    object: vec4u,
    none: vec4<bool>,
    outside: vec4<bool>,
    from_behind: vec4f,
}

// Where a winding is opposite to the normals, the object's number in a batch has this bit.
const TURNED_OBJECT = 0x80000000u;

// Keeps an edge of a triangle of a batch: its moment and direction (its Pluecker coordinates, twice), and two numbers
// more. Both triangles beside it have the same with opposite sign, to the last bit.
fn keep_edge(item: u32, edge: u32, p: vec3f, q: vec3f, more: vec2f) {
    scratch[2u * edge * BATCH + item] = vec4f(cross(p + q, q - p), more.x);
    scratch[(2u * edge + 1u) * BATCH + item] = vec4f(2.0 * (q - p), more.y);
}

// Keeps what rays ask of a triangle: edges, the normal and its product with a corner, the number and the object.
fn keep(item: u32, triangle: LeafTriangle, corners: Corners) {
    let normal = cross(corners.b - corners.a, corners.c - corners.a);
    keep_edge(item, 0u, corners.b, corners.c, vec2f(normal.x, dot(normal, corners.a)));
    keep_edge(item, 1u, corners.c, corners.a, vec2f(normal.y, 0.0));
    keep_edge(item, 2u, corners.a, corners.b, vec2f(normal.z, 0.0));
    var goes_on = (triangle.flags & (REFLECTS | REFRACTS)) * (HIT_REFLECTS / REFLECTS);
    if HAS_LOBES && (triangle.flags & SPREADS) != 0u {
        goes_on = HIT_REFLECTS | HIT_BLURRED;
    }
    // Holes have to be looked up.
    let has_holes = HAS_HOLES && (triangle.flags & MAY_HAVE_HOLES) != 0u;
    let id = select((triangle.triangle + 1u) | goes_on, UNRESOLVED, has_holes);
    let turned = select(0u, TURNED_OBJECT, (triangle.flags & TURNED) != 0u);
    batch_ids[item] = vec2u(id, triangle.object | turned);
}

// On which side of an edge rays pass: the volume that each spans with it.
fn edge_side(moment: vec3f, edge: vec3f, rays: Rays, mz: vec4f) -> vec4f {
    return moment.x * rays.sx + moment.y * rays.sy + moment.z + edge.x * rays.oy - edge.y * rays.ox + edge.z * mz;
}

// Tests four rays against a triangle of a batch.
fn test(item: u32, rays: Rays, mz: vec4f, own: OwnRules, best: Best) -> Best {
    let moment0 = scratch[item];
    let edge0 = scratch[BATCH + item];
    let moment1 = scratch[2u * BATCH + item];
    let edge1 = scratch[3u * BATCH + item];
    let moment2 = scratch[4u * BATCH + item];
    let edge2 = scratch[5u * BATCH + item];
    let e0 = edge_side(moment0.xyz, edge0.xyz, rays, mz);
    let e1 = edge_side(moment1.xyz, edge1.xyz, rays, mz);
    let e2 = edge_side(moment2.xyz, edge2.xyz, rays, mz);
    let least = min(e0, min(e1, e2));
    let greatest = max(e0, max(e1, e2));
    let normal = vec3f(moment0.w, moment1.w, moment2.w);
    let cosine = normal.x * rays.sx + normal.y * rays.sy + normal.z;
    let depth = (edge0.w - normal.x * rays.ox - normal.y * rays.oy) / cosine - rays.start;
    let ids = batch_ids[item];
    let id = vec4u(ids.x);
    // Along its outer normal a ray meets a triangle from within.
    let is_turned = vec4<bool>((ids.y & TURNED_OBJECT) != 0u);
    let from_within = (cosine > vec4f(0.0)) != is_turned;
    let is_own = vec4u(ids.y & ~TURNED_OBJECT) == own.object;
    let allowed = select(
        vec4<bool>(true),
        !own.none & ((from_within != own.outside) | (depth >= own.from_behind)),
        is_own,
    );
    let key = select(depth, depth * (1.0 - TOUCHING), is_own & !own.outside);
    let covered = ((least >= vec4f(0.0)) | (greatest <= vec4f(0.0))) & (greatest != least);
    let nearer = (key < best.depth) | ((key == best.depth) & (id < best.id));
    let is_hit = covered & allowed & (depth >= vec4f(0.0)) & nearer;
    return Best(select(best.id, id, is_hit), select(best.depth, key, is_hit));
}

// The rays of a block are traced.
fn pass_on(origin: vec2u, block: u32) {
    let place = atomicAdd(&work[TRACED], 1u);
    atomicStore(&work[tiling.traced_queue + place], packed(origin + cell_in_tile(block * (THREADS / BLOCKS))));
}

@compute @workgroup_size(THREADS)
fn cover(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) thread: u32) {
    if thread == 0u {
        tile_of_group = atomicLoad(&work[tiling.queue + group.x]);
    }
    let origin = unpacked(workgroupUniformLoad(&tile_of_group));
    let cell = origin + cell_in_tile(thread);
    let is_in_picture = all(cell < frame.cells);

    var own: OwnRules;
    var active_rays = vec4<bool>(false);
    var origins: array<vec3f, RAYS>;
    var directions: array<vec3f, RAYS>;
    var sum_of_origins = vec4f(0.0);
    var sum_of_directions = vec4f(0.0);
    var chain: Chain;
    let index = hit_index(cell, tiling.events, tiling.kinds);
    var known = vec4u(UNRESOLVED);
    if is_in_picture {
        chain = chain_of(cell);
        if tiling.some_known != 0u {
            known = hits[index];
        }
    }
    for (var ray = 0u; ray < RAYS; ray++) {
        let last = path_ray(cell, ray, chain);
        if last.is_active && known[ray] == UNRESOLVED {
            active_rays[ray] = true;
            origins[ray] = last.ray.origin;
            directions[ray] = last.ray.direction;
            own.object[ray] = last.own.object;
            own.none[ray] = last.own.none;
            own.outside[ray] = last.own.outside;
            own.from_behind[ray] = last.own.from_behind;
            sum_of_origins += vec4f(last.ray.origin, 1.0);
            sum_of_directions += vec4f(last.ray.direction, 0.0);
        }
    }
    gather_over_tile(thread, sum_of_origins, sum_of_directions, true, true);
    let count = total[0].w;
    var tile: TileFrame;
    tile.origin = total[0].xyz / max(count, 1.0);
    tile.forward = normalize_or(total[1].xyz, vec3f(0.0, 0.0, 1.0));
    let axes = axes_across(tile.forward);

    // Rays in the frame, across it along any two axes.
    var rays: Rays;
    rays.length = vec4f(1.0);
    var least = vec4f(FAR);
    var moments = vec4f(0.0);
    let end = frame.extent;
    for (var ray = 0u; ray < RAYS; ray++) {
        if active_rays[ray] {
            let relative = origins[ray] - tile.origin;
            let cosine = dot(directions[ray], tile.forward);
            let slope = vec2f(dot(directions[ray], axes[0]), dot(directions[ray], axes[1])) / cosine;
            let start = dot(relative, tile.forward);
            let offset = vec2f(dot(relative, axes[0]), dot(relative, axes[1])) - slope * start;
            rays.ox[ray] = offset.x;
            rays.oy[ray] = offset.y;
            rays.sx[ray] = slope.x;
            rays.sy[ray] = slope.y;
            rays.start[ray] = start;
            rays.length[ray] = 1.0 / cosine;
            // An object that rays can meet again counts as none.
            let object = select(-1.0, f32(own.object[ray]), own.none[ray]);
            least = min(least, vec4f(start, cosine, object, -object));
            let third = offset + slope * (end / 3.0);
            moments += vec4f(third.x * third.x, third.x * third.y, third.y * third.y, 0.0);
        }
    }
    gather_over_tile(thread, least, moments, false, true);
    let start = total[0].x;
    let least_cosine = total[0].y;
    let is_one = total[0].z >= 0.0 && total[0].z == -total[0].w;
    let left = select(NONE, u32(max(total[0].z, 0.0)), is_one);

    // Across the rays the axes follow how far they spread.
    let angle = 0.5 * atan2(2.0 * total[1].y, total[1].x - total[1].z);
    let turn = select(vec2f(1.0, 0.0), vec2f(cos(angle), sin(angle)), abs(angle) < 4.0);
    tile.across = axes[0] * turn.x + axes[1] * turn.y;
    tile.along = axes[1] * turn.x - axes[0] * turn.y;
    let turned = vec4f(rays.ox * turn.x + rays.oy * turn.y);
    rays.oy = rays.oy * turn.x - rays.ox * turn.y;
    rays.ox = turned;
    let turned_slope = vec4f(rays.sx * turn.x + rays.sy * turn.y);
    rays.sy = rays.sy * turn.x - rays.sx * turn.y;
    rays.sx = turned_slope;

    var near = vec4f(FAR);
    var far = vec4f(FAR);
    for (var ray = 0u; ray < RAYS; ray++) {
        if active_rays[ray] {
            let offset = vec2f(rays.ox[ray], rays.oy[ray]);
            let slope = vec2f(rays.sx[ray], rays.sy[ray]);
            let first = offset + slope * start;
            let last = offset + slope * end;
            near = min(near, vec4f(first, -first));
            far = min(far, vec4f(last, -last));
        }
    }
    gather_over_tile(thread, near, far, false, false);
    let whole = beam(total[0], total[1], start, end);
    let block = thread / (THREADS / BLOCKS);
    workgroupBarrier();
    if thread < BLOCKS {
        // Beams in place of bounds.
        let of_block = beam(of_blocks[thread], of_blocks[BLOCKS + thread], start, end);
        of_blocks[thread] = of_block.near;
        of_blocks[BLOCKS + thread] = of_block.slope;
        atomicStore(&is_traced[thread], 0u);
    }
    if thread == 0u {
        atomicAdd(&work[FOLLOWED_TILES], 1u);
        to_do = select(0u, 1u, least_cosine >= LEAST_COSINE_TO_MEAN && count > 0.0);
    }
    if workgroupUniformLoad(&to_do) != 0u {
        walk(thread, whole, tile, left);
        if workgroupUniformLoad(&is_failed) == 0u {
            collect(thread, whole, tile, left);
        }
    } else if thread == 0u {
        is_failed = select(0u, 1u, count > 0.0);
        atomicStore(&triangle_count, 0u);
    }
    if workgroupUniformLoad(&is_failed) != 0u {
        if is_in_picture {
            hits[index] = known;
        }
        // Blocks without rays have no bounds.
        if thread < BLOCKS && of_blocks[thread].x < 0.5 * FAR {
            pass_on(origin, thread);
        }
        return;
    }
    if thread == 0u {
        to_do = atomicLoad(&triangle_count);
        atomicAdd(&work[CANDIDATES], to_do);
        atomicStore(&pair_count, 0u);
    }
    let triangles = workgroupUniformLoad(&to_do);
    own.from_behind /= rays.length;
    let mz = rays.ox * rays.sy - rays.oy * rays.sx;
    var best = Best(vec4u(0u), vec4f(FAR));
    let in_batch = thread % BATCH;
    // Each triangle is compared with the blocks by some threads.
    let of_thread = BLOCKS / (THREADS / BATCH);
    var pairs = 0u;
    for (var first = 0u; first < triangles; first += BATCH) {
        if thread < BLOCKS * WORDS {
            atomicStore(&seen_by_block[thread], 0u);
        }
        workgroupBarrier();
        if first + in_batch < triangles {
            let triangle = leaf_triangle_of(places[first + in_batch]);
            let corners = corners_in_frame(triangle, tile);
            if thread < BATCH {
                keep(in_batch, triangle, corners);
            }
            for (var index = 0u; index < of_thread; index++) {
                let other = thread / BATCH * of_thread + index;
                if is_met(corners, Beam(of_blocks[other], of_blocks[BLOCKS + other], start)) {
                    atomicOr(&seen_by_block[other * WORDS + in_batch / 32u], 1u << (in_batch % 32u));
                }
            }
        }
        workgroupBarrier();
        for (var word = 0u; word < WORDS; word++) {
            var bits = atomicLoad(&seen_by_block[block * WORDS + word]);
            pairs += countOneBits(bits);
            while bits != 0u {
                let item = word * 32u + firstTrailingBit(bits);
                bits &= bits - 1u;
                best = test(item, rays, mz, own, best);
            }
        }
        workgroupBarrier();
    }
    if thread % (THREADS / BLOCKS) == 0u {
        atomicAdd(&pair_count, pairs);
    }
    let result = select(known, best.id, active_rays);
    if is_in_picture {
        hits[index] = result;
        if any(active_rays & (result == vec4u(UNRESOLVED))) {
            atomicStore(&is_traced[block], 1u);
        }
    }
    workgroupBarrier();
    if thread == 0u {
        atomicAdd(&work[PAIRS], atomicLoad(&pair_count));
    }
    if thread < BLOCKS && atomicLoad(&is_traced[thread]) != 0u {
        pass_on(origin, thread);
    }
}
