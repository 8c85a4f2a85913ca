//! The pixels of triangles and rectangles: those whose middle lies within, or on a left or upper edge. Of shapes that
//! share an edge exactly one has each pixel on it.

use std::ops::Range;

/// Parts of a pixel on which corners lie, as on GPUs.
const GRID: f64 = 256.0;

/// A place on the screen in pixels, on the grid; `None` if it is none.
pub(crate) fn snapped(place: [f32; 2]) -> Option<[f64; 2]> {
    let snapped = place.map(|at| (f64::from(at) * GRID).round() / GRID);
    snapped.iter().all(|at| at.is_finite()).then_some(snapped)
}

/// A rectangle of whole pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pixels {
    pub(crate) columns: Range<usize>,
    pub(crate) rows: Range<usize>,
}

impl Pixels {
    /// The pixels of these whose middles lie between two corners.
    pub(crate) fn within(&self, [low, high]: [[f64; 2]; 2]) -> Self {
        let cut = |all: &Range<usize>, low: f64, high: f64| {
            let [start, end] = [low, high].map(|at| first_pixel(at).clamp(all.start as f64, all.end as f64) as usize);
            start..end
        };
        Self { columns: cut(&self.columns, low[0], high[0]), rows: cut(&self.rows, low[1], high[1]) }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.columns.is_empty() || self.rows.is_empty()
    }
}

/// The first pixel of a row or column whose middle is not before a place.
fn first_pixel(at: f64) -> f64 {
    (at - 0.5).ceil()
}

/// A shape on the screen.
#[derive(Clone, Debug)]
pub(crate) enum Region {
    /// An upright rectangle: all pixels of its bounds.
    Rectangle,
    /// Corners from above to below.
    Triangle([[f64; 2]; 3]),
}

impl Region {
    pub(crate) fn triangle(mut corners: [[f64; 2]; 3]) -> Self {
        corners.sort_by(|one, other| one[1].total_cmp(&other[1]));
        Self::Triangle(corners)
    }

    /// The columns of a row's pixels in the shape; `bounds` are the pixels of its bounds.
    pub(crate) fn columns(&self, row: usize, bounds: &Pixels) -> Range<usize> {
        let Self::Triangle([upper, middle, lower]) = self else { return bounds.columns.clone() };
        let y = row as f64 + 0.5;
        let short = if y < middle[1] { crossing(*upper, *middle, y) } else { crossing(*middle, *lower, y) };
        let long = crossing(*upper, *lower, y);
        let column = |x: f64| first_pixel(x).clamp(bounds.columns.start as f64, bounds.columns.end as f64) as usize;
        column(short.min(long))..column(short.max(long))
    }
}

/// Where an edge crosses the middle of a row. Its ends come from above to below, so both triangles that have the edge
/// get the same number to the bit.
fn crossing(upper: [f64; 2], lower: [f64; 2], y: f64) -> f64 {
    // On the grid these are whole numbers: exact, and so is the quotient wherever it decides.
    let [width, height] = [(lower[0] - upper[0]) * GRID, (lower[1] - upper[1]) * GRID];
    (upper[0] * GRID * height + width * (y - upper[1]) * GRID) / (height * GRID)
}

/// The corners of an upright rectangle that six corners of two triangles make, from the least to the greatest; `None`
/// if they make none.
pub(crate) fn rectangle(corners: &[[f64; 2]; 6]) -> Option<[[f64; 2]; 2]> {
    let mut low = corners[0];
    let mut high = corners[0];
    for corner in corners {
        for axis in 0..2 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    let mut missing = [0b1111_u8; 2];
    for (index, corner) in corners.iter().enumerate() {
        let sides = [0, 1].map(|axis| (corner[axis] == high[axis], corner[axis] == low[axis]));
        if sides.iter().any(|(is_high, is_low)| is_high == is_low) {
            return None;
        }
        missing[index / 3] &= !(1 << (usize::from(sides[0].0) | usize::from(sides[1].0) << 1));
    }
    // Each triangle lacks one corner, and these lie opposite.
    let is_whole = missing.iter().all(|missing| missing.count_ones() == 1)
        && missing[0].trailing_zeros() ^ missing[1].trailing_zeros() == 3;
    is_whole.then_some([low, high])
}
