//! Means over the lobes of rough places, of what a grid of sharp rays shows.

use super::RoughLight;
use super::grid::{Cell, Place, ReflectedGrid, cells_around};
use crate::math::random;
use crate::parallel;
use crate::scene::Scene;
use crate::scene::microfacets::{ReflectanceTable, extent_of_sample, unshadowed_share, visible_facet};
use glam::{Vec2, Vec3};

/// Cells that one call works on.
const CELLS_AT_A_TIME: usize = 256;

/// How closely a lobe is looked at. Chosen between smoothness and time.
struct Effort {
    /// Directions that are looked for.
    directions: u32,
    /// Steps to the ray that passes where a direction goes.
    steps: usize,
}

impl Effort {
    /// For lobes that cover so many cells across.
    fn for_width(cells: f32) -> Self {
        match cells {
            // There, rays hardly differ from what their changes say.
            ..8.0 => Self { directions: 20, steps: 2 },
            _ => Self { directions: 32, steps: 3 },
        }
    }
}

/// Cells overlap when they are interpolated: a finer level than the one whose cells cover a direction's part.
const LEVEL_BIAS: f32 = -0.5;

/// Lobes that cover less than this many cells across are what the sharp ray shows, and from the second on blurred
/// alone: between cells no more is known.
const SHARP_CELLS: f32 = 0.12;
const BLURRED_CELLS: f32 = 0.55;

/// The width of a lobe of mirrored directions where it is half as bright as in its middle, in units of alpha: the
/// distribution falls to a half at a tangent of 0.64 alpha, and mirrored directions turn twice as far.
const FULL_WIDTH: f32 = 2.57;

/// Radiance of a grid and of coarser ones, each of half the width and height, with the share of every cell that shows
/// rough mirrors; radiance is times that.
struct Pyramid {
    levels: Vec<Level>,
}

/// Radiance and share of each cell, rows from the top.
struct Level {
    width: usize,
    height: usize,
    cells: Vec<(Vec3, f32)>,
}

impl Level {
    /// The means of four cells each.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mean = |cell: usize| {
            let (x, y) = (cell % width * 2, cell / width * 2);
            let mut sum = (Vec3::ZERO, 0.0);
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                if x + dx < self.width && y + dy < self.height {
                    let (radiance, share) = self.cells[(y + dy) * self.width + x + dx];
                    sum = (sum.0 + radiance * 0.25, sum.1 + share * 0.25);
                }
            }
            sum
        };
        Self { width, height, cells: (0..width * height).map(mean).collect() }
    }
}

impl Pyramid {
    fn new(grid: &ReflectedGrid) -> Self {
        let mut finest = vec![(Vec3::ZERO, 0.0); grid.width * grid.height];
        for cell in grid.cells() {
            finest[cell.row * grid.width + cell.column] = (grid.sharp[cell.place], 1.0);
        }
        let mut levels = vec![Level { width: grid.width, height: grid.height, cells: finest }];
        while let Some(finer) = levels.last().filter(|level| level.width.max(level.height) > 1) {
            levels.push(finer.halved());
        }
        Self { levels }
    }

    /// The mean radiance around a position (in cells) over about 2 to the power of `level` cells; `None` where no rough
    /// mirror is seen.
    #[inline(always)] // for the instructions of its caller
    fn at(&self, position: Vec2, level: f32) -> Option<Vec3> {
        let level = level.clamp(0.0, self.levels.len() as f32 - 1.001);
        let (fine, coarse) = (self.at_whole(position, level as usize), self.at_whole(position, level as usize + 1));
        let share = level.fract();
        let sum = (fine.0 + (coarse.0 - fine.0) * share, fine.1 + (coarse.1 - fine.1) * share);
        (sum.1 > 1e-3).then(|| sum.0 / sum.1)
    }

    #[inline(always)] // for the instructions of its caller
    fn at_whole(&self, position: Vec2, level: usize) -> (Vec3, f32) {
        let Level { width, height, cells } = &self.levels[level.min(self.levels.len() - 1)];
        let mut sum = (Vec3::ZERO, 0.0);
        for (cell, weight) in cells_around(position / (1u32 << level) as f32, *width, *height) {
            let (radiance, part) = cells[cell];
            sum = (sum.0 + radiance * weight, sum.1 + part * weight);
        }
        sum
    }
}

/// Sets the blurred light of all places of a grid.
pub(super) fn blur(scene: &Scene, grid: &mut ReflectedGrid) {
    let pyramid = Pyramid::new(grid);
    // Beyond, nothing moves in what a place sees.
    let far = 100.0 * scene.bounds.diagonal().max(f32::MIN_POSITIVE);
    // Cells and places are in the same order.
    let (known, cells) = (&*grid, grid.cells());
    let mut light = vec![RoughLight::default(); cells.len()];
    parallel::for_each_chunk_mut(&mut light, CELLS_AT_A_TIME, |chunk, light| {
        means(known, &pyramid, far, &cells[chunk * CELLS_AT_A_TIME..], light);
    });
    grid.light = light;
}

/// The means over the lobes of cells' places, of as many as there is room for.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn means(grid: &ReflectedGrid, pyramid: &Pyramid, far: f32, cells: &[Cell], light: &mut [RoughLight]) {
    for (light, cell) in light.iter_mut().zip(cells) {
        if grid.places[cell.place].is_seen {
            *light = mean(grid, pyramid, far, cell);
        }
    }
}

/// The mean over the lobe of a cell's place.
#[inline(always)] // for the instructions of its caller
fn mean(grid: &ReflectedGrid, pyramid: &Pyramid, far: f32, cell: &Cell) -> RoughLight {
    let (place, sharp) = (&grid.places[cell.place], grid.sharp[cell.place]);
    let own = Vec2::new(cell.column as f32 + 0.5, cell.row as f32 + 0.5);
    let (across, along) = place.normal.any_orthonormal_pair();
    let viewer = place.towards_viewer;
    let local = Vec3::new(viewer.dot(across), viewer.dot(along), viewer.dot(place.normal).max(1e-3));
    let alpha = place.alpha;
    let reflected = ReflectanceTable::get().reflected(alpha.sqrt(), local.z);
    let share = reflected.at_normal + reflected.at_grazing;
    let cells = alpha / cell_extent(place, place.distance.min(far)).max(1e-18).sqrt();
    let width_px = FULL_WIDTH * cells * grid.cell_px as f32;
    let weight = ((cells - SHARP_CELLS) / (BLURRED_CELLS - SHARP_CELLS)).clamp(0.0, 1.0);
    let mut light = RoughLight { radiance: sharp * weight, weight, sharp, share, distance: place.distance, width_px };
    if weight <= 0.0 {
        return light;
    }
    let effort = Effort::for_width(FULL_WIDTH * cells);
    let mut sum = Vec3::ZERO;
    let mut share_sum = 0.0;
    for index in 0..effort.directions {
        let facet = visible_facet(alpha, local, random::hammersley(index, effort.directions));
        let direction = facet * (2.0 * local.dot(facet)) - local;
        let share = unshadowed_share(alpha, direction.z, local.z);
        let towards = across * direction.x + along * direction.y + place.normal * direction.z;
        if share <= 0.0 || towards.dot(place.geometric) <= 0.0 {
            continue;
        }
        let (position, distance) = find(grid, place, own, towards, far, effort.steps);
        // Against the solid angle of a cell there.
        let extent = extent_of_sample(alpha, facet.z, local.z, effort.directions);
        let level = LEVEL_BIAS + 0.5 * (extent / cell_extent(place, distance).max(1e-12)).log2();
        let found = pyramid.at(position, level).unwrap_or(sharp);
        sum += found * share;
        share_sum += share;
    }
    if share_sum > 0.0 {
        light.radiance = sum * (weight / share_sum);
    }
    light
}

/// The solid angle that a cell's rays cover at a distance, seen from the place.
#[inline(always)] // for the instructions of its caller
fn cell_extent(place: &Place, distance: f32) -> f32 {
    let change = &place.change;
    let moved = |origin: Vec3, direction: Vec3| {
        (origin + direction * distance).reject_from_normalized(place.direction) / distance.max(1e-12)
    };
    let dx = moved(change.origin_dx, change.direction_dx);
    let dy = moved(change.origin_dy, change.direction_dy);
    dx.cross(dy).length()
}

/// The position in the grid, in cells, of the sharp ray that passes where a direction from a place goes, and how far
/// away what it shows is from that place.
#[inline(always)] // for the instructions of its caller
fn find(grid: &ReflectedGrid, from: &Place, own: Vec2, towards: Vec3, far: f32, steps: usize) -> (Vec2, f32) {
    let (mut position, mut place) = (own, from);
    let mut distance = from.distance.min(far);
    for _ in 0..steps {
        let goal = from.position + towards * distance;
        // From the point that the place's own ray has next to the goal, to the goal.
        let along = (goal - place.position).dot(place.direction).max(0.0);
        let missing = goal - (place.position + place.direction * along);
        let change = &place.change;
        let [dx, dy] = [(change.origin_dx, change.direction_dx), (change.origin_dy, change.direction_dy)]
            .map(|(origin, direction)| (origin + direction * along).reject_from_normalized(place.direction));
        let (xx, xy, yy) = (dx.length_squared(), dx.dot(dy), dy.length_squared());
        let determinant = xx * yy - xy * xy;
        if determinant <= 1e-12 * xx * yy || !determinant.is_finite() {
            break;
        }
        let (mx, my) = (missing.dot(dx), missing.dot(dy));
        let step = Vec2::new(yy * mx - xy * my, xx * my - xy * mx) / determinant;
        if !step.is_finite() {
            break;
        }
        let step = step.clamp_length_max(0.25 * grid.width as f32);
        let base = if std::ptr::eq(place, from) { own } else { center(position) };
        let next = base + step;
        let Some(found) = grid.place_at(next, from.object) else {
            // Beyond the mirror's picture: as far as it is seen on the way.
            let half = base + step * 0.5;
            if grid.place_at(half, from.object).is_some() {
                position = half;
            }
            break;
        };
        (position, place) = (next, found);
        let shown = if found.distance.is_finite() { found.position + found.direction * found.distance } else { goal };
        distance = if found.distance.is_finite() { (shown - from.position).length().min(far) } else { far };
    }
    (position, distance)
}

/// The middle of the cell at a position.
#[inline(always)] // for the instructions of its caller
fn center(position: Vec2) -> Vec2 {
    position.floor() + 0.5
}

impl ReflectedGrid {
    /// The place of the cell at a position, in cells, if it shows an object.
    #[inline(always)] // for the instructions of its caller
    fn place_at(&self, position: Vec2, object: u32) -> Option<&Place> {
        let (x, y) = (position.x.floor(), position.y.floor());
        if x < 0.0 || y < 0.0 || x >= self.width as f32 || y >= self.height as f32 {
            return None;
        }
        let place = &self.places[self.place_of(y as usize * self.width + x as usize)?];
        (place.object == object).then_some(place)
    }
}
