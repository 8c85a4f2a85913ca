// Cells of four rays, and what they hit on each path.
//
// A cell is a pixel of four samples, or a square of four pixels of one. A path is the kinds of its events: a bit an
// event, set where light is refracted.

// Rays of a cell.
const RAYS = 4u;
// A ray's hit: a triangle's number and 1, or 0, with these bits where light goes on from there. Not decided yet:
// UNRESOLVED. Where the geometry of paths is drawn, two more bits say whether that goes on from there.
const HIT_LIST_REFLECTS = 0x10000000u;
const HIT_LIST_REFRACTS = 0x20000000u;
const HIT_REFLECTS = 0x40000000u;
const HIT_REFRACTS = 0x80000000u;
// Tiles follow no ray from there: the light is known, or found by rays of lobes.
const HIT_BLURRED = 0x8000000u;
const HIT_TRIANGLE = 0x07ffffffu;
const UNRESOLVED = 0xffffffffu;

override SAMPLES: u32 = 1u;

// The places of four samples, from the corner of the pixel.
var<private> four_samples: array<vec2f, 4> =
    array<vec2f, 4>(vec2f(0.375, 0.125), vec2f(0.875, 0.375), vec2f(0.125, 0.625), vec2f(0.625, 0.875));

// The pixel of a ray, in the band of rows that is drawn.
fn pixel_of(cell: vec2u, ray: u32) -> vec2u {
    return select(cell, cell * 2u + vec2u(ray & 1u, ray >> 1u), SAMPLES == 1u);
}

// The place of a ray in the picture, in pixels.
fn position_of(cell: vec2u, ray: u32) -> vec2f {
    let corner = vec2f(pixel_of(cell, ray) + vec2u(0u, frame.first_row));
    return corner + select(four_samples[ray], frame.sample_place, SAMPLES == 1u);
}

// NONE where nothing is hit.
fn triangle_of(hit: u32) -> u32 {
    return (hit & HIT_TRIANGLE) - 1u;
}

// True if a path may go on from what a ray has hit by an event of a kind.
fn goes_on(hit: u32, kind: u32) -> bool {
    let is_open = hit != UNRESOLVED && (hit & HIT_BLURRED) == 0u;
    return is_open && (hit & select(HIT_REFLECTS, HIT_REFRACTS, kind == TRANSMIT)) != 0u;
}

// True if geometry that goes on from there is drawn.
fn list_goes_on(hit: u32, kind: u32) -> bool {
    return (hit & select(HIT_LIST_REFLECTS, HIT_LIST_REFRACTS, kind == TRANSMIT)) != 0u;
}

// The place of a cell in the table of hits, for a path of so many events.
fn hit_index(cell: vec2u, events: u32, kinds: u32) -> u32 {
    var path = events;
    if HAS_LENSES {
        path = (1u << events) - 1u + (kinds & ((1u << events) - 1u));
    }
    return (path * frame.cells.y + cell.y) * frame.cells.x + cell.x;
}
