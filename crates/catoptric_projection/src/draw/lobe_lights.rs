//! Light over the wide lobes of the surfaces in a picture, from rays that neighbours share.
//!
//! Rays leave the middle of every cell of pixels; each cell then takes the mean over its lobes from the rays of all
//! cells around it. Where things are so near that these see something else, as at contacts, more rays of its own make
//! up for them. Pixels take theirs from the four nearest cells that show the same surface: all the light of a lobe that
//! is like those of the cells, as on smooth surfaces, else the share of light that arrives. Where there are no such
//! cells, as at rims and on thin things, rays of their own tell.
//!
//! Cells are large first. Smaller ones follow only where the light may change within the large ones: near other things,
//! where surfaces are bent, and at edges of shadows.

use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::shade::{SurfaceInteraction, SurfacePoint};
use catoptric_core::scene::{Material, Microfacets, Ray, RayDifferential, ViewRays};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::path_tracer::{
    LOBES, LobeLight, NearPlane, PathModel, PathTracer, SharedLight, SharedRays,
};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::light::wide_hierarchy::Treelet;
use catoptric_engine::method::Job;
use glam::{UVec2, Vec2, Vec3};
use std::ops::Range;

/// The sides of cells, in pixels: smaller ones are for where the larger ones do not tell the light between them.
const CELLS_PX: [u32; 4] = [16, 8, 4, 2];

/// Cells are tried where the light seems to be smooth on ones that are smaller by this factor; where nothing is known
/// of it, if they are no smaller than this many pixels.
const TRIED: f32 = 0.7;
const LEAST_EDGE_PX: f32 = 8.0;

/// Cells on each side of one whose rays it takes. Those at the rim count for half: so every place of a square of four
/// by four counts once.
const NEIGHBOURS: usize = 2;
const RIM: f32 = 0.5;

/// Rows of cells that are worked on at once: rays of all cells of a large picture would take much memory.
const BAND: usize = 32;

/// Cells of a row that are traced together.
const RUN: usize = 32;

/// A cell's surface is another one where it lies further before or behind a place's plane, in sizes of a cell; and
/// where the cosine between normals is smaller.
const APART: f32 = 1.5;
const TURNED: f32 = 0.7;

/// The least share of a place's neighbourhood that shows the same surface; and the same where the light is smooth, or
/// smaller cells tell more.
const LEAST_WEIGHT: f32 = 1e-3;
const LEAST_WEIGHT_SMOOTH: f32 = 0.1;

/// Cells of a row, as far as something is known of them.
type Row<T> = Vec<Option<Box<T>>>;

/// The surface that the middle of a cell shows.
#[derive(Clone, Copy)]
struct Place {
    object: u32,
    position: Vec3,
    geometric_normal: Vec3,
    /// The longer side of the cell on the surface.
    side: f32,
}

impl Place {
    /// Returns true if a point lies on the same part of the surface.
    fn shows(&self, point: &SurfacePoint) -> bool {
        let apart = (self.position - point.position).dot(self.geometric_normal).abs();
        let is_turned = self.geometric_normal.dot(point.geometric_normal) < TURNED;
        self.object == point.object && apart <= APART * self.side && !is_turned
    }
}

/// A place with the rays of its lobes.
struct TracedPlace {
    place: Place,
    rays: [Option<SharedRays>; LOBES],
    /// The ray of the eye, its change to its neighbours, and where it meets the surface.
    seen: (Ray, RayDifferential, SurfaceInteraction),
    /// True if it has other lobes, too.
    has_others: bool,
}

/// A place with the light over its lobes.
struct LitPlace {
    place: Place,
    lights: [Option<LobeLight>; LOBES],
    /// The side of cells, in pixels, up to which they change so little that pixels between need no smaller ones.
    smooth_px: f32,
    /// True if the lobes have all the light that rays of the pixel's own would find.
    is_whole: bool,
}

/// The cells that tell the light in the middle of a cell.
#[derive(Clone, Copy, PartialEq)]
enum ToldBy {
    /// Larger ones, or none: it shows no lobes.
    Larger,
    /// Cells of its size, if the light is smooth on them.
    Own,
    /// Smaller ones: it is not tried.
    Smaller,
}

/// The light over the lobes of surfaces that are seen directly in a picture.
pub(super) struct LobeLights {
    /// The largest cells first.
    grids: Vec<Grid>,
    /// Objects of which some cell tells some light.
    told: Vec<bool>,
}

impl LobeLights {
    /// The light of a view's surfaces; `None` if none has lobes.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(super) fn new(job: &Job<'_>, tracer: &Tracer) -> Result<Option<Self>, RenderError> {
        let Job { scene, view, quality, progress } = *job;
        let has_lobes = |object: u32| may_have_wide_lobes(scene.material_of(object));
        if quality.order == 0 || !(0..scene.objects.len() as u32).any(has_lobes) {
            return Ok(None);
        }
        let empty = CELLS_PX.map(|cell_px| Grid::empty(cell_px, [view.width, view.height]));
        let row_count = empty.iter().map(|grid| grid.size[1]).sum();
        let stage = Stage::begin(progress, "light over lobes", row_count)?;
        let mut lights = Self { grids: Vec::with_capacity(empty.len()), told: Vec::new() };
        for grid in empty {
            let cells = Cells { job, tracer, rays: view.rays(), near: NearPlane::new(view), grid, larger: &lights };
            let grid = cells.lit(&stage)?;
            lights.grids.push(grid);
        }
        let mut told = vec![false; scene.objects.len()];
        let lit = lights.grids.iter().flat_map(|grid| grid.rows.iter().flatten().flatten());
        for lit in lit.filter(|lit| lit.lights.iter().any(Option::is_some)) {
            told[lit.place.object as usize] = true;
        }
        lights.told = told;
        Ok(Some(lights))
    }

    /// True if the light over an object's lobes is known in some cells.
    pub(super) fn tell_of(&self, object: u32) -> bool {
        self.told[object as usize]
    }

    /// The light over the lobes of a point that is seen at a position of the picture, in pixels: `None` where it is not
    /// known. Tells whether that is all the light that rays would find.
    pub(super) fn at(&self, position: Vec2, point: &SurfacePoint) -> ([Option<LobeLight>; LOBES], bool) {
        match (self.smooth_at(position, point), self.grids.last()) {
            (Some(nearest), _) => nearest.mean(),
            (None, Some(smallest)) => smallest.nearest(position, point).mean(),
            (None, None) => ([None; LOBES], false),
        }
    }

    /// True if cells near a position of the picture, in pixels, tell all the light of an object there.
    pub(super) fn tell_all(&self, position: Vec2, object: u32) -> bool {
        let is_told = |lit: &LitPlace| lit.place.object == object && lit.is_whole;
        let is_told_near =
            |grid: &Grid| grid.around(position).iter().any(|(cell, _)| grid.lit(*cell).is_some_and(is_told));
        self.tell_of(object) && self.grids.iter().any(is_told_near)
    }

    /// The largest cells around a point that all show its surface, on which the light is smooth.
    fn smooth_at(&self, position: Vec2, point: &SurfacePoint) -> Option<Nearest<'_>> {
        self.grids.iter().map(|grid| grid.nearest(position, point)).find(Nearest::is_smooth)
    }
}

/// Returns true if a material's lobes may be wider than a line somewhere.
fn may_have_wide_lobes(material: &Material) -> bool {
    let has_maps = material.normal_map.is_some() || material.coat_normal_map.is_some();
    let is_rough = |facets: &Microfacets| {
        let of_coat = if material.coat > 0.0 { facets.coat_roughness } else { 0.0 };
        facets.roughness > 0.0 || of_coat > 0.0 || has_maps
    };
    !material.unlit && material.lobes().is_some() && material.microfacets.as_ref().is_some_and(is_rough)
}

/// Cells of one size.
struct Grid {
    cell_px: u32,
    /// Columns and rows.
    size: [usize; 2],
    /// Rows of cells, those with lobes; without those where larger cells tell as much.
    rows: Vec<Row<LitPlace>>,
    /// The cells that tell the light, in rows.
    told_by: Vec<Vec<ToldBy>>,
}

impl Grid {
    /// A grid without cells as yet, for a picture of a size in pixels.
    fn empty(cell_px: u32, size_px: [u32; 2]) -> Self {
        Self {
            cell_px,
            size: size_px.map(|pixels| pixels.div_ceil(cell_px) as usize),
            rows: Vec::new(),
            told_by: Vec::new(),
        }
    }

    /// The middle of a cell, in pixels.
    fn middle(&self, column: usize, row: usize) -> Vec2 {
        (UVec2::new(column as u32, row as u32).as_vec2() + 0.5) * self.cell_px as f32
    }

    /// The four cells nearest to a position of the picture, each by its column and row, with their weights.
    fn around(&self, position: Vec2) -> [([usize; 2], f32); 4] {
        let at = position / self.cell_px as f32 - 0.5;
        let (first, share) = (at.floor(), at - at.floor());
        let last = [self.size[0] - 1, self.size[1] - 1];
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| {
            let place = (first + Vec2::new(x as f32, y as f32)).max(Vec2::ZERO);
            let cell = [(place.x as usize).min(last[0]), (place.y as usize).min(last[1])];
            (cell, [1.0 - share.x, share.x][x] * [1.0 - share.y, share.y][y])
        })
    }

    /// The light of a cell by its column and row, if it shows lobes.
    fn lit(&self, [column, row]: [usize; 2]) -> Option<&LitPlace> {
        self.rows.get(row)?.get(column)?.as_deref()
    }

    /// The four cells nearest to a position of the picture, as far as they show a point's surface.
    fn nearest(&self, position: Vec2, point: &SurfacePoint) -> Nearest<'_> {
        let mut is_tried = true;
        let cells = self.around(position).map(|([column, row], weight)| {
            is_tried &= self.told_by.get(row)?.get(column)? != &ToldBy::Smaller;
            Some((self.lit([column, row]).filter(|lit| lit.place.shows(point))?, weight))
        });
        Nearest { cell_px: self.cell_px, is_tried, cells }
    }
}

/// The cells nearest to a point that show its surface, each with its weight.
struct Nearest<'a> {
    cell_px: u32,
    /// False if smaller cells tell the light of one of them.
    is_tried: bool,
    cells: [Option<(&'a LitPlace, f32)>; 4],
}

impl Nearest<'_> {
    /// True if the light is smooth on those that show the surface.
    fn is_smooth(&self) -> bool {
        let weight: f32 = self.cells.iter().flatten().map(|(_, weight)| weight).sum();
        self.is_tried
            && weight >= LEAST_WEIGHT_SMOOTH
            && self.smooth_px().is_some_and(|smooth| smooth >= self.cell_px as f32)
    }

    /// The side of cells on which the light would be smooth, in pixels: that of the least smooth one; `None` if no cell
    /// shows the surface.
    fn smooth_px(&self) -> Option<f32> {
        self.cells.iter().flatten().map(|(lit, _)| lit.smooth_px).reduce(f32::min)
    }

    /// The mean light of each lobe; true if that is all the light that rays would find.
    fn mean(&self) -> ([Option<LobeLight>; LOBES], bool) {
        let mut sums = [(LobeLight::default(), 0.0); LOBES];
        let mut is_whole = None;
        for (lit, weight) in self.cells.iter().flatten() {
            is_whole = Some(is_whole.unwrap_or(true) & lit.is_whole);
            for (sum, light) in sums.iter_mut().zip(&lit.lights) {
                if let Some(light) = light {
                    *sum = (sum.0.plus(light, *weight), sum.1 + weight);
                }
            }
        }
        let lights = sums.map(|(sum, weight)| (weight > LEAST_WEIGHT).then(|| sum.scaled(1.0 / weight)));
        (lights, is_whole.unwrap_or(false))
    }
}

/// The cells of some rows, each row in runs that threads take.
fn by_rows<S, T: Send>(
    stage: &Stage<'_>,
    rows: Range<usize>,
    columns: usize,
    init: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize, Range<usize>) -> Vec<T> + Sync + Send,
) -> Result<Vec<Vec<T>>, Cancelled> {
    let runs = columns.div_ceil(RUN);
    let found = parallel::map_init_collect(rows.len() * runs, init, |scratch, run| {
        let (row, first) = (rows.start + run / runs, run % runs * RUN);
        stage.check().map(|()| work(scratch, row, first..(first + RUN).min(columns)))
    });
    let mut found = found.into_iter();
    rows.map(|_| {
        let mut row = Vec::with_capacity(columns);
        for run in found.by_ref().take(runs) {
            row.append(&mut run?);
        }
        Ok(row)
    })
    .collect()
}

/// The cells of a picture, whose rays are to be traced.
struct Cells<'a, 'j> {
    job: &'a Job<'j>,
    tracer: &'a Tracer,
    rays: ViewRays,
    near: NearPlane,
    grid: Grid,
    /// The light of larger cells.
    larger: &'a LobeLights,
}

impl Cells<'_, '_> {
    /// The cells with their light.
    fn lit(mut self, stage: &Stage<'_>) -> Result<Grid, Cancelled> {
        let [columns, row_count] = self.grid.size;
        let Job { scene, quality, .. } = *self.job;
        let init = || (PathTracer::new(scene, self.tracer, PathModel::Tree, quality.order), Treelet::default());
        self.grid.told_by = by_rows(stage, 0..row_count, columns, Treelet::default, |treelet, row, columns| {
            self.gather(treelet, row, &columns);
            columns.map(|column| self.told_by(treelet, column, row)).collect()
        })?;
        let mut traced: Vec<Row<TracedPlace>> = Vec::with_capacity(row_count);
        let mut rows = Vec::with_capacity(row_count);
        while rows.len() < row_count {
            let band = rows.len()..(rows.len() + BAND).min(row_count);
            let ahead = traced.len()..(band.end + NEIGHBOURS).min(row_count);
            traced.extend(by_rows(stage, ahead, columns, init, |(paths, treelet), row, columns| {
                self.trace(paths, treelet, row, columns)
            })?);
            rows.extend(by_rows(stage, band.clone(), columns, init, |(paths, treelet), row, columns| {
                self.light(paths, treelet, &traced, row, columns)
            })?);
            // These rows are not read again.
            for row in &mut traced[..band.end.saturating_sub(NEIGHBOURS)] {
                *row = Vec::new();
            }
            stage.advance(band.len() as u64)?;
        }
        self.grid.rows = rows;
        Ok(self.grid)
    }

    /// The cells that tell the light in the middle of a cell.
    fn told_by(&self, treelet: &Treelet, column: usize, row: usize) -> ToldBy {
        if self.larger.grids.is_empty() {
            return ToldBy::Own;
        }
        let (scene, at) = (self.job.scene, self.grid.middle(column, row));
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        let hit = self.tracer.first_hit_among(scene, &ray, self.near.distance(&ray), treelet);
        let Some(hit) = hit.filter(|hit| scene.material_of(hit.object(scene)).lobes().is_some()) else {
            return ToldBy::Larger;
        };
        let point = self.tracer.encounter(scene, &ray, &hit, Some(&change)).point;
        if self.larger.smooth_at(at, &point).is_some() {
            ToldBy::Larger
        } else if self.is_smallest() || self.may_be_smooth(at, &point) {
            ToldBy::Own
        } else {
            ToldBy::Smaller
        }
    }

    /// True if a cell, or one that is so many cells away from it at most, tells light.
    fn is_needed(&self, column: usize, row: usize, reach: usize) -> bool {
        let [columns, rows] = self.grid.size;
        around(row, reach, rows)
            .any(|row| self.grid.told_by[row][around(column, reach, columns)].contains(&ToldBy::Own))
    }

    /// True if larger cells do not say that the light is not smooth on cells of this size. At edges, where none of them
    /// shows the surface, rather small ones are not tried.
    fn may_be_smooth(&self, at: Vec2, point: &SurfacePoint) -> bool {
        let cell_px = self.grid.cell_px as f32;
        let smooth_px = self.larger.grids.iter().rev().find_map(|grid| grid.nearest(at, point).smooth_px());
        smooth_px.map_or(cell_px >= LEAST_EDGE_PX, |smooth| smooth >= TRIED * cell_px)
    }

    fn is_smallest(&self) -> bool {
        Some(&self.grid.cell_px) == CELLS_PX.last()
    }

    /// The places of some cells in a row, with their rays: of those whose light is wanted and those around
    /// them.
    fn trace(
        &self,
        paths: &mut PathTracer<'_>,
        treelet: &mut Treelet,
        row: usize,
        columns: Range<usize>,
    ) -> Vec<Option<Box<TracedPlace>>> {
        let wanted: Vec<bool> = columns.clone().map(|column| self.is_needed(column, row, 1 + NEIGHBOURS)).collect();
        if wanted.contains(&true) {
            self.gather(treelet, row, &columns);
        }
        let traced = |(column, is_wanted): (usize, &bool)| {
            let place = is_wanted.then(|| self.traced(paths, treelet, [column as u32, row as u32, 0]))?;
            place.map(Box::new)
        };
        columns.zip(&wanted).map(traced).collect()
    }

    /// Gathers the triangles that the first rays of some cells in a row may meet.
    fn gather(&self, treelet: &mut Treelet, row: usize, columns: &Range<usize>) {
        let [low, high] = [columns.start, columns.end - 1].map(|column| self.grid.middle(column, row));
        self.tracer.gather(&self.rays, low, high, treelet);
    }

    /// The place of a cell in a column and a row, with the rays of a round.
    fn traced(&self, paths: &mut PathTracer<'_>, treelet: &Treelet, number: [u32; 3]) -> Option<TracedPlace> {
        let (scene, at) = (self.job.scene, self.grid.middle(number[0] as usize, number[1] as usize));
        let (ray, change) = self.rays.ray_with_differential(at.x, at.y);
        let hit = self.tracer.first_hit_among(scene, &ray, self.near.distance(&ray), treelet)?;
        scene.material_of(hit.object(scene)).lobes()?;
        let encounter = self.tracer.encounter(scene, &ray, &hit, Some(&change));
        let (rays, has_others) = paths.shared_rays(&ray, &change, &encounter, number);
        if rays.iter().all(Option::is_none) {
            return None;
        }
        let SurfacePoint { object, position, geometric_normal, .. } = encounter.point;
        let on_surface = change.transferred(&ray, hit.distance(), geometric_normal);
        let [across, along] = on_surface.map(|change| change.length() * self.grid.cell_px as f32);
        let side = across.max(along);
        let place = Place { object, position, geometric_normal, side };
        Some(TracedPlace { place, rays, seen: (ray, change, encounter), has_others })
    }

    /// The light over the lobes of some cells in a row, by their rays and those of their neighbours.
    fn light(
        &self,
        paths: &mut PathTracer<'_>,
        treelet: &mut Treelet,
        traced: &[Row<TracedPlace>],
        row: usize,
        columns: Range<usize>,
    ) -> Vec<Option<Box<LitPlace>>> {
        let mut is_gathered = false;
        let cells = columns.clone();
        let lit = cells.map(|column| {
            // Pixels at the rim of such cells lie between these and their neighbours.
            let own = traced[row][column].as_deref().filter(|_| self.is_needed(column, row, 1))?;
            let (lights, smooth_side) = lights(traced, [row, column], &[]);
            let place = own.place;
            let smooth_px = self.grid.cell_px as f32 * (smooth_side / place.side);
            if smooth_px < self.grid.cell_px as f32 && !self.is_smallest() {
                return Some(Box::new(LitPlace { place, lights: [None; LOBES], smooth_px, is_whole: false }));
            }
            let lacking = lights.iter().flatten().map(|light| match light {
                SharedLight::Lacks { rounds } => *rounds,
                _ => 0,
            });
            let lights = match lacking.max().unwrap_or(0) {
                0 => lights,
                rounds => {
                    if !std::mem::replace(&mut is_gathered, true) {
                        self.gather(treelet, row, &columns);
                    }
                    let round = |round| self.traced(paths, treelet, [column as u32, row as u32, round]);
                    let more: Vec<TracedPlace> = (1..=rounds).filter_map(round).collect();
                    self::lights(traced, [row, column], &more).0
                }
            };
            let mut lights = lights.map(|light| match light? {
                SharedLight::Known(light) => Some(light),
                SharedLight::Lacks { .. } | SharedLight::Unknown => None,
            });
            let (ray, change, encounter) = &own.seen;
            paths.add_shown_light(ray, change, encounter, &mut lights);
            let is_known = lights.iter().zip(&own.rays).all(|(light, rays)| light.is_some() == rays.is_some());
            Some(Box::new(LitPlace { place, lights, smooth_px, is_whole: is_known && !own.has_others }))
        });
        lit.collect()
    }
}

/// The numbers of cells at most so far from one of so many, and its own.
fn around(middle: usize, reach: usize, end: usize) -> Range<usize> {
    middle.saturating_sub(reach)..(middle + reach + 1).min(end)
}

/// The light over each lobe of a cell's place, by its rays, those of more rounds, and those of its neighbours; how long
/// cells may be so that it is smooth.
fn lights(
    traced: &[Row<TracedPlace>],
    [row, column]: [usize; 2],
    more: &[TracedPlace],
) -> ([Option<SharedLight>; LOBES], f32) {
    let mut smooth_side = f32::INFINITY;
    let Some(own) = traced[row][column].as_deref() else { return ([const { None }; LOBES], smooth_side) };
    let lights = std::array::from_fn(|lobe| {
        let rays = own.rays[lobe].as_ref()?;
        let mut others = [(rays, 0.0); (2 * NEIGHBOURS + 1).pow(2)];
        let mut count = 0;
        for other_row in around(row, NEIGHBOURS, traced.len()) {
            for other_column in around(column, NEIGHBOURS, traced[row].len()) {
                let Some(other) = traced[other_row][other_column].as_deref() else { continue };
                let apart = (other.place.position - own.place.position).dot(own.place.geometric_normal).abs();
                let is_same = other.place.object == own.place.object && apart <= own.place.side;
                let Some(rays) = other.rays[lobe].as_ref().filter(|_| is_same) else { continue };
                let is_rim = |a: usize, b: usize| a.abs_diff(b) == NEIGHBOURS;
                let factor = [(other_row, row), (other_column, column)]
                    .map(|(a, b)| if is_rim(a, b) { RIM } else { 1.0 })
                    .iter()
                    .product();
                if (other_row, other_column) != (row, column) {
                    others[count] = (rays, factor);
                    count += 1;
                }
            }
        }
        let more = more.iter().filter_map(|place| place.rays[lobe].as_ref()).collect::<Vec<_>>();
        let (light, smooth) = rays.light(own.place.side, &more, &others[..count]);
        smooth_side = smooth_side.min(smooth);
        Some(light)
    });
    (lights, smooth_side)
}
