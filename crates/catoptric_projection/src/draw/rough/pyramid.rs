//! A pyramid of the picture that mirrors would show if they were smooth.

use super::grid::{ReflectedGrid, cells_around};
use catoptric_core::parallel;
use glam::{Vec2, Vec4};

/// Rows of cells that one call works on.
const ROWS_AT_A_TIME: usize = 16;

/// Radiance of all grids and of coarser levels, each of half the width and height.
pub(super) struct Pyramid<'a> {
    /// The finest level, by its places.
    finest: &'a ReflectedGrid,
    /// The levels from the finest one on, which is empty if there are others.
    levels: Vec<Level>,
    grids: usize,
}

/// For each cell, rows from the top: the share that shows rough mirrors, and radiance times that share.
struct Level {
    width: usize,
    height: usize,
    cells: Vec<Vec4>,
}

impl Level {
    /// The sharp light of a grid's cells; where the grid has no cells, that of the coarser level.
    fn of_grid(grid: &ReflectedGrid, coarser: Option<&Self>) -> Self {
        let (width, height) = (grid.layout.width, grid.layout.height);
        let mut cells = vec![Vec4::ZERO; width * height];
        for (place, light) in grid.sharp.iter().enumerate() {
            cells[grid.cell_of(place)] = *light;
        }
        let Some(coarser) = coarser else { return Self { width, height, cells } };
        parallel::for_each_chunk_mut(&mut cells, 2 * width, |row, pair| {
            for column in 0..coarser.width {
                let four = [2 * column, 2 * column + 1, 2 * column + width, 2 * column + width + 1];
                if four.iter().all(|cell| pair[*cell].w == 0.0) {
                    let light = coarser.cells[row * coarser.width + column];
                    for cell in four {
                        pair[cell] = light;
                    }
                }
            }
        });
        Self { width, height, cells }
    }

    /// Replaces cells by the mean of four of a finer level, given by their cells, that all show rough mirrors.
    fn refine(&mut self, finer: impl Fn(usize) -> Vec4 + Sync + Send) {
        let (width, finer_width) = (self.width, 2 * self.width);
        parallel::for_each_chunk_mut(&mut self.cells, ROWS_AT_A_TIME * width, |chunk, cells| {
            for (index, cell) in cells.iter_mut().enumerate() {
                let (column, row) = (index % width, chunk * ROWS_AT_A_TIME + index / width);
                let first = 2 * row * finer_width + 2 * column;
                let four = [first, first + 1, first + finer_width, first + finer_width + 1];
                let sum = finer(four[0]) + finer(four[1]) + finer(four[2]) + finer(four[3]);
                if sum.w == 4.0 {
                    *cell = sum * 0.25;
                }
            }
        });
    }

    /// The means of four cells each.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mean = |cell: usize| {
            let (x, y) = (cell % width * 2, cell / width * 2);
            let mut sum = Vec4::ZERO;
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                if x + dx < self.width && y + dy < self.height {
                    sum += self.cells[(y + dy) * self.width + x + dx] * 0.25;
                }
            }
            sum
        };
        Self { width, height, cells: (0..width * height).map(mean).collect() }
    }
}

impl<'a> Pyramid<'a> {
    /// The pyramid of grids, coarsest first, each of cells of half the side of the one before.
    pub(super) fn new(grids: &'a [ReflectedGrid]) -> Option<Self> {
        let (finest, coarser) = grids.split_last()?;
        let mut levels: Vec<Level> = Vec::new();
        for grid in coarser {
            levels.push(Level::of_grid(grid, levels.last()));
        }
        levels.reverse();
        match levels.first_mut() {
            None => levels.push(Level::of_grid(finest, None)),
            Some(level) => {
                level.refine(|cell| finest.place_of(cell).map_or(Vec4::ZERO, |place| finest.sharp[place]));
                let (width, height) = (finest.layout.width, finest.layout.height);
                levels.insert(0, Level { width, height, cells: Vec::new() });
            }
        }
        for level in 2..levels.len() {
            let (finer, coarser) = levels.split_at_mut(level);
            coarser[0].refine(|cell| finer[level - 1].cells[cell]);
        }
        while let Some(finer) = levels.last().filter(|level| level.width.max(level.height) > 1) {
            levels.push(finer.halved());
        }
        Some(Self { finest, levels, grids: grids.len() })
    }

    /// The level of a grid's cells, and the side of such a cell in those of the finest level.
    pub(super) fn level_of(&self, grid: usize) -> (i32, f32) {
        let level = self.grids - 1 - grid;
        (level as i32, (1u32 << level) as f32)
    }

    /// The sum over the cells around a position, in cells of the finest level: radiance times the share that shows
    /// rough mirrors, and that share.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn at(&self, position: Vec2, level: i32) -> Vec4 {
        if level <= 0 && self.levels[0].cells.is_empty() {
            let sum = self.at_places(position);
            if sum.w > 1e-3 {
                return sum;
            }
        }
        let first = i32::from(self.levels[0].cells.is_empty());
        let level = level.clamp(first, self.levels.len() as i32 - 1);
        let Level { width, height, cells } = &self.levels[level as usize];
        let scale = f32::from_bits((127 - level as u32) << 23);
        let [a, b, c, d] = cells_around(position * scale, *width, *height);
        cells[a.0] * a.1 + cells[b.0] * b.1 + cells[c.0] * c.1 + cells[d.0] * d.1
    }

    /// The mean of the finest grid's places around a position; zero where it has no cells.
    #[inline(always)] // for the instructions of its caller
    fn at_places(&self, position: Vec2) -> Vec4 {
        let Level { width, height, .. } = self.levels[0];
        let mut sum = Vec4::ZERO;
        for (cell, weight) in cells_around(position, width, height) {
            if let Some(place) = self.finest.place_of(cell) {
                sum += self.finest.sharp[place] * weight;
            }
        }
        sum
    }
}
