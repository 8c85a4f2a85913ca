// The tables of pieces that are divided and drawn, and their counters.

@group(2) @binding(3) var<storage, read_write> appearances: array<Appearance>;
@group(2) @binding(4) var<storage, read_write> pieces: array<Piece>;
@group(2) @binding(5) var<storage, read_write> next_pieces: array<Piece>;
// Corners as `lists.wgsl` draws them: two for each.
@group(2) @binding(6) var<storage, read_write> drawn: array<vec4u>;
@group(2) @binding(7) var<storage, read_write> work: array<atomic<u32>>;
@group(2) @binding(10) var<storage, read_write> points: array<Point>;

// The arguments of a dispatch over the pieces.
const GROUPS = 0u;
// Pieces that are divided now, and those that are next.
const PIECES_NOW = 3u;
const PIECES_NEXT = 4u;
// Points so far, and triangles that are drawn, those of other reflectors among them.
const POINTS = 5u;
const DRAWN = 6u;
// Counters of a whole picture: points that were projected, pieces that were left to tiles because they were to be
// divided further, and reflectors that were, because there was no room for what they show.
const PROJECTED = 7u;
const UNFINISHED = 8u;
const LEFT_REFLECTORS = 9u;
// Triangles before those of this reflector.
const DRAWN_BEFORE = 12u;
// Appearances so far.
const APPEARANCES = 10u;
// Rounds of division that have begun.
const ROUND = 11u;
// Not 0: there is no room for all that a reflector shows.
const IS_FULL = 13u;
// The arguments of drawing: four for each reflector.
const ARGUMENTS_AT = 16u;
