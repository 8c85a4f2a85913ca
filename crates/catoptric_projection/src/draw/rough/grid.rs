//! A grid over a picture whose cells hold the light of rough mirrors as if they were smooth.

use super::light::RoughLight;
use super::lobe::Lobe;
use super::passage::Passage;
use catoptric_core::scene::View;
use catoptric_engine::optics::step::HIDDEN_LOBE;
use glam::{Vec2, Vec3, Vec4};

/// Grids, each of cells of half the side of the one before.
pub(super) const GRIDS: usize = 3;

/// The widths of lobes in cells, for all grids but the finest: lobes wider than the second number are blurred in that
/// grid, and lobes narrower than the first in a finer one; between them the two are mixed. Chosen between error and
/// time.
pub(super) const BLURRED_CELLS: [[f32; 2]; GRIDS - 1] = [[3.0, 5.0], [1.75, 3.0]];

/// Lobes may look for cells that something hides, or beyond the picture, up to this many of the largest cells away.
pub(super) const MARGIN: u32 = 16;

/// Like [`MARGIN`], in cells of the next coarser grid, for cells that are needed because lobes are narrow in that.
const REACH: usize = 6;

/// Widths of lobes in finest cells: below the first number only the sharp ray counts, and from the second on only the
/// blurred light, because between cells no more is known.
const SHARP_CELLS: [f32; 2] = [HIDDEN_LOBE, 1.4];

/// The place of cells that show no rough mirror.
const NOTHING: u32 = u32::MAX;

/// The cells of a grid: squares of a side, over a picture and a margin around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) cell_px: u32,
    pub(super) width: usize,
    pub(super) height: usize,
    margin_px: f32,
    /// The side of the cells of the finest grid.
    pub(super) finest_px: u32,
}

impl Layout {
    /// The coarsest grid of a view, whose finest one has cells of a side.
    pub(super) fn new(view: &View, finest_px: u32) -> Self {
        let cell_px = finest_px << (GRIDS - 1);
        let [width, height] = [view.width, view.height].map(|side| (side.div_ceil(cell_px) + 2 * MARGIN) as usize);
        Self { cell_px, width, height, margin_px: (MARGIN * cell_px) as f32, finest_px }
    }

    /// The grid of cells of half the side.
    pub(super) fn halved(&self) -> Self {
        Self { cell_px: self.cell_px / 2, width: 2 * self.width, height: 2 * self.height, ..*self }
    }

    /// True if a lobe of a width covers too little of a finest cell to be seen beside the sharp reflection; `extent` is
    /// the solid angle of one of this grid's cells.
    pub(super) fn is_hidden(&self, width: f32, extent: f32) -> bool {
        width * self.cell_px as f32 <= SHARP_CELLS[0] * extent.sqrt() * self.finest_px as f32
    }

    pub(super) fn cell_count(&self) -> usize {
        self.width * self.height
    }

    /// A position of the picture, in cells.
    #[inline(always)]
    fn in_cells(&self, position_px: Vec2) -> Vec2 {
        (position_px + self.margin_px) / self.cell_px as f32
    }

    /// The position of a cell's middle in the picture.
    pub(super) fn middle_px(&self, column: usize, row: usize) -> Vec2 {
        (Vec2::new(column as f32, row as f32) + 0.5) * self.cell_px as f32 - self.margin_px
    }
}

/// The part of a picture that a grid covers.
pub(super) enum Part {
    /// All cells about the rough mirrors that are seen.
    Whole,
    /// Some cells, given by masks over the cells of the next coarser grid.
    Narrow {
        width: usize,
        /// Cells whose light may be asked for.
        wanted: Vec<bool>,
        /// Cells that their lobes may reach.
        reached: Vec<bool>,
    },
}

impl Part {
    pub(super) fn is_wanted(&self, column: usize, row: usize) -> bool {
        match self {
            Self::Whole => true,
            Self::Narrow { width, wanted, .. } => wanted[row / 2 * width + column / 2],
        }
    }

    pub(super) fn is_reached(&self, column: usize, row: usize) -> bool {
        match self {
            Self::Whole => true,
            Self::Narrow { width, reached, .. } => reached[row / 2 * width + column / 2],
        }
    }
}

/// A place of a rough mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) column: u32,
    pub(super) row: u32,
    pub(super) lobe: Lobe,
    /// The distance of the surface that it shows; infinite for the sky.
    pub(super) distance: f32,
    /// The mirror is seen here in the picture; else something hides it, or it lies beyond the picture's edge.
    pub(super) is_seen: bool,
    pub(super) bumps: Bumps,
}

/// The effect of a normal map on a place's light: with bumps, rays of neighbouring cells say little of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bumps {
    /// No normal map.
    None,
    /// A rough surface whose normals the map turns.
    OfRough,
    /// A smooth surface whose normals the map turns within a cell so far that they spread light.
    OfSmooth,
    /// A smooth surface whose normals vary too little within a cell: the sharp reflection is enough.
    Resolved,
}

/// The end of the ray from a place of an object, at most at a greatest distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) position: Vec3,
    pub(super) object: u32,
}

/// The result of tracing a cell.
pub(super) struct Found {
    pub(super) place: Place,
    pub(super) passage: Passage,
    pub(super) sharp: Vec3,
    /// The mean over the lobe, where rays tell it, and that of refracted light.
    pub(super) traced: Option<Vec3>,
    pub(super) refracted: Vec3,
}

/// A grid: for cells that show rough mirrors, places in the order of blocks.
pub(super) struct ReflectedGrid {
    pub(super) layout: Layout,
    /// The place of every cell, rows from the top, or [`NOTHING`].
    index: Vec<u32>,
    pub(super) places: Vec<Place>,
    /// The ray that leaves each place.
    pub(super) passages: Vec<Passage>,
    /// The end of each place's ray.
    pub(super) ends: Vec<End>,
    /// The radiance of each place's sharp ray and 1; 0 where it was not asked for.
    pub(super) sharp: Vec<Vec4>,
    /// The light that each place reflects; where another grid resolves it better, the mean is the light of its own
    /// sharp ray.
    pub(super) light: Vec<RoughLight>,
}

impl ReflectedGrid {
    /// The place of a cell.
    #[inline(always)] // for the instructions of its callers
    pub(super) fn place_of(&self, cell: usize) -> Option<usize> {
        let place = self.index[cell];
        (place != NOTHING).then_some(place as usize)
    }

    /// The cell of a place.
    #[inline(always)] // for the instructions of its callers
    pub(super) fn cell_of(&self, place: usize) -> usize {
        let Place { column, row, .. } = self.places[place];
        row as usize * self.layout.width + column as usize
    }

    /// The grid from the results of blocks of cells.
    pub(super) fn new(layout: Layout, blocks: Vec<Vec<Found>>) -> Self {
        let count = blocks.iter().map(Vec::len).sum();
        let mut grid = Self {
            layout,
            index: vec![NOTHING; layout.cell_count()],
            places: Vec::with_capacity(count),
            passages: Vec::with_capacity(count),
            ends: Vec::with_capacity(count),
            sharp: Vec::with_capacity(count),
            light: Vec::with_capacity(count),
        };
        for found in blocks.into_iter().flatten() {
            grid.push(&found);
        }
        grid
    }

    fn push(&mut self, found: &Found) {
        let Found { place, passage, sharp, traced, refracted } = found;
        let Layout { cell_px, finest_px, .. } = self.layout;
        let width_px = place.lobe.width / passage.cell_extent(passage.distance).sqrt() * cell_px as f32;
        let [narrow, wide] = SHARP_CELLS;
        let weight = match place.bumps {
            Bumps::OfRough => 1.0,
            Bumps::OfSmooth if traced.is_none() => 0.0,
            Bumps::None | Bumps::OfSmooth => ((width_px / finest_px as f32 - narrow) / (wide - narrow)).clamp(0.0, 1.0),
            Bumps::Resolved => 0.0,
        };
        self.index[place.row as usize * self.layout.width + place.column as usize] = self.places.len() as u32;
        self.light.push(RoughLight {
            radiance: traced.unwrap_or(*sharp) * weight,
            refracted: *refracted * weight,
            weight,
            sharp: *sharp,
            share: place.lobe.share,
            distance: place.distance,
            // Bumps are for the finest grid.
            width_px: if place.bumps == Bumps::None { width_px } else { 0.0 },
        });
        self.ends
            .push(End { position: passage.position + passage.direction * passage.distance, object: passage.object });
        self.sharp.push(sharp.extend(if place.bumps == Bumps::Resolved { 0.0 } else { 1.0 }));
        self.places.push(*place);
        self.passages.push(*passage);
    }

    /// The share of the next finer grid in the light at a position, by what this grid knows of it: 1 if the lobe covers
    /// fewer cells than the first number, 0 from the second one on.
    #[inline(always)]
    pub(super) fn finer_share(&self, light: &RoughLight, [narrow, wide]: [f32; 2]) -> f32 {
        ((wide - light.width_px / self.layout.cell_px as f32) / (wide - narrow)).clamp(0.0, 1.0)
    }

    /// The light at a position of the picture, between the cells around it that show the same object.
    #[inline]
    pub(super) fn at(&self, object: u32, position_px: Vec2) -> Option<RoughLight> {
        let Layout { width, height, .. } = self.layout;
        let (mut sum, mut weights) = (RoughLight::default(), 0.0);
        for (cell, weight) in cells_around(self.layout.in_cells(position_px), width, height) {
            let Some(place) = self.place_of(cell) else { continue };
            if self.ends[place].object != object || !self.places[place].is_seen {
                continue;
            }
            // A rim's only cell counts even if the position is on the far side of it.
            let weight = weight.max(1e-4);
            sum = sum.plus(&self.light[place], weight);
            weights += weight;
        }
        (weights > 0.0).then(|| RoughLight::default().plus(&sum, 1.0 / weights))
    }

    /// Cells that show places which are seen and whose lobes cover fewer than so many cells across, or lie beside such
    /// cells.
    pub(super) fn cells_of_narrow_lobes(&self, cells: f32) -> Vec<bool> {
        self.cells_where(|place, light| {
            let is_narrow = light.width_px < cells * self.layout.cell_px as f32;
            place.is_seen && place.bumps != Bumps::Resolved && is_narrow
        })
    }

    /// The cells of places whose lobes cover at least so many cells.
    pub(super) fn cells_of_wide_lobes(&self, cells: f32) -> Vec<bool> {
        self.cells_where(|place, light| place.is_seen && light.width_px >= cells * self.layout.cell_px as f32)
    }

    /// Cells at which the light depends on the sharp reflection at the position itself, and their neighbours.
    pub(super) fn cells_of_sharp_light(&self) -> Vec<bool> {
        self.cells_where(|place, light| place.is_seen && light.weight < 1.0)
    }

    /// True if any of some cells lies in a rectangle of a picture.
    pub(super) fn has_any(&self, cells: &[bool], low_px: Vec2, high_px: Vec2) -> bool {
        self.cells_between(self.layout.in_cells(low_px), self.layout.in_cells(high_px)).any(|cell| cells[cell])
    }

    /// True if all cells in and about a rectangle of a picture show an object whose light is all in them.
    pub(super) fn is_full_of(&self, object: u32, low_px: Vec2, high_px: Vec2) -> bool {
        let is_full = |place: usize| {
            let is_of_object = self.ends[place].object == object && self.places[place].is_seen;
            is_of_object && self.light[place].weight >= 1.0
        };
        let (low, high) = (self.layout.in_cells(low_px) - 1.0, self.layout.in_cells(high_px) + 1.0);
        self.cells_between(low, high).all(|cell| self.place_of(cell).is_some_and(is_full))
    }

    /// The cells from one position to another one, in cells.
    fn cells_between(&self, low: Vec2, high: Vec2) -> impl Iterator<Item = usize> {
        let Layout { width, height, .. } = self.layout;
        let [low, high] = [low, high].map(|at| at.max(Vec2::ZERO));
        let columns = low.x as usize..=(high.x as usize).min(width - 1);
        let rows = low.y as usize..=(high.y as usize).min(height - 1);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    fn cells_where(&self, is_there: impl Fn(&Place, &RoughLight) -> bool) -> Vec<bool> {
        let mut there = vec![false; self.layout.cell_count()];
        for (index, (place, light)) in self.places.iter().zip(&self.light).enumerate() {
            there[self.cell_of(index)] = is_there(place, light);
        }
        dilated(&there, self.layout.width, 1)
    }

    /// The part where lobes cover fewer than so many cells; `None` if there is no such cell.
    pub(super) fn narrow(&self, cells: f32) -> Option<Part> {
        let wanted = self.cells_of_narrow_lobes(cells);
        let reached = dilated(&wanted, self.layout.width, REACH);
        wanted.contains(&true).then_some(Part::Narrow { width: self.layout.width, wanted, reached })
    }
}

/// The four cells of a grid around a position in cells, and their weights for interpolation; at the grid's edges some
/// are the same.
#[inline(always)] // for the instructions of its callers
pub(super) fn cells_around(position: Vec2, width: usize, height: usize) -> [(usize, f32); 4] {
    let at = position - 0.5;
    let low = at.floor();
    let share = at - low;
    let (x, y) = (low.x as i32, low.y as i32);
    let (last_x, last_y) = (width as i32 - 1, height as i32 - 1);
    let (left, right) = (x.clamp(0, last_x) as usize, (x + 1).clamp(0, last_x) as usize);
    let (top, bottom) = (y.clamp(0, last_y) as usize * width, (y + 1).clamp(0, last_y) as usize * width);
    let rest = 1.0 - share;
    [
        (top + left, rest.x * rest.y),
        (top + right, share.x * rest.y),
        (bottom + left, rest.x * share.y),
        (bottom + right, share.x * share.y),
    ]
}

/// The cells of rows of a width within so many of one that is set, along columns and rows.
pub(super) fn dilated(cells: &[bool], width: usize, by: usize) -> Vec<bool> {
    let height = cells.len() / width;
    let along_lines = |cells: &[bool], count: usize, along: usize, lines: usize, across: usize| {
        let mut near = vec![false; cells.len()];
        for line in 0..lines {
            // Counted from the last cell that is set, there and back.
            let mut since = by + 1;
            let there = 0..count;
            for index in there.clone().chain(there.rev()) {
                let cell = line * across + index * along;
                since = if cells[cell] { 0 } else { since + 1 };
                near[cell] |= since <= by;
            }
        }
        near
    };
    let rows = along_lines(cells, width, 1, height, width);
    along_lines(&rows, height, width, width, 1)
}
