//! The rays of one path, by the cells of the ray map.

use super::super::layout::{WordReader, WordWriter};
use super::grid_ray::GridRay;
use catoptric_core::parallel;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::raster::BlockMask;
use glam::Vec2;
use std::ops::Range;

/// The greatest distance of a path's places beyond its outermost rays, in cells. Chosen, not measured.
const FARTHEST_NEIGHBOUR: f32 = 0.75;

/// A cell that has more than one piece in it or beside it, or none.
const MIXED: u32 = u32::MAX;

/// The maximum number of cells of a map, across or down: far more than one has.
const MOST_CELLS: u32 = 1 << 12;

/// The regular ray of a cell that has none.
pub(in super::super) const NO_RAY: u32 = u32::MAX;

/// The rays of one path.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct DensePathRays {
    pub(in super::super) path: SpecularPath,
    /// The rays in the order of the cells nearest to them, row by row; a cell's regular ray is its first.
    pub(in super::super) rays: Vec<GridRay>,
    /// Place of each in the map, in cells: searched most.
    places: Vec<[f32; 2]>,
    /// The connected region that each ray belongs to.
    pub(in super::super) piece_of_ray: Vec<u32>,
    pub(in super::super) piece_count: u32,
    /// The rectangle of cells with rays.
    low: [u32; 2],
    size: [u32; 2],
    /// Start of the rays of each of its cells.
    starts: Vec<u32>,
    /// The regular ray of each, or [`NO_RAY`].
    regular: Vec<u32>,
    /// The piece of each of its cells, or [`MIXED`].
    piece_of_cell: Vec<u32>,
}

impl DensePathRays {
    /// The blocks of a picture where the path is not seen, and those of blocks of the map (their corners, in cells)
    /// that are left out: none if there are none of these. Cells are so large, and the map reaches so far beyond the
    /// picture, in pixels.
    pub(in super::super) fn blocks_without(
        &self,
        left_out: &[[[f32; 2]; 2]],
        picture: [u32; 2],
        (spacing_px, margin_px): (f32, f32),
    ) -> BlockMask {
        if left_out.is_empty() {
            return BlockMask::default();
        }
        let mut blocks = BlockMask::new(picture.map(|pixels| pixels as usize));
        let place_px = |place: [f32; 2], cells: f32| (Vec2::from(place) + 0.5 + cells) * spacing_px - margin_px;
        // Rays lie within cells, not on their borders.
        let half = 0.49;
        for place in &self.places {
            blocks.add_box(place_px(*place, -half), place_px(*place, half));
        }
        blocks.invert();
        for [low, high] in left_out {
            blocks.add_box(place_px(*low, -half), place_px(*high, half));
        }
        blocks
    }

    /// Rays in the order of the cells of a rectangle: its first cell and size, where the rays of each cell start, and
    /// its regular ray. Their pieces are not known yet.
    pub(super) fn of_cells(
        path: SpecularPath,
        rays: Vec<GridRay>,
        [low, size]: [[u32; 2]; 2],
        starts: Vec<u32>,
        regular: Vec<u32>,
    ) -> Self {
        let places = rays.iter().map(|ray| ray.place).collect();
        Self { path, rays, places, low, size, starts, regular, ..Self::default() }
    }

    /// Takes the piece of each ray, and how many there are.
    pub(super) fn set_pieces(&mut self, (piece_of_ray, piece_count): (Vec<u32>, u32)) {
        (self.piece_of_ray, self.piece_count) = (piece_of_ray, piece_count);
        self.piece_of_cell = self.pieces_of_cells();
    }

    /// The number of rays.
    pub(in super::super) fn count(&self) -> usize {
        self.places.len()
    }

    /// The place of a ray, in cells.
    #[inline]
    pub(in super::super) fn place_of(&self, ray: usize) -> [f32; 2] {
        self.places[ray]
    }

    /// Forgets all of the rays but where they are: cameras need no more to be asked, unless they are polished.
    pub(in super::super) fn forget_rays(&mut self) {
        self.rays = Vec::new();
    }

    /// Bytes of all that is known of them.
    pub(in super::super) fn byte_count(&self) -> usize {
        let Self { rays, places, piece_of_ray, starts, regular, piece_of_cell, .. } = self;
        let cells = [piece_of_ray, starts, regular, piece_of_cell];
        size_of_val(rays.as_slice())
            + size_of_val(places.as_slice())
            + cells.map(|numbers| size_of_val(numbers.as_slice())).iter().sum::<usize>()
    }

    /// Writes where the rays are and their pieces, without the path.
    pub(in super::super) fn store(&self, words: &mut WordWriter) {
        let Self { low, size, piece_count, .. } = self;
        [low[0], low[1], size[0], size[1], *piece_count].into_iter().for_each(|number| words.number(number));
        words.number(self.count() as u32);
        let is_regular = |bin: usize| u32::from(self.regular[bin] != NO_RAY);
        words.runs((0..self.regular.len()).map(|bin| (self.starts[bin + 1] - self.starts[bin]) << 1 | is_regular(bin)));
        words.runs(self.piece_of_ray.iter().copied());
        // Regular rays are in the middle of their cells.
        let others: Vec<[f32; 2]> = (0..self.regular.len())
            .flat_map(|bin| self.starts[bin] as usize + is_regular(bin) as usize..self.starts[bin + 1] as usize)
            .map(|ray| self.places[ray])
            .collect();
        words.records(&others);
    }

    /// The rays that [`Self::store`] has written; `None` for other words.
    pub(in super::super) fn stored(path: SpecularPath, words: &mut WordReader<'_>) -> Option<Self> {
        let [low, size] = [[words.number()?, words.number()?], [words.number()?, words.number()?]];
        let (piece_count, count) = (words.number()?, words.number()? as usize);
        let is_in_map = |axis: usize| low[axis].checked_add(size[axis]).is_some_and(|end| end <= MOST_CELLS);
        if !(is_in_map(0) && is_in_map(1)) {
            return None;
        }
        let cells = size[0] as usize * size[1] as usize;
        // Each cell has at most one regular ray, and the places of others are written.
        if count > cells + words.left() {
            return None;
        }
        let counts = words.runs(cells)?;
        let (mut starts, mut regular) = (vec![0u32], Vec::with_capacity(counts.len()));
        for (&count, start) in counts.iter().zip(0..) {
            let start: u32 = starts[start];
            let (rays, is_regular) = (count >> 1, count & 1 == 1);
            starts.push(start.checked_add(rays).filter(|_| rays > 0 || !is_regular)?);
            regular.push(if is_regular { start } else { NO_RAY });
        }
        if starts.last().is_none_or(|end| *end as usize != count) {
            return None;
        }
        let piece_of_ray = words.runs(count)?;
        let mut others = words.records::<[f32; 2]>()?.into_iter();
        let mut places = Vec::with_capacity(count);
        for (bin, regular) in regular.iter().enumerate() {
            for ray in starts[bin]..starts[bin + 1] {
                let cell = [low[0] + bin as u32 % size[0], low[1] + bin as u32 / size[0]];
                places.push(if ray == *regular { cell.map(|cell| cell as f32) } else { others.next()? });
            }
        }
        if others.next().is_some() || !piece_of_ray.iter().all(|piece| *piece < piece_count) {
            return None;
        }
        let mut group = Self { path, places, piece_of_ray, piece_count, low, size, starts, regular, ..Self::default() };
        group.piece_of_cell = group.pieces_of_cells();
        Some(group)
    }

    /// The numbers of columns and rows of cells, and the numbers of their regular rays, row by row; [`NO_RAY`] where
    /// there is none.
    pub(in super::super) fn regular_rays(&self) -> ([usize; 2], &[u32]) {
        (self.size.map(|size| size as usize), &self.regular)
    }

    /// Adds rays of known pieces near to others. Returns the renumbering of rays: the old numbers in the order of the
    /// new ones, those of added rays after the others.
    pub(in super::super) fn add(&mut self, added: Vec<(GridRay, u32)>) -> Vec<u32> {
        let before = self.rays.len();
        if added.is_empty() {
            return (0..before as u32).collect();
        }
        // Rays beyond the outermost cells belong to these.
        let bin = |ray: &GridRay| {
            let inside = |axis: usize| {
                let (low, size) = (i64::from(self.low[axis]), i64::from(self.size[axis]));
                (ray.place[axis].round() as i64 - low).clamp(0, size - 1) as usize
            };
            inside(1) * self.size[0] as usize + inside(0)
        };
        let bins = (0..self.starts.len() - 1)
            .flat_map(|bin| (self.starts[bin]..self.starts[bin + 1]).map(move |_| bin))
            .chain(added.iter().map(|(ray, _)| bin(ray)));
        let mut order: Vec<(usize, u32)> = bins.zip(0..).collect();
        order.sort_unstable();
        let mut starts = vec![0u32; self.starts.len()];
        for (bin, _) in &order {
            starts[bin + 1] += 1;
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let order: Vec<u32> = order.into_iter().map(|(_, ray)| ray).collect();
        let (rays, pieces): (Vec<GridRay>, Vec<u32>) = order
            .iter()
            .map(|&ray| match (ray as usize).checked_sub(before) {
                Some(index) => added[index],
                None => (self.rays[ray as usize], self.piece_of_ray[ray as usize]),
            })
            .unzip();
        // Regular rays stay the first of their cells.
        for (bin, regular) in self.regular.iter_mut().enumerate().filter(|(_, regular)| **regular != NO_RAY) {
            *regular = starts[bin];
        }
        (self.rays, self.piece_of_ray, self.starts) = (rays, pieces, starts);
        self.places = self.rays.iter().map(|ray| ray.place).collect();
        order
    }

    /// The numbers of the rays of a cell.
    #[inline]
    pub(in super::super) fn in_cell(&self, column: i64, row: i64) -> Range<usize> {
        let Some(bin) = self.bin(column, row) else { return 0..0 };
        self.starts[bin] as usize..self.starts[bin + 1] as usize
    }

    /// The numbers of the rays of some cells of a row, from the first column to the second.
    #[inline]
    fn in_cells(&self, columns: [i64; 2], row: i64) -> Range<usize> {
        let last = i64::from(self.size[0]) - 1;
        let [first, end] = columns.map(|column| column - i64::from(self.low[0]));
        let row = row - i64::from(self.low[1]);
        if end < 0 || first > last || row < 0 || row >= i64::from(self.size[1]) {
            return 0..0;
        }
        let bin = |column: i64| (row * (last + 1) + column) as usize;
        self.starts[bin(first.max(0))] as usize..self.starts[bin(end.min(last)) + 1] as usize
    }

    /// The regular ray of a cell.
    #[inline]
    pub(in super::super) fn regular(&self, column: i64, row: i64) -> Option<usize> {
        let ray = self.regular[self.bin(column, row)?];
        (ray != NO_RAY).then_some(ray as usize)
    }

    /// The ray nearest to a place, in cells; returns `None` if none is within three quarters of a cell.
    pub(in super::super) fn nearest(&self, place: [f64; 2]) -> Option<usize> {
        let mut nearest = (f32::INFINITY, 0);
        let [x, y] = place.map(|place| place as f32);
        let mut look = |columns: [i64; 2], rows: [i64; 2]| {
            for row in rows[0]..=rows[1] {
                let rays = self.in_cells(columns, row);
                for (place, ray) in self.places[rays.clone()].iter().zip(rays) {
                    let (right, down) = (place[0] - x, place[1] - y);
                    let distance2 = right * right + down * down;
                    if distance2 < nearest.0 {
                        nearest = (distance2, ray);
                    }
                }
            }
            nearest
        };
        // Rays of other cells than the four around the place are more than half a cell away.
        let [left, above] = place.map(|place| place.floor() as i64);
        let mut nearest = look([left, left + 1], [above, above + 1]);
        if nearest.0 > 0.25 {
            let [column, row] = place.map(|place| place.round() as i64);
            nearest = look([column - 1, column + 1], [row - 1, row + 1]);
        }
        (nearest.0 <= FARTHEST_NEIGHBOUR * FARTHEST_NEIGHBOUR).then_some(nearest.1)
    }

    /// The piece that a place belongs to.
    #[inline]
    pub(in super::super) fn piece_at(&self, place: [f64; 2]) -> Option<u32> {
        let [column, row] = place.map(|place| place.round() as i64);
        match self.bin(column, row).map(|bin| self.piece_of_cell[bin]) {
            Some(piece) if piece != MIXED => Some(piece),
            _ => self.nearest(place).map(|ray| self.piece_of_ray[ray]),
        }
    }

    #[inline]
    fn bin(&self, column: i64, row: i64) -> Option<usize> {
        let (column, row) = (column - i64::from(self.low[0]), row - i64::from(self.low[1]));
        let inside = column >= 0 && row >= 0 && column < i64::from(self.size[0]) && row < i64::from(self.size[1]);
        inside.then(|| row as usize * self.size[0] as usize + column as usize)
    }

    /// The piece of each cell that has, like all cells around it, a regular ray of one and the same piece.
    fn pieces_of_cells(&self) -> Vec<u32> {
        let [columns, rows] = self.size.map(|size| size as usize);
        let same = |[a, b, c]: [u32; 3]| if a == b && b == c { b } else { MIXED };
        // First along the rows, then across them.
        let mut along = vec![MIXED; columns * rows];
        parallel::for_each_chunk_mut(&mut along, columns.max(1), |row, along| {
            let regular = &self.regular[row * columns..][..columns];
            let piece = |ray: u32| self.piece_of_ray.get(ray as usize).copied().unwrap_or(MIXED);
            let mut before = [MIXED; 2];
            for (column, &ray) in regular.iter().enumerate() {
                let piece = piece(ray);
                if column > 0 {
                    along[column - 1] = same([before[0], before[1], piece]);
                }
                before = [before[1], piece];
            }
        });
        let mut found = vec![MIXED; columns * rows];
        parallel::for_each_chunk_mut(&mut found, columns.max(1), |row, found| {
            if row == 0 || row + 1 == rows {
                return;
            }
            let [above, own, below] = [row - 1, row, row + 1].map(|row| &along[row * columns..][..columns]);
            for (column, found) in found.iter_mut().enumerate() {
                *found = same([above[column], own[column], below[column]]);
            }
        });
        found
    }

    /// The rays of a piece in the square whose corners are four regular rays, the first at `cell`.
    pub(in super::super) fn in_unit(&self, cell: [u32; 2], piece: u32) -> impl Iterator<Item = usize> {
        let low = cell.map(i64::from);
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let rays = corners.into_iter().flat_map(move |(right, down)| self.in_cell(low[0] + right, low[1] + down));
        rays.filter(move |&ray| {
            let inside = |axis: usize| (0.0..=1.0).contains(&(self.rays[ray].place[axis] - cell[axis] as f32));
            self.piece_of_ray[ray] == piece && inside(0) && inside(1)
        })
    }

    /// The cell that a ray is nearest to.
    pub(in super::super) fn cell_of(&self, ray: usize) -> [i64; 2] {
        self.places[ray].map(|place| place.round() as i64)
    }
}
