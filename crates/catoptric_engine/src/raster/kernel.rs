//! The inner loop: coverage and depth of triangles over the samples of a tile, eight samples at a time.
//!
//! The loop is compiled for several instruction sets; the one to run is chosen when the program runs. All of them do
//! the same operations in the same order, so results are the same bit for bit.
//!
//! Edge functions are integers and exact. Samples lie on sixteenths of a pixel, so an edge function in units of
//! 1/256 px is divided by 16 (rounding down, which keeps its sign); within a block of 8 x 8 pixels it then changes by
//! less than 2^31 for any triangle within the guard band.

use super::samples::Pattern;
use super::setup::{SUBPIXELS, SetupTriangle};
use bytemuck::{Pod, Zeroable};
use catoptric_core::math::lanes::{LANES, bits_of};

/// Width and height of a block, in pixels.
pub const BLOCK: usize = 8;
/// Width and height of a tile, in pixels.
pub const TILE: usize = 32;
/// Blocks along a side of a tile.
pub(super) const TILE_BLOCKS: usize = TILE / BLOCK;
/// The id of a sample that shows nothing.
pub const EMPTY: u32 = u32::MAX;

/// Eight keys of samples.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Keys(pub [f32; LANES]);

/// Eight ids of samples.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct Ids(pub [u32; LANES]);

/// Groups of samples in a tile. Blocks follow each other row by row, in them the pixels row by row.
pub(super) const fn groups_in_tile(samples: usize) -> usize {
    TILE * TILE * samples / LANES
}

/// A tile of the picture.
#[derive(Clone, Copy, Debug)]
pub struct TilePlace {
    /// The tile's first pixel: column and row.
    pub pixel: [i32; 2],
    /// The same from the picture's centre.
    pub from_center: [i32; 2],
}

/// The pixels of a tile in which triangles may be drawn.
#[derive(Clone, Copy)]
pub struct StencilMask<'a> {
    /// A label a sample.
    pub(super) labels: &'a [Ids],
    /// Draw where the label is this.
    pub(super) wanted: u32,
    /// For each block the labels in it, as bits (label modulo 64).
    pub(super) in_blocks: &'a [u64; TILE_BLOCKS * TILE_BLOCKS],
}

/// The samples of a tile in one layer.
pub struct LayerSamples<'a> {
    /// The key of every sample: larger ones are nearer.
    pub keys: &'a mut [Keys],
    /// The id of every sample's triangle, or [`EMPTY`].
    pub ids: &'a mut [Ids],
}

/// Draws those triangles of `setup` that `indices` names and that are not alpha tested, in order.
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
pub fn draw_triangles(
    pattern: &Pattern,
    place: &TilePlace,
    setup: &[SetupTriangle],
    indices: &[u32],
    stencil: Option<StencilMask<'_>>,
    target: &mut LayerSamples<'_>,
) {
    draw_triangles_portably(pattern, place, setup, indices, stencil, target);
}

/// [`draw_triangles`] for the instruction set of the caller.
#[inline(always)]
pub fn draw_triangles_portably(
    pattern: &Pattern,
    place: &TilePlace,
    setup: &[SetupTriangle],
    indices: &[u32],
    stencil: Option<StencilMask<'_>>,
    target: &mut LayerSamples<'_>,
) {
    for &index in indices {
        let triangle = &setup[index as usize];
        if triangle.alpha_tested {
            continue;
        }
        match stencil {
            None => draw::<false>(pattern, place, triangle, None, target),
            Some(_) => draw::<true>(pattern, place, triangle, stencil, target),
        }
    }
}

/// An edge: `x * X + y * Y + constant >= 0` inside, with X and Y in sixteenths of a pixel from the tile's corner.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Edge {
    x: i32,
    y: i32,
    constant: i64,
}

impl Edge {
    /// The edge from `from` to `to`. Samples on it belong to the triangle if it is a top or a left edge.
    #[inline(always)]
    fn new(from: [i32; 2], to: [i32; 2], place: &TilePlace) -> Self {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        // With y down and the inside on the positive side, left edges go up and top edges go to the right.
        let included = dy < 0 || (dy == 0 && dx > 0);
        let corner = place.from_center.map(|pixel| pixel as i64 * SUBPIXELS as i64);
        let at_corner = dx as i64 * (corner[1] - from[1] as i64) - dy as i64 * (corner[0] - from[0] as i64);
        let biased = at_corner - i64::from(!included);
        Self { x: -dy, y: dx, constant: biased >> 4 }
    }

    /// The smallest and largest change over `pixels` pixels to the right and down, at samples.
    #[inline(always)]
    fn change_over(&self, pixels: i64) -> [i64; 2] {
        let last = pixels * 16 - 1;
        let (x, y) = (self.x as i64 * last, self.y as i64 * last);
        [x.min(0) + y.min(0), x.max(0) + y.max(0)]
    }

    #[inline(always)]
    pub(super) fn at(&self, x: i64, y: i64) -> i64 {
        self.x as i64 * x + self.y as i64 * y + self.constant
    }
}

/// The three edges of a triangle, from the corner of a tile.
#[inline(always)]
pub(super) fn edges(triangle: &SetupTriangle, place: &TilePlace) -> [Edge; 3] {
    let [a, b, c] = triangle.corners;
    [Edge::new(a, b, place), Edge::new(b, c, place), Edge::new(c, a, place)]
}

/// Returns true if a triangle may cover a sample of a tile.
pub(super) fn touches_tile(triangle: &SetupTriangle, place: &TilePlace) -> bool {
    edges(triangle, place).iter().all(|edge| edge.constant + edge.change_over(TILE as i64)[1] >= 0)
}

/// First and last pixel of a triangle's extent in a tile; nothing if they do not overlap.
#[inline(always)]
pub(super) fn overlap(range: [u16; 2], first_pixel: i32) -> Option<[usize; 2]> {
    let first = (range[0] as i32 - first_pixel).max(0);
    let last = (range[1] as i32 - first_pixel).min(TILE as i32 - 1);
    (first <= last).then_some([first as usize, last as usize])
}

/// The differences between the lanes of a group, for a triangle.
struct LanePattern {
    edges: [[i32; LANES]; 3],
    key: [f32; LANES],
}

#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
fn lane_pattern(pattern: &Pattern, half: usize, edges: &[Edge; 3], key_step: [f32; 2]) -> LanePattern {
    let (x, y) = (&pattern.x[half], &pattern.y[half]);
    let mut lanes = LanePattern { edges: [[0; LANES]; 3], key: [0.0; LANES] };
    for i in 0..LANES {
        lanes.key[i] = key_step[0] * (x[i] as f32 * (1.0 / 16.0)) + key_step[1] * (y[i] as f32 * (1.0 / 16.0));
    }
    for (values, edge) in lanes.edges.iter_mut().zip(edges) {
        for i in 0..LANES {
            values[i] = edge.x.wrapping_mul(x[i]).wrapping_add(edge.y.wrapping_mul(y[i]));
        }
    }
    lanes
}

#[inline(always)]
fn draw<const STENCIL: bool>(
    pattern: &Pattern,
    place: &TilePlace,
    triangle: &SetupTriangle,
    stencil: Option<StencilMask<'_>>,
    target: &mut LayerSamples<'_>,
) {
    let Some(columns) = overlap(triangle.columns, place.pixel[0]) else { return };
    let Some(rows) = overlap(triangle.rows, place.pixel[1]) else { return };
    let edges = edges(triangle, place);
    let [key_x, key_y, key_constant] = triangle.key_plane;
    let key_corner = key_constant + key_x * place.from_center[0] as f64 + key_y * place.from_center[1] as f64;
    let (key_step_x, key_step_y) = (key_x as f32, key_y as f32);
    let lanes = [
        lane_pattern(pattern, 0, &edges, [key_step_x, key_step_y]),
        lane_pattern(pattern, pattern.halves - 1, &edges, [key_step_x, key_step_y]),
    ];
    let steps = ColumnSteps::new(&edges, key_step_x);
    let changes = edges.map(|edge| edge.change_over(BLOCK as i64));

    for block_y in rows[0] / BLOCK..=rows[1] / BLOCK {
        for block_x in columns[0] / BLOCK..=columns[1] / BLOCK {
            let block = block_y * TILE_BLOCKS + block_x;
            let (x0, y0) = ((block_x * BLOCK) as i64 * 16, (block_y * BLOCK) as i64 * 16);
            let mut bases = [0i32; 3];
            let (mut rejected, mut inside) = (false, true);
            for e in 0..3 {
                let value = edges[e].at(x0, y0);
                rejected |= value + changes[e][1] < 0;
                inside &= value + changes[e][0] >= 0;
                // The value may be too large if the whole block is inside: any that stays positive serves.
                bases[e] = value.min(i32::MAX as i64 - changes[e][1]) as i32;
            }
            if rejected {
                continue;
            }
            if let Some(mask) = stencil
                && STENCIL
                && mask.in_blocks[block] >> (mask.wanted & 63) & 1 == 0
            {
                continue;
            }
            let key = (key_corner + key_x * (block_x * BLOCK) as f64 + key_y * (block_y * BLOCK) as f64) as f32;
            let within = |range: [usize; 2], index: usize| {
                [range[0].max(index * BLOCK) - index * BLOCK, (range[1] - index * BLOCK).min(BLOCK - 1)]
            };
            let place = BlockPlace { block, columns: within(columns, block_x), rows: within(rows, block_y) };
            let plane = BlockPlane { bases, steps_y: edges.map(|edge| edge.y), key, key_step_y };
            if inside {
                draw_block::<STENCIL, false>(pattern, &place, &plane, &steps, &lanes, triangle, stencil, target);
            } else {
                draw_block::<STENCIL, true>(pattern, &place, &plane, &steps, &lanes, triangle, stencil, target);
            }
        }
    }
}

/// The change of edges and key from the first column of a block to each.
struct ColumnSteps {
    edges: [[i32; BLOCK]; 3],
    key: [f32; BLOCK],
    /// The smallest and largest change of each edge from a pixel's corner to its samples.
    over_pixel: [[i32; 2]; 3],
}

impl ColumnSteps {
    #[inline(always)]
    fn new(edges: &[Edge; 3], key_step: f32) -> Self {
        let over_pixel = edges.map(|edge| edge.change_over(1).map(|change| change as i32));
        let mut steps = Self { edges: [[0; BLOCK]; 3], key: [0.0; BLOCK], over_pixel };
        for column in 0..BLOCK {
            steps.key[column] = key_step * column as f32;
        }
        for (values, edge) in steps.edges.iter_mut().zip(edges) {
            for (column, value) in values.iter_mut().enumerate() {
                *value = edge.x.wrapping_mul(column as i32 * 16);
            }
        }
        steps
    }
}

/// The part of a block that a triangle may cover.
struct BlockPlace {
    block: usize,
    columns: [usize; 2],
    rows: [usize; 2],
}

/// Edges and key at the corner of a block, and their change from row to row: of edges a sixteenth of it.
struct BlockPlane {
    bases: [i32; 3],
    steps_y: [i32; 3],
    key: f32,
    key_step_y: f32,
}

/// Draws a triangle over a block. Without `EDGES` all of the block is inside of it.
#[allow(clippy::too_many_arguments)] // inlined; a struct would only hide what is loop-invariant
#[allow(clippy::needless_range_loop)] // the lanes of several arrays, for the vectoriser
#[inline(always)]
fn draw_block<const STENCIL: bool, const EDGES: bool>(
    pattern: &Pattern,
    place: &BlockPlace,
    plane: &BlockPlane,
    steps: &ColumnSteps,
    lanes: &[LanePattern; 2],
    triangle: &SetupTriangle,
    stencil: Option<StencilMask<'_>>,
    target: &mut LayerSamples<'_>,
) {
    let samples_log2 = pattern.samples_log2;
    // Pixels of a group, as bits, and groups of a pixel; one of the two is 1.
    let group_pixels = LANES >> samples_log2.min(LANES.trailing_zeros());
    let group_bits = (1u32 << group_pixels) - 1;
    let in_columns = (2u32 << place.columns[1]) - (1 << place.columns[0]);
    for row in place.rows[0]..=place.rows[1] {
        // Edges and key of the whole row, for each of its columns.
        let row_key = plane.key + plane.key_step_y * row as f32;
        let (mut row_keys, mut row_edges) = ([0.0; BLOCK], [[0i32; BLOCK]; 3]);
        for column in 0..BLOCK {
            row_keys[column] = row_key + steps.key[column];
        }
        // The columns whose pixels lie in the triangle in part at least, and those that do so as a whole.
        let (mut touched, mut inside) = (in_columns, in_columns);
        if EDGES {
            for e in 0..3 {
                let base = plane.bases[e].wrapping_add(plane.steps_y[e].wrapping_mul(row as i32 * 16));
                for column in 0..BLOCK {
                    row_edges[e][column] = base.wrapping_add(steps.edges[e][column]);
                }
            }
            let (mut touches, mut is_inside) = ([false; BLOCK], [false; BLOCK]);
            let [[low0, high0], [low1, high1], [low2, high2]] = steps.over_pixel;
            for column in 0..BLOCK {
                let [e0, e1, e2] = [row_edges[0][column], row_edges[1][column], row_edges[2][column]];
                let highest = e0.wrapping_add(high0) | e1.wrapping_add(high1) | e2.wrapping_add(high2);
                let lowest = e0.wrapping_add(low0) | e1.wrapping_add(low1) | e2.wrapping_add(low2);
                touches[column] = highest >= 0;
                is_inside[column] = lowest >= 0;
            }
            touched &= u32::from(bits_of(touches));
            inside = touched & u32::from(bits_of(is_inside));
        }
        let first = (place.block * BLOCK + row) << samples_log2;
        let range = first..first + (1 << samples_log2);
        let keys = &mut target.keys[range.clone()];
        let ids = &mut target.ids[range.clone()];
        let labels = match stencil {
            Some(mask) if STENCIL => &mask.labels[range],
            _ => &[],
        };
        let wanted = stencil.map_or(0, |mask| mask.wanted);
        while touched != 0 {
            let column = touched.trailing_zeros() as usize / group_pixels * group_pixels;
            let bits = group_bits << column;
            touched &= !bits;
            let whole = inside & bits == bits;
            let base = [row_edges[0][column % BLOCK], row_edges[1][column % BLOCK], row_edges[2][column % BLOCK]];
            let key = row_keys[column % BLOCK];
            let first = (column << samples_log2) / LANES;
            for half in 0..pattern.halves {
                let index = first + half;
                let (Some(keys), Some(ids)) = (keys.get_mut(index), ids.get_mut(index)) else { continue };
                let lane = &lanes[half & 1];
                let label = if STENCIL { labels.get(index).map(|l| &l.0) } else { None };
                if EDGES && !whole {
                    draw_group::<STENCIL, true>(base, key, lane, triangle, label, wanted, keys, ids);
                } else {
                    draw_group::<STENCIL, false>(base, key, lane, triangle, label, wanted, keys, ids);
                }
            }
        }
    }
}

/// Draws a triangle over eight samples.
#[allow(clippy::too_many_arguments)] // inlined; a struct would only hide what is loop-invariant
#[allow(clippy::needless_range_loop)] // the lanes of six arrays, for the vectoriser
#[inline(always)]
fn draw_group<const STENCIL: bool, const EDGES: bool>(
    base: [i32; 3],
    key: f32,
    lane: &LanePattern,
    triangle: &SetupTriangle,
    labels: Option<&[u32; LANES]>,
    wanted: u32,
    keys: &mut Keys,
    ids: &mut Ids,
) {
    let [low, high] = triangle.key_range;
    let none = [0u32; LANES];
    let labels = *labels.unwrap_or(&none);
    // All is read before anything is written: arrays that might overlap are not turned into vector instructions.
    let [x, y, z] = lane.edges;
    let steps = lane.key;
    let (mut new_keys, mut passes) = (keys.0, [0u32; LANES]);
    for i in 0..LANES {
        let value = key + steps[i];
        let value = if value < low { low } else { value };
        let value = if value > high { high } else { value };
        let mut covered = true;
        if EDGES {
            let e0 = base[0].wrapping_add(x[i]);
            let e1 = base[1].wrapping_add(y[i]);
            let e2 = base[2].wrapping_add(z[i]);
            covered = (e0 | e1 | e2) >= 0;
        }
        if STENCIL {
            covered &= labels[i] == wanted;
        }
        let value = if covered { value } else { f32::NEG_INFINITY };
        let pass = value > new_keys[i];
        passes[i] = 0u32.wrapping_sub(u32::from(pass));
        new_keys[i] = if pass { value } else { new_keys[i] };
    }
    // Where the compiler knew masks for conditions it would write by masked stores, which take tens of cycles on some
    // machines.
    let passes = std::hint::black_box(passes);
    let (mut new_ids, id) = (ids.0, triangle.id);
    for i in 0..LANES {
        new_ids[i] = (id & passes[i]) | (new_ids[i] & !passes[i]);
    }
    keys.0 = new_keys;
    ids.0 = new_ids;
}
