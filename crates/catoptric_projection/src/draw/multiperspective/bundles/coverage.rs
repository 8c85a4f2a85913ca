//! Coverage and depth of triangles at the samples of a tile.

use super::least_squares::TERMS;
use catoptric_core::math::lanes::{LANES, bits_of};
use glam::Vec2;

/// Pixels along the side of the largest tile.
pub const ROOT: usize = 16;

/// A sample that shows nothing.
pub const NOTHING: u32 = u32::MAX;

/// The maximum number of samples of a pixel.
pub(in super::super) const MAX_SAMPLES: usize = 16;

/// A tile's pixels, and the triangles that their samples show so far. Pixels follow each other row by row, with
/// [`ROOT`] in a row.
#[derive(Debug)]
pub struct TileSamples {
    /// Inverse depths: larger ones are nearer. Nothing is at 0.
    keys: Vec<f32>,
    /// Numbers of surfaces, or [`NOTHING`].
    pub shown: Vec<u32>,
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
pub struct TileArea {
    /// Pixels a side: 16, 8, 4 or 2.
    pub size: usize,
    /// Bits of the pixels in each row.
    pub rows: [u16; ROOT],
}

/// A triangle's functions, with the sign that makes edges positive within.
#[derive(Clone, Copy, Debug)]
pub struct DrawnTriangle {
    /// The number that samples show.
    pub number: u32,
    /// Functions of the three edges and of the plane, for the model of the tile's rays.
    pub functions: [[f32; TERMS]; 4],
    /// The distance beyond the rays' starts from which on the triangle counts; `None` where it lies beyond all starts.
    pub margin: Option<f32>,
}

/// Values of a function over eight pixels of a row, and their change a pixel to the right and down.
#[derive(Clone, Copy)]
pub struct RowValues {
    pub(in super::super) value: [f32; LANES],
    pub(in super::super) dx: [f32; LANES],
    pub(in super::super) dy: [f32; LANES],
}

impl RowValues {
    pub(super) const ZERO: Self = Self { value: [0.0; LANES], dx: [0.0; LANES], dy: [0.0; LANES] };

    /// The value in a pixel's centre, and its changes.
    #[inline(always)]
    pub(in super::super) fn lane(&self, lane: usize) -> [f32; 3] {
        [self.value[lane], self.dx[lane], self.dy[lane]]
    }
}

/// The values that a triangle's functions have in a tile's pixels.
pub trait RayModel {
    /// True if the functions' coefficients are of the rays' coordinates as lines, else of the place in the picture.
    const OF_LINES: bool;

    /// The greatest difference of the rays from the bundle's, in each coordinate of a line; `None`: there is none.
    fn missed(&self) -> Option<&[f32; TERMS]>;

    /// Values over eight pixels of a row from a column on.
    fn row(&self, function: &[f32; TERMS], column: usize, row: usize) -> RowValues;

    /// The value in one pixel's centre, and its changes a pixel to the right and down.
    fn pixel(&self, function: &[f32; TERMS], pixel: [usize; 2]) -> [f32; 3];

    /// The depth at which a pixel's rays start, and its changes a pixel.
    fn start(&self, pixel: [usize; 2]) -> [f32; 3];
}

/// A triangle that may lie before the start of rays, in one pixel, as functions of the distance from the pixel's
/// centre.
///
/// The inverse depth has a pole where the triangle passes the plane that depths are measured from: it cannot be
/// interpolated by its slope.
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
        let sum = sum_of(&edges[0], &edges[1], &edges[2]);
        let beyond = std::array::from_fn(|term| match term {
            0 => plane[0] - start[0] * sum[0],
            _ => plane[term] - start[term] * sum[0] - start[0] * sum[term],
        });
        Self { sum, plane, beyond }
    }

    /// The inverse depth, and whether rays have started before it.
    #[inline(always)]
    fn at(&self, x: f32, y: f32) -> (f32, bool) {
        (at(&self.sum, x, y) / at(&self.plane, x, y), at(&self.beyond, x, y) > 0.0)
    }
}

impl TileSamples {
    /// Begins a tile with these sample places within pixels.
    pub fn begin(&mut self, positions: &[Vec2]) {
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
    pub fn draw(
        &mut self,
        model: &impl RayModel,
        area: &TileArea,
        triangle: &DrawnTriangle,
        column: usize,
        rows: std::ops::Range<usize>,
    ) {
        match self.samples {
            1 => self.draw_rows::<1, 1>(model, area, triangle, column, rows),
            2 => self.draw_rows::<2, 2>(model, area, triangle, column, rows),
            4 => self.draw_rows::<4, 4>(model, area, triangle, column, rows),
            8 => self.draw_rows::<8, 8>(model, area, triangle, column, rows),
            _ => self.draw_rows::<16, 8>(model, area, triangle, column, rows),
        }
    }

    #[inline(always)]
    fn draw_rows<const SAMPLES: usize, const GROUP: usize>(
        &mut self,
        model: &impl RayModel,
        area: &TileArea,
        triangle: &DrawnTriangle,
        column: usize,
        rows: std::ops::Range<usize>,
    ) {
        let [fa, fb, fc, fk] = &triangle.functions;
        for row in rows {
            let wanted = (area.rows[row] >> column) as u32 & 0xff;
            if wanted == 0 {
                continue;
            }
            let a = model.row(fa, column, row);
            let b = model.row(fb, column, row);
            let c = model.row(fc, column, row);
            let k = model.row(fk, column, row);
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
                let near = triangle.margin.map(|margin| {
                    let mut start = model.start([column + lane, row]);
                    start[0] += margin;
                    NearSurface::new([&a, &b, &c].map(|row| row.lane(lane)), k.lane(lane), start)
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

    /// Draws a triangle where a test passes of the functions of the second and third edge and of the sum of all, as
    /// values in the pixel's centre with their changes, and of the sample's place from there.
    #[inline(always)]
    pub(in super::super) fn draw_tested(
        &mut self,
        model: &impl RayModel,
        area: &TileArea,
        triangle: &DrawnTriangle,
        is_present: impl Fn([[f32; 3]; 3], Vec2) -> bool,
    ) {
        // The test is the only closure here: closures would not be compiled for the caller's instruction set.
        for row in 0..area.size {
            let mut rest = area.rows[row];
            while rest != 0 {
                let column = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let mut pixel = [[0.0; 3]; 4];
                let mut may_show = true;
                for (function, pixel) in triangle.functions.iter().zip(&mut pixel) {
                    *pixel = model.pixel(function, [column, row]);
                }
                let [a, b, c, plane] = &pixel;
                for [value, dx, dy] in [a, b, c] {
                    may_show &= value + 0.5 * (dx.abs() + dy.abs()) >= 0.0;
                }
                if !may_show {
                    continue;
                }
                let (sum, start) = (sum_of(a, b, c), model.start([column, row]));
                for sample in 0..self.samples {
                    let (x, y) = (self.x[sample], self.y[sample]);
                    let is_met = (at(a, x, y) >= 0.0) & (at(b, x, y) >= 0.0) & (at(c, x, y) >= 0.0);
                    if !is_met {
                        continue;
                    }
                    let key = at(&sum, x, y) / at(plane, x, y);
                    let index = (row * ROOT + column) * self.samples + sample;
                    let nearest = match triangle.margin {
                        Some(margin) => 1.0 / (at(&start, x, y) + margin).max(f32::MIN_POSITIVE),
                        None => f32::INFINITY,
                    };
                    if key > self.keys[index] && key < nearest && is_present([*b, *c, sum], Vec2::new(x, y)) {
                        self.keys[index] = key;
                        self.shown[index] = triangle.number;
                    }
                }
            }
        }
    }
}

/// A linear function's value at a distance from a pixel's centre.
#[inline(always)]
fn at([value, dx, dy]: &[f32; 3], x: f32, y: f32) -> f32 {
    value + dx * x + dy * y
}

/// The sum of three functions in a pixel.
#[inline(always)]
fn sum_of(a: &[f32; 3], b: &[f32; 3], c: &[f32; 3]) -> [f32; 3] {
    [a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]]
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
