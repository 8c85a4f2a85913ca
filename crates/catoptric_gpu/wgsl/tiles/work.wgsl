// The work of tiles: which of them have rays to follow.

// The path and the queues that a pass of tiles works on.
struct Tiling {
    // Events of the path before its last ray, and their kinds.
    events: u32,
    kinds: u32,
    // The places of the queues: of tiles, of blocks of sixteen cells whose rays are traced, and of tiles that are
    // shaded path by path (NONE: they are known already).
    queue: u32,
    traced_queue: u32,
    shade_queue: u32,
    // Not 0: some rays' hits are known, and the others are UNRESOLVED.
    some_known: u32,
    unused1: u32,
    unused2: u32,
}

// Cells along a side of a tile.
const TILE = 16u;
// Counters before the queues: of tiles and of blocks to be traced, a path; of tiles to be shaded, a band; and in a
// picture of tiles, of blocks, of triangles that beams met, and of those times the blocks that looked at them.
const WAITING_TILES = 0u;
const TRACED = 1u;
const SHADED = 4u;
const FOLLOWED_TILES = 5u;
const TRACED_BLOCKS = 6u;
const CANDIDATES = 7u;
const PAIRS = 8u;

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
