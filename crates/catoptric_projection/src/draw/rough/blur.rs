//! Means of the light of grids of sharp rays over the lobes of rough places.

use super::grid::{BLURRED_CELLS, Bumps, Place, ReflectedGrid};
use super::light::RoughLight;
use super::lobe::{Directions, DiscPoints};
use super::passage::Passage;
use super::pyramid::Pyramid;
use catoptric_core::math::lanes::{Lanes, Vec3Lanes};
use catoptric_core::parallel;
use glam::{Vec2, Vec3, Vec4};

/// Places that one call works on.
const PLACES_AT_A_TIME: usize = 256;

/// Directions of a lobe, and of one that covers less than this many of the finest cells across. Chosen between
/// smoothness and time.
const DIRECTIONS: usize = 32;
const FEW_DIRECTIONS: usize = 16;
const FEW_CELLS: f32 = 2.0;

/// Steps to the ray that passes where a direction goes: as the changes of the place's own ray say, and as those of the
/// rays that are found on the way say. For lobes that are narrow, where changes are even, and for others.
const NEAR_STEPS: [usize; 2] = [2, 0];
const WIDE_STEPS: [usize; 2] = [1, 3];

/// Lobes are narrow that cover less than this many of the finest cells across, and less than this many radians.
const NEAR_CELLS: f32 = 8.0;
const NEAR_WIDTH: f32 = 0.15;

/// The inputs of a grid's blur.
struct Blur<'a> {
    grid: &'a ReflectedGrid,
    pyramid: &'a Pyramid<'a>,
    /// The level of the grid's cells, and their side in cells of the finest level.
    level: i32,
    side: f32,
    points: DiscPoints<DIRECTIONS>,
    few_points: DiscPoints<FEW_DIRECTIONS>,
}

/// The blurred light of places of a grid, where it is asked for.
pub(super) fn blurred(grids: &[ReflectedGrid], index: usize, pyramid: &Pyramid<'_>) -> Vec<(usize, RoughLight)> {
    let mut light = asked(grids, index);
    let (level, side) = pyramid.level_of(index);
    let blur = Blur {
        grid: &grids[index],
        pyramid,
        level,
        side,
        points: DiscPoints::new(Vec2::ZERO),
        few_points: DiscPoints::new(Vec2::ZERO),
    };
    parallel::for_each_chunk_mut(&mut light, PLACES_AT_A_TIME, |_, light| blur_places(&blur, light));
    light
}

/// Places of a grid that are seen where neither a coarser nor a finer grid has all of their light, with the light known
/// so far.
fn asked(grids: &[ReflectedGrid], index: usize) -> Vec<(usize, RoughLight)> {
    let grid = &grids[index];
    let is_narrow = index.checked_sub(1).map(|coarser| grids[coarser].cells_of_narrow_lobes(BLURRED_CELLS[coarser][1]));
    let is_wide = (index + 1 < grids.len()).then(|| grid.cells_of_wide_lobes(BLURRED_CELLS[index][0]));
    let is_asked = |place: &usize| {
        let Place { column, row, is_seen, bumps, .. } = grid.places[*place];
        let (column, row, width) = (column as usize, row as usize, grid.layout.width);
        let is_narrow = is_narrow.as_ref().is_none_or(|narrow| narrow[row / 2 * (width / 2) + column / 2]);
        is_seen && bumps == Bumps::None && is_narrow && is_wide.as_ref().is_none_or(|wide| wide[row * width + column])
    };
    (0..grid.places.len()).filter(is_asked).map(|place| (place, grid.light[place])).collect()
}

/// Adds the means over the lobes of places to their light.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn blur_places(blur: &Blur<'_>, places: &mut [(usize, RoughLight)]) {
    for (place, light) in places {
        if light.weight > 0.0 {
            let finest_cells = light.width_px / blur.grid.layout.cell_px as f32 * blur.side;
            let is_near = finest_cells < NEAR_CELLS && blur.grid.places[*place].lobe.width < NEAR_WIDTH;
            let mean = match (is_near, finest_cells) {
                (true, ..FEW_CELLS) => blur.mean(*place, &blur.few_points, NEAR_STEPS),
                (true, _) => blur.mean(*place, &blur.points, NEAR_STEPS),
                (false, _) => blur.mean(*place, &blur.points, WIDE_STEPS),
            };
            light.radiance = mean.unwrap_or(light.sharp) * light.weight;
        }
    }
}

impl Blur<'_> {
    /// The mean over the lobe of a place; `None` where nothing of it is known.
    #[inline(always)] // for the instructions of its caller
    fn mean<const N: usize>(
        &self,
        place: usize,
        points: &DiscPoints<N>,
        [near_steps, steps]: [usize; 2],
    ) -> Option<Vec3> {
        let Self { grid, pyramid, level, side, .. } = *self;
        let own = &grid.passages[place];
        let directions = grid.places[place].lobe.directions(points);
        let mut found = Found::<N>::at(grid, place);
        let cell = Vec2::new(found.column[0], found.row[0]);
        for _ in 0..near_steps {
            found.step_from_own(grid, own, cell, &directions);
        }
        if steps > 0 {
            found.step_on_the_way(grid, own, &directions, steps);
        }
        // Cells that a direction's part covers.
        let mut cells = Lanes::<N>::ZERO;
        for lane in 0..N {
            cells[lane] = directions.extent[lane] / own.cell_extent(found.distance[lane]);
        }
        let mut sum = Vec4::ZERO;
        for lane in 0..N {
            let share = directions.share[lane];
            if share > 0.0 {
                // The base-4 logarithm, rounded down: cells overlap when they are interpolated.
                let coarser = ((cells[lane].to_bits() >> 23) as i32 - 127) >> 1;
                let position = Vec2::new(found.column[lane], found.row[lane]) * side;
                sum += pyramid.at(position, level + coarser) * share;
            }
        }
        (sum.w > 1e-3).then(|| sum.truncate() * (directions.kept / sum.w))
    }
}

/// The positions in a grid of the sharp rays that pass where the directions of a lobe go.
struct Found<const N: usize> {
    /// Positions in cells.
    column: Lanes<N>,
    row: Lanes<N>,
    /// The distance from the place to the surface that these rays show.
    distance: Lanes<N>,
    /// 1 while a direction is followed, else 0.
    follows: Lanes<N>,
    /// The longest step: over more of the grid, rays hardly differ, and do not say where to go.
    longest: f32,
}

/// Passages side by side.
struct Passages<const N: usize>([[f32; N]; 15]);

impl<const N: usize> Passages<N> {
    #[inline(always)] // for the instructions of its callers
    fn set(&mut self, lane: usize, passage: &Passage) {
        let Passage { position, direction, start, growth, distance, .. } = passage;
        let fields = [
            [position.x, position.y, position.z],
            [direction.x, direction.y, direction.z],
            [start[0], start[1], start[2]],
            [start[3], growth[0], growth[1]],
            [growth[2], growth[3], *distance],
        ];
        for (group, three) in fields.iter().enumerate() {
            for (index, value) in three.iter().enumerate() {
                self.0[3 * group + index][lane] = *value;
            }
        }
    }

    #[inline(always)] // for the instructions of its callers
    fn of(&self, lane: usize) -> Passage {
        let at = |field: usize| self.0[field][lane];
        Passage {
            position: Vec3::new(at(0), at(1), at(2)),
            direction: Vec3::new(at(3), at(4), at(5)),
            start: [at(6), at(7), at(8), at(9)],
            growth: [at(10), at(11), at(12), at(13)],
            distance: at(14),
            object: 0,
        }
    }
}

impl<const N: usize> Found<N> {
    /// The start of the search: all directions at the place's own cell.
    #[inline(always)] // for the instructions of its caller
    fn at(grid: &ReflectedGrid, place: usize) -> Self {
        let Place { column, row, .. } = grid.places[place];
        Self {
            column: Lanes::splat(column as f32 + 0.5),
            row: Lanes::splat(row as f32 + 0.5),
            distance: Lanes::splat(grid.passages[place].distance),
            follows: Lanes::splat(1.0),
            longest: 0.25 * grid.layout.width as f32,
        }
    }

    /// The way of a lane, no longer than the longest.
    #[inline(always)] // for the instructions of its caller
    fn limited(&self, lane: usize, (x, y): (f32, f32)) -> (f32, f32) {
        let length2 = x * x + y * y;
        let scale = if length2 > self.longest * self.longest { self.longest / length2.sqrt() } else { 1.0 };
        (x * scale * self.follows[lane], y * scale * self.follows[lane])
    }

    /// Goes to the rays that, as the changes of the place's own ray say, pass through the points in the lobe's
    /// directions that are as far away as the surfaces found.
    #[inline(always)] // for the instructions of its caller
    fn step_from_own(&mut self, grid: &ReflectedGrid, own: &Passage, own_cell: Vec2, directions: &Directions<N>) {
        let (mut right, mut down) = ([0.0f32; N], [0.0f32; N]);
        for lane in 0..N {
            let goal = own.position + directions.of(lane) * self.distance[lane];
            (right[lane], down[lane]) = self.limited(lane, own.cells_to(goal));
        }
        let mut ends = Vec3Lanes::<N>::ZERO;
        for lane in 0..N {
            self.go(grid, own.object, lane, own_cell, Vec2::new(right[lane], down[lane]), |lane, place| {
                ends.set(lane, grid.ends[place].position);
            });
        }
        for lane in 0..N {
            self.set_distance(lane, ends.vector(lane) - own.position);
        }
    }

    /// Moves the positions some times by the differentials of the rays that were found.
    #[inline(always)] // for the instructions of its caller
    fn step_on_the_way(&mut self, grid: &ReflectedGrid, own: &Passage, directions: &Directions<N>, steps: usize) {
        let mut passages = Passages([[0.0; N]; 15]);
        for lane in 0..N {
            let place = grid.place_at(Vec2::new(self.column[lane], self.row[lane]), own.object);
            passages.set(lane, place.map_or(own, |place| &grid.passages[place]));
        }
        for step in 0..steps {
            let (mut right, mut down) = ([0.0f32; N], [0.0f32; N]);
            for lane in 0..N {
                let goal = own.position + directions.of(lane) * self.distance[lane];
                (right[lane], down[lane]) = self.limited(lane, passages.of(lane).cells_to(goal));
            }
            let is_last = step + 1 == steps;
            for lane in 0..N {
                let middle = Vec2::new(self.column[lane], self.row[lane]).floor() + 0.5;
                self.go(grid, own.object, lane, middle, Vec2::new(right[lane], down[lane]), |lane, place| {
                    if !is_last {
                        passages.set(lane, &grid.passages[place]);
                    }
                });
            }
            if is_last {
                break;
            }
            for lane in 0..N {
                let Passage { position, direction, distance, .. } = passages.of(lane);
                self.set_distance(lane, position + direction * distance - own.position);
            }
        }
    }

    #[inline(always)] // for the instructions of its caller
    fn set_distance(&mut self, lane: usize, shown: Vec3) {
        let distance = (shown.x * shown.x + shown.y * shown.y + shown.z * shown.z).sqrt();
        self.distance[lane] = if self.follows[lane] > 0.0 { distance } else { self.distance[lane] };
    }

    /// Moves a lane some way from a cell if the same mirror is seen there, and tells the place; else as far as it is
    /// seen on the way, and no further.
    #[inline(always)] // for the instructions of its caller
    fn go(
        &mut self,
        grid: &ReflectedGrid,
        object: u32,
        lane: usize,
        from: Vec2,
        way: Vec2,
        mut arrive: impl FnMut(usize, usize),
    ) {
        if self.follows[lane] == 0.0 {
            return;
        }
        let next = from + way;
        if let Some(place) = grid.place_at(next, object) {
            (self.column[lane], self.row[lane]) = (next.x, next.y);
            return arrive(lane, place);
        }
        let half = from + way * 0.5;
        if grid.place_at(half, object).is_some() {
            (self.column[lane], self.row[lane]) = (half.x, half.y);
        }
        self.follows[lane] = 0.0;
    }
}

impl ReflectedGrid {
    /// The place of the cell at a position, in cells, if it shows an object.
    #[inline(always)] // for the instructions of its caller
    fn place_at(&self, position: Vec2, object: u32) -> Option<usize> {
        let (x, y) = (position.x.floor() as i32, position.y.floor() as i32);
        if (x as u32) >= self.layout.width as u32 || (y as u32) >= self.layout.height as u32 {
            return None;
        }
        let place = self.place_of(y as usize * self.layout.width + x as usize)?;
        (self.ends[place].object == object).then_some(place)
    }
}
