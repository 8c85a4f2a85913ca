//! The rays between a tile's pixels: as one quadratic family, or each pixel's own with its changes.

use super::bundle::{COORDINATES, RayBundle};
use super::coverage::{ROOT, RayModel, RowValues};
use super::least_squares::TERMS;
use catoptric_core::math::lanes::LANES;

/// A function's value at a place.
#[inline(always)]
pub fn value_at(function: &[f32; TERMS], u: f32, v: f32) -> f32 {
    let [c, cu, cv, cuu, cuv, cvv] = *function;
    c + v * (cv + v * cvv) + u * (cu + cuv * v + u * cuu)
}

/// The derivatives of a quadratic function along u and v.
#[inline(always)]
pub(in super::super) fn slopes_at([_, cu, cv, cuu, cuv, cvv]: &[f32; TERMS], u: f32, v: f32) -> [f32; 2] {
    [cu + 2.0 * cuu * u + cuv * v, cv + 2.0 * cvv * v + cuv * u]
}

/// All rays of a tile by one bundle: functions are quadratics of the place in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic {
    /// The first pixel's centre, and the change a pixel.
    corner: [f32; 2],
    scale: f32,
    starts: [f32; TERMS],
}

impl Quadratic {
    /// The model of a tile of so many pixels a side.
    #[inline(always)]
    pub fn new(bundle: &RayBundle, size: usize) -> Self {
        let corner = [0.5 * (1.0 - size as f32) * bundle.scale; 2];
        Self { corner, scale: bundle.scale, starts: bundle.starts }
    }
}

impl RayModel for Quadratic {
    const OF_LINES: bool = false;

    #[inline(always)]
    fn missed(&self) -> Option<&[f32; TERMS]> {
        None
    }

    #[inline(always)]
    fn row(&self, function: &[f32; TERMS], column: usize, row: usize) -> RowValues {
        let [c, cu, cv, cuu, cuv, cvv] = *function;
        let v = self.corner[1] + row as f32 * self.scale;
        let (constant, linear) = (c + v * (cv + v * cvv), cu + cuv * v);
        let (down, twice) = (cv + 2.0 * cvv * v, 2.0 * cuu);
        let mut values = RowValues::ZERO;
        for lane in 0..LANES {
            let u = self.corner[0] + (column + lane) as f32 * self.scale;
            values.value[lane] = constant + u * (linear + u * cuu);
            values.dx[lane] = (linear + twice * u) * self.scale;
            values.dy[lane] = (down + cuv * u) * self.scale;
        }
        values
    }

    #[inline(always)]
    fn pixel(&self, function: &[f32; TERMS], [column, row]: [usize; 2]) -> [f32; 3] {
        let (u, v) = (self.corner[0] + column as f32 * self.scale, self.corner[1] + row as f32 * self.scale);
        let [dx, dy] = slopes_at(function, u, v);
        [value_at(function, u, v), dx * self.scale, dy * self.scale]
    }

    #[inline(always)]
    fn start(&self, pixel: [usize; 2]) -> [f32; 3] {
        self.pixel(&self.starts, pixel)
    }
}

/// Pixels of a tile, row by row, with [`ROOT`] in a row.
const PIXELS: usize = ROOT * ROOT;

/// A ray of its own for every pixel, with its changes from pixel to pixel: functions are linear in the coordinates of
/// lines.
#[derive(Debug)]
pub struct PixelLines {
    value: [[f32; PIXELS]; COORDINATES],
    dx: [[f32; PIXELS]; COORDINATES],
    dy: [[f32; PIXELS]; COORDINATES],
    /// The most by which the rays of samples differ from the bundle's, in each coordinate of a line.
    missed: [f32; TERMS],
}

impl Default for PixelLines {
    fn default() -> Self {
        let none = [[0.0; PIXELS]; COORDINATES];
        Self { value: none, dx: none, dy: none, missed: [0.0; TERMS] }
    }
}

impl PixelLines {
    /// Sets a pixel's ray.
    #[inline(always)]
    pub fn set(&mut self, [column, row]: [usize; 2], coordinates: &[f32; COORDINATES]) {
        for (values, coordinate) in self.value.iter_mut().zip(coordinates) {
            values[row * ROOT + column] = *coordinate;
        }
    }

    /// A pixel's ray as it was set.
    #[inline(always)]
    pub(in super::super) fn get(&self, [column, row]: [usize; 2]) -> [f32; COORDINATES] {
        let mut coordinates = [0.0; COORDINATES];
        for (coordinate, values) in coordinates.iter_mut().zip(&self.value) {
            *coordinate = values[row * ROOT + column];
        }
        coordinates
    }

    /// Sets the changes of all rays by the differences of their neighbours. Right for pixels with two neighbours along
    /// an axis that are set, others need [`Self::set_change`].
    #[inline(always)]
    pub fn difference_all(&mut self, size: usize) {
        for (value, (dx, dy)) in self.value.iter().zip(self.dx.iter_mut().zip(&mut self.dy)) {
            for row in 0..size {
                let first = row * ROOT;
                for column in 1..ROOT - 1 {
                    dx[first + column] = 0.5 * (value[first + column + 1] - value[first + column - 1]);
                }
                if row > 0 && row + 1 < size {
                    for column in 0..ROOT {
                        dy[first + column] = 0.5 * (value[first + column + ROOT] - value[first + column - ROOT]);
                    }
                }
            }
        }
    }

    /// Sets the change of a pixel's ray to the right (axis 0) or down by the rays of its neighbours, as far as these
    /// are known.
    #[inline(always)]
    pub fn set_change(&mut self, pixel: [usize; 2], axis: usize, neighbours: &[Option<[f32; COORDINATES]>; 2]) {
        let here = self.get(pixel);
        let (before, after, factor) = match neighbours {
            [Some(before), Some(after)] => (before, after, 0.5),
            [Some(before), None] => (before, &here, 1.0),
            [None, Some(after)] => (&here, after, 1.0),
            [None, None] => (&here, &here, 0.0),
        };
        let changes = if axis == 0 { &mut self.dx } else { &mut self.dy };
        for (coordinate, values) in changes.iter_mut().enumerate() {
            values[pixel[1] * ROOT + pixel[0]] = (after[coordinate] - before[coordinate]) * factor;
        }
    }

    /// Finds the bundle's errors of the rays of some pixels' samples (bits of rows).
    #[inline(always)]
    pub fn find_missed(&mut self, bundle: &RayBundle, rows: &[u16; ROOT], size: usize) {
        let quadratic = Quadratic::new(bundle, size);
        for (coordinate, missed) in self.missed.iter_mut().enumerate() {
            let function = bundle.coordinate(coordinate);
            let mut most = [0.0f32; LANES];
            for (row, pixels) in rows.iter().enumerate().take(size) {
                for column in (0..size).step_by(LANES) {
                    let of_bundle = quadratic.row(&function, column, row);
                    let first = row * ROOT + column;
                    for (lane, most) in most.iter_mut().enumerate() {
                        let value = self.value[coordinate][first + lane] - of_bundle.value[lane];
                        let dx = self.dx[coordinate][first + lane] - of_bundle.dx[lane];
                        let dy = self.dy[coordinate][first + lane] - of_bundle.dy[lane];
                        let miss = value.abs() + 0.5 * (dx.abs() + dy.abs());
                        let counts = pixels >> (column + lane) & 1 != 0;
                        *most = if counts & (miss > *most) { miss } else { *most };
                    }
                }
            }
            *missed = most.into_iter().fold(0.0, f32::max);
        }
    }
}

impl RayModel for PixelLines {
    const OF_LINES: bool = true;

    #[inline(always)]
    fn missed(&self) -> Option<&[f32; TERMS]> {
        Some(&self.missed)
    }

    #[inline(always)]
    fn row(&self, function: &[f32; TERMS], column: usize, row: usize) -> RowValues {
        let first = row * ROOT + column;
        let mut values = RowValues::ZERO;
        for (coordinate, coefficient) in function.iter().enumerate() {
            let value = &self.value[coordinate][first..first + LANES];
            let dx = &self.dx[coordinate][first..first + LANES];
            let dy = &self.dy[coordinate][first..first + LANES];
            for lane in 0..LANES {
                values.value[lane] += coefficient * value[lane];
                values.dx[lane] += coefficient * dx[lane];
                values.dy[lane] += coefficient * dy[lane];
            }
        }
        values
    }

    #[inline(always)]
    fn pixel(&self, function: &[f32; TERMS], [column, row]: [usize; 2]) -> [f32; 3] {
        let index = row * ROOT + column;
        let mut values = [0.0; 3];
        for (coordinate, coefficient) in function.iter().enumerate() {
            values[0] += coefficient * self.value[coordinate][index];
            values[1] += coefficient * self.dx[coordinate][index];
            values[2] += coefficient * self.dy[coordinate][index];
        }
        values
    }

    #[inline(always)]
    fn start(&self, [column, row]: [usize; 2]) -> [f32; 3] {
        let (index, start) = (row * ROOT + column, COORDINATES - 1);
        [self.value[start][index], self.dx[start][index], self.dy[start][index]]
    }
}
