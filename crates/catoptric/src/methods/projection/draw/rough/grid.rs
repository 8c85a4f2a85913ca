//! Rays through a coarse grid of a picture, and what the mirrors that they meet would show if they were smooth.

use super::{RoughLight, RoughTracers};
use crate::error::RenderError;
use crate::light::path_tracer::{NearPlane, PathModel, PathTracer};
use crate::methods::Job;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::LightStep;
use crate::parallel;
use crate::scene::hit::Hit;
use crate::scene::{Ray, RayDifferential};
use glam::{Vec2, Vec3};

/// Rays from rough mirrors that are seen in rough mirrors: blurred once more, their noise hardly shows.
const RAYS: u32 = 4;

/// Lobes may look for cells that something hides, or beyond the picture, up to so many cells from those that are seen.
const MARGIN: usize = 20;

/// The place of cells that show no rough mirror.
const NOTHING: u32 = u32::MAX;

/// A place of a rough mirror, and the ray that would leave it if it were smooth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The mirror.
    pub(super) object: u32,
    pub(super) alpha: f32,
    pub(super) position: Vec3,
    /// Unit normals on the viewer's side: of shading, and of the flat surface.
    pub(super) normal: Vec3,
    pub(super) geometric: Vec3,
    pub(super) towards_viewer: Vec3,
    pub(super) direction: Vec3,
    /// Changes of the ray from cell to cell.
    pub(super) change: RayDifferential,
    /// The distance of what it shows; infinite for the sky.
    pub(super) distance: f32,
    /// The mirror is seen here in the picture; else something hides it, or it lies beyond the picture's edge.
    pub(super) is_seen: bool,
}

/// A cell that shows a rough mirror.
pub(super) struct Cell {
    pub(super) column: usize,
    pub(super) row: usize,
    pub(super) place: usize,
}

/// The grid. It is wider than the picture by [`MARGIN`] cells on every side.
pub(super) struct ReflectedGrid {
    pub(super) cell_px: u32,
    pub(super) width: usize,
    pub(super) height: usize,
    /// The place of every cell, rows from the top, or [`NOTHING`].
    index: Vec<u32>,
    pub(super) places: Vec<Place>,
    /// Of every place, what its sharp ray shows.
    pub(super) sharp: Vec<Vec3>,
    /// Of every place that is seen, what it reflects.
    pub(super) light: Vec<RoughLight>,
}

impl ReflectedGrid {
    /// The grid of a view, without its blurred light, in a part of the picture.
    pub(super) fn trace(job: &Job<'_>, tracers: &RoughTracers, cell_px: u32, part: &Part) -> Result<Self, RenderError> {
        let view = job.view;
        let [width, height] = [view.width, view.height].map(|side| side.div_ceil(cell_px) as usize + 2 * MARGIN);
        let cells = Cells { job, tracers, cell_px, part };
        let met = parallel::map_stage(job.progress, "rough mirrors", height, |row| {
            (0..width).filter_map(|column| cells.meet(column, row)).collect::<Vec<Met>>()
        })?;
        let mut seen = vec![false; width * height];
        for (row, met) in met.iter().enumerate() {
            for met in met.iter().filter(|met| met.is_seen) {
                seen[row * width + met.column] = true;
            }
        }
        let wanted = dilated(&seen, width, MARGIN);
        let init = || {
            // The rough mirror's own event is one of the path's.
            PathTracer::new(job.scene, &tracers.everything, PathModel::Tree, job.quality.order - 1)
                .with_rough_rays(RAYS, 0, 1.0)
        };
        let rows = parallel::map_init_stage(job.progress, "rough mirrors", height, init, |paths, row| {
            let met = met[row].iter().filter(|met| wanted[row * width + met.column]);
            met.filter_map(|met| Some((met.column, cells.follow(paths, met)?))).collect::<Vec<_>>()
        })?;
        let mut grid = Self {
            cell_px,
            width,
            height,
            index: vec![NOTHING; width * height],
            places: Vec::new(),
            sharp: Vec::new(),
            light: Vec::new(),
        };
        for (row, found) in rows.into_iter().enumerate() {
            for (column, (place, sharp)) in found {
                grid.index[row * width + column] = grid.places.len() as u32;
                grid.places.push(place);
                grid.sharp.push(sharp);
            }
        }
        Ok(grid)
    }

    /// The place of a cell.
    #[inline(always)] // for the instructions of its callers
    pub(super) fn place_of(&self, cell: usize) -> Option<usize> {
        let place = self.index[cell];
        (place != NOTHING).then_some(place as usize)
    }

    /// The cells that show rough mirrors, in the order of their places.
    pub(super) fn cells(&self) -> Vec<Cell> {
        let places = self.index.iter().enumerate().filter(|(_, place)| **place != NOTHING);
        let cell = |(cell, place): (usize, &u32)| Cell {
            column: cell % self.width,
            row: cell / self.width,
            place: *place as usize,
        };
        places.map(cell).collect()
    }

    /// The light at a position of the picture, between the cells around it that show the same object.
    #[inline]
    pub(super) fn at(&self, object: u32, position: Vec2) -> Option<RoughLight> {
        let at = position / self.cell_px as f32 + MARGIN as f32;
        let (mut sum, mut weights) = (RoughLight::default(), 0.0);
        for (cell, weight) in cells_around(at, self.width, self.height) {
            let Some(place) = self.place_of(cell) else { continue };
            if self.places[place].object != object || !self.places[place].is_seen {
                continue;
            }
            // A rim's only cell counts even if the position is on the far side of it.
            let weight = weight.max(1e-4);
            sum = sum.plus(&self.light[place], weight);
            weights += weight;
        }
        (weights > 0.0).then(|| RoughLight::default().plus(&sum, 1.0 / weights))
    }
}

/// The four cells of a grid around a position in cells, and their weights for what is in between; at its edges some are
/// the same.
#[inline(always)] // for the instructions of its callers
pub(super) fn cells_around(position: Vec2, width: usize, height: usize) -> [(usize, f32); 4] {
    let at = position - 0.5;
    let low = at.floor();
    let share = at - low;
    let [left, right] = [0, 1].map(|step| (low.x as i32 + step).clamp(0, width as i32 - 1) as usize);
    let [top, bottom] = [0, 1].map(|step| (low.y as i32 + step).clamp(0, height as i32 - 1) as usize * width);
    let rest = 1.0 - share;
    [
        (top + left, rest.x * rest.y),
        (top + right, share.x * rest.y),
        (bottom + left, rest.x * share.y),
        (bottom + right, share.x * share.y),
    ]
}

/// The part of a picture that a grid covers.
pub(super) enum Part {
    Whole,
    /// Where a coarser grid found lobes that are narrow in its cells.
    Narrow {
        cell_px: u32,
        width: usize,
        /// Cells that show such places, or lie beside them.
        narrow: Vec<bool>,
        /// Cells that their lobes may reach.
        reached: Vec<bool>,
    },
}

impl Part {
    /// Where lobes of a grid cover fewer than so many pixels; `None` where they don't.
    pub(super) fn narrow(grid: &ReflectedGrid, width_px: f32) -> Option<Self> {
        let mut narrow = vec![false; grid.width * grid.height];
        for cell in grid.cells() {
            let light = &grid.light[cell.place];
            narrow[cell.row * grid.width + cell.column] =
                grid.places[cell.place].is_seen && light.width_px < width_px && light.weight > 0.0;
        }
        if !narrow.contains(&true) {
            return None;
        }
        let reached = dilated(&narrow, grid.width, MARGIN / 2 + 1);
        let narrow = dilated(&narrow, grid.width, 1);
        Some(Self::Narrow { cell_px: grid.cell_px, width: grid.width, narrow, reached })
    }

    /// Whether a position of the picture is reached, and whether it is one of those that are asked for.
    fn has(&self, at: Vec2) -> (bool, bool) {
        match self {
            Self::Whole => (true, true),
            Self::Narrow { cell_px, width, narrow, reached } => {
                let cell = (at / *cell_px as f32 + MARGIN as f32).floor();
                let (column, row) = (cell.x.max(0.0) as usize, cell.y.max(0.0) as usize);
                let cell = row * width + column.min(width - 1);
                (reached.get(cell) == Some(&true), narrow.get(cell) == Some(&true))
            }
        }
    }
}

/// A rough mirror that a cell's ray meets.
struct Met {
    column: usize,
    ray: Ray,
    change: RayDifferential,
    hit: Hit,
    is_seen: bool,
}

/// What all cells share.
struct Cells<'a, 'b> {
    job: &'a Job<'b>,
    tracers: &'a RoughTracers,
    cell_px: u32,
    part: &'a Part,
}

impl Cells<'_, '_> {
    /// The rough mirror that a cell's ray meets, hidden or not.
    fn meet(&self, column: usize, row: usize) -> Option<Met> {
        let Job { scene, view, .. } = *self.job;
        let cell = Vec2::new(column as f32, row as f32) - (MARGIN as f32 - 0.5);
        let at = cell * self.cell_px as f32;
        let (is_reached, is_wanted) = self.part.has(at);
        if !is_reached {
            return None;
        }
        let RoughTracers { everything, mirrors } = self.tracers;
        let (ray, change) = view.ray_with_differential(at.x, at.y);
        let near = NearPlane::new(view).distance(&ray);
        let hit = mirrors.first_hit(scene, &ray, near)?;
        let is_inside = at.cmpge(Vec2::ZERO).all() && at.x < view.width as f32 && at.y < view.height as f32;
        let first = || everything.first_hit(scene, &ray, near);
        // Both hierarchies meet a mirror at the same distance, to the bit.
        let is_seen = is_wanted && is_inside && first().is_some_and(|first| first.distance() >= hit.distance());
        Some(Met { column, ray, change: change.scaled(self.cell_px as f32), hit, is_seen })
    }

    /// The place that was met, and what its sharp ray shows.
    fn follow(&self, paths: &mut PathTracer<'_>, met: &Met) -> Option<(Place, Vec3)> {
        let (scene, ray, tracer) = (self.job.scene, &met.ray, &self.tracers.everything);
        let encounter = tracer.encounter(scene, ray, &met.hit, Some(&met.change));
        let object = encounter.point.object;
        let material = scene.material_of(object);
        let encounter = scene.turned_encounter(material, &encounter);
        let step = LightStep::at(scene, material, &encounter.point, ray.direction);
        let direction = step.outgoing(BounceKind::Reflect, ray.direction).filter(|_| step.reflected != Vec3::ZERO)?;
        let change = step.outgoing_change(BounceKind::Reflect, ray.direction, &met.change, &encounter);
        let leaving = Ray { origin: tracer.departure(&encounter.point, direction), direction };
        let (radiance, distance) = paths.radiance_and_distance(leaving, Some(change));
        let place = Place {
            object,
            alpha: material.reflection_roughness().powi(2),
            position: encounter.point.position,
            normal: step.facing.normal,
            geometric: step.facing.geometric,
            towards_viewer: -ray.direction,
            direction,
            change,
            distance,
            is_seen: met.is_seen,
        };
        Some((place, radiance))
    }
}

/// The cells of rows of a width within so many of one that is set, along columns and rows.
fn dilated(cells: &[bool], width: usize, by: usize) -> Vec<bool> {
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
