// The work of tiles: which of them have rays to follow.

// What a pass of tiles works on.
struct Tiling {
    // Events of the path before its last ray, and their kinds.
    events: u32,
    kinds: u32,
    // The place of the level of tiles in the counters; of its queue, and of that of the next level.
    level: u32,
    queue: u32,
    next_queue: u32,
    // Of tiles that are shaded path by path; NONE: they are known already.
    shade_queue: u32,
    // Of sixteen cells each whose rays are traced.
    traced_queue: u32,
    unused: u32,
}

// Cells along a side of the largest tiles.
const LARGEST_TILE = 16u;
// The level after the smallest tiles: those whose rays are traced.
const TRACED = 3u;
// Counters before the queues: of tiles that wait, a level; then, since the picture began, of tiles a level, of triangles
// that tiles looked at, and of these times the blocks that looked at them; of tiles to be shaded, since the band began.
const TILES = 4u;
const CANDIDATES = 8u;
const PAIRS = 9u;
const SHADED = 12u;

@group(2) @binding(0) var<storage, read_write> hits: array<vec4u>;
@group(2) @binding(1) var<storage, read_write> work: array<atomic<u32>>;
@group(2) @binding(2) var<uniform> tiling: Tiling;

// A tile's first cell in one number.
fn packed(cell: vec2u) -> u32 {
    return cell.x | (cell.y << 16u);
}

fn unpacked(tile: u32) -> vec2u {
    return vec2u(tile & 0xffffu, tile >> 16u);
}

// Cells in the order of blocks: bits of the row and the column by turns.
fn cell_in_tile(thread: u32) -> vec2u {
    var bits = vec2u(thread, thread >> 1u) & vec2u(0x55u);
    bits = (bits | (bits >> vec2u(1u))) & vec2u(0x33u);
    return (bits | (bits >> vec2u(2u))) & vec2u(0x0fu);
}
