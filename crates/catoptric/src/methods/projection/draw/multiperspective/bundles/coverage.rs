//! Coverage and depth of triangles at the samples of a tile.

use super::bundle::TERMS;
use crate::math::lanes::{LANES, bits_of};
use glam::Vec2;

/// Pixels along the side of the largest tile.
pub(in super::super) const ROOT: usize = 16;

/// A sample that shows nothing.
pub(in super::super) const NOTHING: u32 = u32::MAX;

/// The most samples of a pixel.
const MAX_SAMPLES: usize = 16;

/// A tile's pixels and what their samples show so far. Pixels follow each other row by row, with [`ROOT`] in a row.
#[derive(Debug)]
pub(in super::super) struct TileSamples {
    /// Inverse depths: larger ones are nearer. Nothing is at 0.
    keys: Vec<f32>,
    /// Numbers of surfaces, or [`NOTHING`].
    pub(in super::super) shown: Vec<u32>,
    pub(in super::super) samples: usize,
    /// Offsets of samples from a pixel's centre, in pixels.
    x: [f32; MAX_SAMPLES],
    y: [f32; MAX_SAMPLES],
}

impl Default for TileSamples {
    fn default() -> Self {
        Self { keys: Vec::new(), shown: Vec::new(), samples: 1, x: [0.0; MAX_SAMPLES], y: [0.0; MAX_SAMPLES] }
    }
}

/// The pixels of a tile that are drawn.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct TileArea {
    /// The centre of its first pixel in the bundle's coordinates, and their change a pixel.
    pub(in super::super) corner: [f32; 2],
    pub(in super::super) scale: f32,
    /// Pixels a side: 16, 8, 4 or 2.
    pub(in super::super) size: usize,
    /// Bits of the pixels in each row.
    pub(in super::super) rows: [u16; ROOT],
}

/// A triangle's functions, with the sign that makes edges positive within.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct DrawnTriangle {
    pub(in super::super) number: u32,
    /// Of the edges, and of the plane.
    pub(in super::super) functions: [[f32; TERMS]; 4],
    /// Depths at which rays start, where that matters for this triangle.
    pub(in super::super) starts: Option<[f32; TERMS]>,
}

/// Values of a function over eight pixels of a row, and their change a pixel to the right and down.
#[derive(Clone, Copy)]
struct RowValues {
    value: [f32; LANES],
    dx: [f32; LANES],
    dy: [f32; LANES],
}

#[inline(always)]
fn row_values(function: &[f32; TERMS], u: &[f32; LANES], v: f32, scale: f32) -> RowValues {
    let [c, cu, cv, cuu, cuv, cvv] = *function;
    let (constant, linear) = (c + v * (cv + v * cvv), cu + cuv * v);
    let (down, twice) = (cv + 2.0 * cvv * v, 2.0 * cuu);
    let mut row = RowValues { value: [0.0; LANES], dx: [0.0; LANES], dy: [0.0; LANES] };
    for (lane, &u) in u.iter().enumerate() {
        row.value[lane] = constant + u * (linear + u * cuu);
        row.dx[lane] = (linear + twice * u) * scale;
        row.dy[lane] = (down + cuv * u) * scale;
    }
    row
}

impl RowValues {
    /// The value in a pixel's centre, and its changes.
    #[inline(always)]
    fn lane(&self, lane: usize) -> [f32; 3] {
        [self.value[lane], self.dx[lane], self.dy[lane]]
    }
}

/// A triangle that may lie before the start of rays, in one pixel: functions of the distance from the pixel's centre.
///
/// Its inverse depth has a pole where it passes the plane that depths are measured from: it has no slope to go by.
struct NearSurface {
    /// Their quotient is the inverse depth.
    sum: [f32; 3],
    plane: [f32; 3],
    /// Positive beyond the start.
    beyond: [f32; 3],
}

impl NearSurface {
    #[inline(always)]
    fn new(edges: [[f32; 3]; 3], plane: [f32; 3], start: [f32; 3]) -> Self {
        let sum: [f32; 3] = std::array::from_fn(|term| edges[0][term] + edges[1][term] + edges[2][term]);
        let beyond = std::array::from_fn(|term| match term {
            0 => plane[0] - start[0] * sum[0],
            _ => plane[term] - start[term] * sum[0] - start[0] * sum[term],
        });
        Self { sum, plane, beyond }
    }

    /// The inverse depth, and whether rays have started before it.
    #[inline(always)]
    fn at(&self, x: f32, y: f32) -> (f32, bool) {
        let value = |[value, dx, dy]: &[f32; 3]| value + dx * x + dy * y;
        (value(&self.sum) / value(&self.plane), value(&self.beyond) > 0.0)
    }
}

/// A function's value at a place.
#[inline(always)]
pub(in super::super) fn value_at(function: &[f32; TERMS], u: f32, v: f32) -> f32 {
    let [c, cu, cv, cuu, cuv, cvv] = *function;
    c + v * (cv + v * cvv) + u * (cu + cuv * v + u * cuu)
}

impl TileSamples {
    /// Begins a tile with these sample places within pixels.
    pub(in super::super) fn begin(&mut self, positions: &[Vec2]) {
        self.samples = positions.len();
        for (index, position) in positions.iter().enumerate() {
            (self.x[index], self.y[index]) = (position.x - 0.5, position.y - 0.5);
        }
        let count = ROOT * ROOT * self.samples;
        self.keys.clear();
        self.keys.resize(count, 0.0);
        self.shown.clear();
        self.shown.resize(count, NOTHING);
    }

    /// Draws a triangle over eight columns from `column` and the rows from `row` to `row_end`.
    #[inline(always)]
    pub(in super::super) fn draw(
        &mut self,
        area: &TileArea,
        triangle: &DrawnTriangle,
        column: usize,
        rows: std::ops::Range<usize>,
    ) {
        match self.samples {
            1 => self.draw_rows::<1, 1>(area, triangle, column, rows),
            2 => self.draw_rows::<2, 2>(area, triangle, column, rows),
            4 => self.draw_rows::<4, 4>(area, triangle, column, rows),
            8 => self.draw_rows::<8, 8>(area, triangle, column, rows),
            _ => self.draw_rows::<16, 8>(area, triangle, column, rows),
        }
    }

    #[inline(always)]
    fn draw_rows<const SAMPLES: usize, const GROUP: usize>(
        &mut self,
        area: &TileArea,
        triangle: &DrawnTriangle,
        column: usize,
        rows: std::ops::Range<usize>,
    ) {
        let mut u = [0.0f32; LANES];
        for (lane, u) in u.iter_mut().enumerate() {
            *u = area.corner[0] + (column + lane) as f32 * area.scale;
        }
        let [fa, fb, fc, fk] = &triangle.functions;
        for row in rows {
            let wanted = (area.rows[row] >> column) as u32 & 0xff;
            if wanted == 0 {
                continue;
            }
            let v = area.corner[1] + row as f32 * area.scale;
            let a = row_values(fa, &u, v, area.scale);
            let b = row_values(fb, &u, v, area.scale);
            let c = row_values(fc, &u, v, area.scale);
            let k = row_values(fk, &u, v, area.scale);
            let (mut touched, mut whole) = ([false; LANES], [false; LANES]);
            let (mut key, mut key_dx, mut key_dy) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
            for lane in 0..LANES {
                let reach = |row: &RowValues| 0.5 * (row.dx[lane].abs() + row.dy[lane].abs());
                let (ra, rb, rc) = (reach(&a), reach(&b), reach(&c));
                let (va, vb, vc) = (a.value[lane], b.value[lane], c.value[lane]);
                touched[lane] = (va + ra >= 0.0) & (vb + rb >= 0.0) & (vc + rc >= 0.0);
                whole[lane] = (va - ra >= 0.0) & (vb - rb >= 0.0) & (vc - rc >= 0.0);
                let inverse = 1.0 / k.value[lane];
                let at = (va + vb + vc) * inverse;
                key[lane] = at;
                key_dx[lane] = (a.dx[lane] + b.dx[lane] + c.dx[lane] - at * k.dx[lane]) * inverse;
                key_dy[lane] = (a.dy[lane] + b.dy[lane] + c.dy[lane] - at * k.dy[lane]) * inverse;
            }
            let (touched_bits, whole_bits) = (u32::from(bits_of(touched)), u32::from(bits_of(whole)));
            let mut pixels = touched_bits & wanted;
            while pixels != 0 {
                let lane = pixels.trailing_zeros() as usize;
                pixels &= pixels - 1;
                let near = triangle.starts.as_ref().map(|starts| {
                    let start = row_values(starts, &[u[lane]; LANES], v, area.scale);
                    NearSurface::new([&a, &b, &c].map(|row| row.lane(lane)), k.lane(lane), start.lane(0))
                });
                let first = (row * ROOT + column + lane) * SAMPLES;
                let edges = (whole_bits >> lane & 1 == 0).then(|| [&a, &b, &c].map(|row| row.lane(lane)));
                let plane = [key[lane], key_dx[lane], key_dy[lane]];
                for group in 0..SAMPLES / GROUP {
                    let offset = group * GROUP;
                    let range = first + offset..first + offset + GROUP;
                    let keys = &mut self.keys[range.clone()];
                    let shown = &mut self.shown[range];
                    let (x, y) = (&self.x[offset..offset + GROUP], &self.y[offset..offset + GROUP]);
                    draw_group::<GROUP>(edges.as_ref(), &plane, near.as_ref(), triangle.number, x, y, keys, shown);
                }
            }
        }
    }

    /// Draws a triangle where a test passes of the sample's place from the tile's first pixel's centre, in pixels.
    pub(in super::super) fn draw_tested(
        &mut self,
        area: &TileArea,
        triangle: &DrawnTriangle,
        is_present: impl Fn(f32, f32) -> bool,
    ) {
        let [fa, fb, fc, fk] = &triangle.functions;
        for row in 0..area.size {
            for column in (0..area.size).filter(|column| area.rows[row] >> column & 1 != 0) {
                for sample in 0..self.samples {
                    let (x, y) = (column as f32 + self.x[sample], row as f32 + self.y[sample]);
                    let (u, v) = (area.corner[0] + x * area.scale, area.corner[1] + y * area.scale);
                    let edges = [fa, fb, fc].map(|function| value_at(function, u, v));
                    if edges.iter().any(|edge| *edge < 0.0 || edge.is_nan()) {
                        continue;
                    }
                    let key = edges.iter().sum::<f32>() / value_at(fk, u, v);
                    let index = (row * ROOT + column) * self.samples + sample;
                    let starts = |starts: &[f32; TERMS]| 1.0 / value_at(starts, u, v).max(f32::MIN_POSITIVE);
                    let nearest = triangle.starts.as_ref().map_or(f32::INFINITY, starts);
                    if key > self.keys[index] && key < nearest && is_present(x, y) {
                        self.keys[index] = key;
                        self.shown[index] = triangle.number;
                    }
                }
            }
        }
    }
}

/// Draws a triangle over samples of one pixel.
#[allow(clippy::too_many_arguments)] // inlined; a struct would only hide what is loop-invariant
#[inline(always)]
fn draw_group<const GROUP: usize>(
    edges: Option<&[[f32; 3]; 3]>,
    plane: &[f32; 3],
    near: Option<&NearSurface>,
    number: u32,
    x: &[f32],
    y: &[f32],
    keys: &mut [f32],
    shown: &mut [u32],
) {
    let (mut new_keys, mut new_shown) = ([0u32; GROUP], [0u32; GROUP]);
    let (x, y): ([f32; GROUP], [f32; GROUP]) = (std::array::from_fn(|i| x[i]), std::array::from_fn(|i| y[i]));
    for i in 0..GROUP {
        (new_keys[i], new_shown[i]) = (keys[i].to_bits(), shown[i]);
    }
    for i in 0..GROUP {
        let (mut key, mut is_beyond) = (plane[0] + plane[1] * x[i] + plane[2] * y[i], true);
        if let Some(near) = near {
            (key, is_beyond) = near.at(x[i], y[i]);
        }
        let mut pass = 0u32.wrapping_sub(u32::from((key > f32::from_bits(new_keys[i])) & is_beyond));
        if let Some([a, b, c]) = edges {
            let va = a[0] + a[1] * x[i] + a[2] * y[i];
            let vb = b[0] + b[1] * x[i] + b[2] * y[i];
            let vc = c[0] + c[1] * x[i] + c[2] * y[i];
            pass &= 0u32.wrapping_sub(u32::from((va >= 0.0) & (vb >= 0.0) & (vc >= 0.0)));
        }
        new_keys[i] = (key.to_bits() & pass) | (new_keys[i] & !pass);
        new_shown[i] = (number & pass) | (new_shown[i] & !pass);
    }
    for i in 0..GROUP {
        (keys[i], shown[i]) = (f32::from_bits(new_keys[i]), new_shown[i]);
    }
}
