//! The full pixels of a path in a root tile: squares with one bundle each, divided until it is accurate.

use super::super::bundles::beam::{Beam, CandidateList};
use super::super::bundles::bundle::{BundleFit, COORDINATES, RayBundle, TileRay};
use super::super::bundles::coverage::{ROOT, TileArea};
use super::super::bundles::model::{PixelLines, Quadratic};
use super::super::counts::Counts;
use super::super::tile_log::TileWay;
use super::cover::{CoverWork, Drawing};
use super::follow::{PathRay, chain};
use super::found::FoundSurface;
use super::reflections::{Reflections, Root};
use catoptric_core::scene::Role;
use glam::Vec2;

/// Lists of candidates that are longer are not filtered for a quarter of a tile, but found anew.
const LONG_LIST: usize = 384;

/// The maximum number of candidates of a tile, for each of its pixels and for each sample of these. With more it is
/// divided, and the smallest are traced ray by ray, which is as fast by then, and has no error.
const CANDIDATES_PER_PIXEL: f32 = 4.0;
const CANDIDATES_PER_SAMPLE: f32 = 0.5;

/// Quarters of a tile find their candidates among the tile's, if its bundle is no worse than this. Chosen, not
/// measured.
const TRUSTED_ERROR_PX: f32 = 2.0;

/// The first layer from which on rays within glass are also traced at samples: in thin walls of flat facets the
/// samples' paths depart from the pixel's own from bounce to bounce.
const WALL_LAYER: usize = 3;

/// The smallest tile with a bundle, in pixels.
const SMALLEST: usize = 2;

/// The columns and rows of a root tile at which its rays are looked at.
const LOOKED_AT: u16 = 0b1010_1010_0101_0101;

/// The error of a bundle, in pixels, above which tiles are divided, down to the smallest, before pixels get their own
/// rays: many candidates would be tried in vain. Chosen, not measured.
const CULLING_ERROR_PX: f32 = 2.0;

/// Buffers of the work on one path in a root tile.
#[derive(Default)]
pub(in super::super) struct PathWork {
    /// True if every pixel of the path has its own ray, and bundles are used to find candidates only.
    pub(in super::super) by_rays: bool,
    /// The rays of pixels, as far as they are known.
    rays: Vec<Option<PathRay>>,
    looked_at: [u16; ROOT],
    /// Pixels whose samples' rays were traced one by one.
    pub(in super::super) traced: [u16; ROOT],
    tile_rays: Vec<TileRay>,
    fit: BundleFit,
    /// Candidates of the tile and of those that it is a quarter of.
    lists: Vec<CandidateList>,
    stack: Vec<u32>,
    waiting: Vec<TileJob>,
    lines: PixelLines,
    cover: CoverWork,
}

/// A square of pixels that waits for its turn.
#[derive(Clone, Copy)]
struct TileJob {
    column: usize,
    row: usize,
    size: usize,
    /// The number of divisions from the root tile to this one: each level has a list of candidates.
    level: usize,
    /// True if its candidates are among those of the level before.
    inherits: bool,
}

impl TileJob {
    /// The pixels of this tile among some of the root tile.
    #[inline(always)]
    fn rows_among(&self, rows: &[u16; ROOT]) -> [u16; ROOT] {
        let columns = (((1u32 << self.size) - 1) << self.column) as u16;
        let mut own = [0; ROOT];
        for row in self.row..self.row + self.size {
            own[row] = rows[row] & columns;
        }
        own
    }

    /// Pixels of the root tile as bits of this tile's own columns and rows.
    #[inline(always)]
    fn own_rows(&self, area: &[u16; ROOT]) -> [u16; ROOT] {
        let mut rows = [0; ROOT];
        for row in 0..self.size {
            rows[row] = area[self.row + row] >> self.column;
        }
        rows
    }

    #[inline(always)]
    fn pixels(self, rows: &[u16; ROOT]) -> impl Iterator<Item = [usize; 2]> {
        (self.row..self.row + self.size).flat_map(move |row| {
            (self.column..self.column + self.size)
                .filter(move |column| rows[row] >> column & 1 != 0)
                .map(move |column| [column, row])
        })
    }
}

#[inline(always)]
fn pixel_count(rows: &[u16; ROOT]) -> usize {
    rows.iter().map(|row| row.count_ones() as usize).sum()
}

impl PathWork {
    /// Lets the quarters of a tile wait.
    fn divide(&mut self, job: &TileJob, inherits: bool) {
        let (size, level) = (job.size / 2, job.level + 1);
        for (column, row) in [(size, size), (0, size), (size, 0), (0, 0)] {
            self.waiting.push(TileJob { column: job.column + column, row: job.row + row, size, level, inherits });
        }
    }
}

/// Pixels of either set that have a neighbour in the other.
#[inline(always)]
fn between(one: &[u16; ROOT], other: &[u16; ROOT]) -> [u16; ROOT] {
    let mut found = [0; ROOT];
    for row in 0..ROOT {
        for (set, opposite) in [(one, other), (other, one)] {
            let above = if row > 0 { opposite[row - 1] } else { 0 };
            let below = if row + 1 < ROOT { opposite[row + 1] } else { 0 };
            found[row] |= set[row] & (opposite[row] << 1 | opposite[row] >> 1 | above | below);
        }
    }
    found
}

/// A summary of the rays of a tile's pixels.
struct Looked {
    /// The first leaves the outer side of the last surface.
    outside: bool,
    /// Pixels whose rays leave the other side.
    others: [u16; ROOT],
    /// Pixels whose rays end at the last surface.
    ended: [u16; ROOT],
}

/// The outcome of an attempt to draw a tile.
enum Outcome {
    /// The tile is drawn: true if anything shows.
    Drawn(bool),
    /// The tile must be divided: true if its quarters' candidates are among its own.
    Divide(bool),
    /// Each of its pixels must be traced.
    Trace,
}

/// [`Reflections::draw_square`], in the widest lanes that the machine has.
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
#[allow(clippy::too_many_arguments)]
fn draw_square(
    reflections: &Reflections<'_>,
    root: &Root<'_, '_>,
    object: u32,
    job: &TileJob,
    rows: &[u16; ROOT],
    work: &mut PathWork,
    surfaces: &mut Vec<FoundSurface>,
    ids: &mut [u32],
) -> Outcome {
    reflections.draw_square(root, object, job, rows, work, surfaces, ids)
}

impl Reflections<'_> {
    /// Draws the full pixels (bits of rows) of a path that ends on an object; true if anything shows.
    pub(in super::super) fn draw_path(
        &self,
        root: &Root<'_, '_>,
        object: u32,
        rows: &[u16; ROOT],
        work: &mut PathWork,
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> bool {
        work.rays.clear();
        work.rays.resize(ROOT * ROOT, None);
        work.looked_at = [0; ROOT];
        work.traced = [0; ROOT];
        work.waiting.clear();
        work.waiting.push(TileJob { column: 0, row: 0, size: ROOT, level: 0, inherits: false });
        let mut any = false;
        while let Some(job) = work.waiting.pop() {
            let area = job.rows_among(rows);
            if pixel_count(&area) == 0 {
                continue;
            }
            match draw_square(self, root, object, &job, &area, work, surfaces, ids) {
                Outcome::Drawn(shows) => any |= shows,
                Outcome::Divide(inherits) if job.size > SMALLEST => {
                    Counts::add(&self.counts.divided, 1);
                    work.divide(&job, inherits);
                }
                Outcome::Divide(_) | Outcome::Trace => {
                    let (shows, traced) = self.trace_pixels(root, object, &job, &area, surfaces, ids);
                    (0..ROOT).for_each(|row| work.traced[row] |= area[row]);
                    Counts::add(&self.counts.left_pixels, traced);
                    any |= shows;
                }
            }
        }
        any
    }

    /// Draws the pixels of a square if one bundle serves them.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn draw_square(
        &self,
        root: &Root<'_, '_>,
        object: u32,
        job: &TileJob,
        rows: &[u16; ROOT],
        work: &mut PathWork,
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> Outcome {
        // A rim could hide between the pixels that are looked at.
        if job.size == ROOT && pixel_count(rows) < ROOT * ROOT && !work.by_rays {
            return Outcome::Divide(false);
        }
        let mut area = *rows;
        let Looked { outside, others, ended } = self.look(root, job, &mut area, work, surfaces);
        if pixel_count(&others) > 0 {
            // A sheet's two sides meet here.
            return if job.size > SMALLEST { Outcome::Divide(false) } else { Outcome::Trace };
        }
        // Pixels within which total reflection begins.
        let mut edge = if self.positions.len() > 1 { between(&area, &ended) } else { [0; ROOT] };
        let in_walls = root.tile.layer() >= WALL_LAYER && self.scene.role_of(object) == Role::Lens;
        if in_walls && self.positions.len() > 1 && (job.size < ROOT || work.by_rays) {
            self.look_at_samples(root, job, &area, &mut edge, outside, work, surfaces);
        }
        let has_edge = pixel_count(&edge) > 0;
        if has_edge && job.size == ROOT && !work.by_rays {
            return Outcome::Divide(false);
        }
        (0..ROOT).for_each(|row| area[row] &= !edge[row]);
        let half = 0.5 * job.size as f32;
        let fitted = RayBundle::fit(&work.tile_rays, root.corner(job.column, job.row) + half, half, &mut work.fit);
        let Some(bundle) = fitted else { return Outcome::Divide(false) };
        let beam = Beam::new(&bundle, &work.fit, &self.scene.bounds);
        if work.lists.len() <= job.level {
            work.lists.resize_with(job.level + 1, CandidateList::default);
        }
        let per_pixel = CANDIDATES_PER_PIXEL + CANDIDATES_PER_SAMPLE * self.positions.len() as f32;
        let most = (per_pixel * pixel_count(&area) as f32) as usize;
        let (parents, own) = work.lists.split_at_mut(job.level);
        let list = &mut own[0];
        match parents.last() {
            Some(parent) if job.inherits && parent.count() <= LONG_LIST => list.filter(parent, &beam),
            _ => list.collect(self.hierarchy, &beam, &mut work.stack, most),
        }
        if list.count() == 0 {
            self.record(root, TileWay::Bundle, [job.column, job.row], job.size, || area);
            return Outcome::Drawn(false);
        }
        if list.count() > most {
            // The list may be incomplete.
            return if job.size > SMALLEST { Outcome::Divide(false) } else { Outcome::Trace };
        }
        let [low, high] = list.depth_range(bundle.origin, bundle.axes[2]);
        let near = low.max(bundle.start_range[0]);
        let error_px = bundle.error_px(&work.fit, [near, high.max(near)]);
        // If the bundle fits the rays badly, those between the pixels that were looked at may leave its beam.
        let (inherit, is_accurate) =
            (error_px <= TRUSTED_ERROR_PX, error_px <= self.model.accuracy_px && !work.by_rays);
        if !is_accurate {
            let looked_at_all = work.by_rays || job.size < ROOT;
            if !looked_at_all || (error_px > CULLING_ERROR_PX && job.size > SMALLEST) {
                return Outcome::Divide(inherit);
            }
            if in_walls && error_px > self.model.accuracy_px {
                // Samples may see surfaces that the pixels' rays do not meet.
                return if job.size > SMALLEST { Outcome::Divide(inherit) } else { Outcome::Trace };
            }
            self.find_lines(root, job, &area, &bundle, outside, work, surfaces);
        }
        Counts::add(&self.counts.pairs, work.lists[job.level].count());
        self.record(root, TileWay::of_square(is_accurate), [job.column, job.row], job.size, || area);
        let own = self.own_rule(object, root.kind, outside);
        let (side, area) = (job.size, TileArea { size: job.size, rows: job.own_rows(&area) });
        let PathWork { lists, fit, lines, cover, .. } = work;
        let (bundle, list, positions) = (&bundle, &lists[job.level], self.positions);
        let first = [job.column, job.row];
        let shows = if is_accurate {
            self.counts.accept(error_px);
            let (model, start_error) = (&Quadratic::new(bundle, job.size), fit.start_error);
            let drawing = Drawing { bundle, model, list, side, area, own, start_error, positions };
            self.draw_candidates(root, first, &drawing, cover, surfaces, ids)
        } else {
            Counts::add(&self.counts.tiles_by_rays, 1);
            let drawing = Drawing { bundle, model: &*lines, list, side, area, own, start_error: 0.0, positions };
            self.draw_candidates(root, first, &drawing, cover, surfaces, ids)
        };
        if !has_edge {
            return Outcome::Drawn(shows);
        }
        let (edge_shows, traced) = self.trace_pixels(root, object, job, &edge, surfaces, ids);
        (0..ROOT).for_each(|row| work.traced[row] |= edge[row]);
        Counts::add(&self.counts.rim_pixels, traced);
        Outcome::Drawn(shows | edge_shows)
    }

    /// Adds rays of pixels' outermost samples to those of a square; pixels where one does another thing become edges.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn look_at_samples(
        &self,
        root: &Root<'_, '_>,
        job: &TileJob,
        area: &[u16; ROOT],
        edge: &mut [u16; ROOT],
        outside: bool,
        work: &mut PathWork,
        surfaces: &[FoundSurface],
    ) {
        for [column, row] in job.pixels(area) {
            let first = root.first_sample(column, row);
            for sample in self.outermost {
                let at = root.corner(column, row) + self.positions[sample];
                Counts::add(&self.counts.rays, 1);
                match self.follow(root.tile, surfaces, &chain(root.tile, first + sample), at) {
                    Some(ray) if ray.outside == outside => {
                        work.tile_rays.push(TileRay { at, ray: ray.ray, length: ray.length });
                    }
                    _ => edge[row] |= 1 << column,
                }
            }
        }
    }

    /// Finds the lines of a square's pixels, and how they change from pixel to pixel.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn find_lines(
        &self,
        root: &Root<'_, '_>,
        job: &TileJob,
        area: &[u16; ROOT],
        bundle: &RayBundle,
        outside: bool,
        work: &mut PathWork,
        surfaces: &[FoundSurface],
    ) {
        let rows = job.own_rows(area);
        for [column, row] in job.pixels(area) {
            if let Some(ray) = &work.rays[row * ROOT + column] {
                work.lines.set([column - job.column, row - job.row], &bundle.coordinates(&ray.ray, ray.length));
            }
        }
        work.lines.difference_all(job.size);
        for row in 0..job.size {
            let above = if row > 0 { rows[row - 1] } else { 0 };
            let below = if row + 1 < job.size { rows[row + 1] } else { 0 };
            for (axis, known) in [(rows[row] << 1) & (rows[row] >> 1), above & below].into_iter().enumerate() {
                let mut rest = rows[row] & !known;
                while rest != 0 {
                    let column = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    let mut neighbours = [None; 2];
                    for (sign, neighbour) in [-1, 1].into_iter().zip(&mut neighbours) {
                        let step = if axis == 0 { [sign, 0] } else { [0, sign] };
                        *neighbour =
                            self.line_beside(root, job, [column, row], step, &rows, bundle, outside, work, surfaces);
                    }
                    work.lines.set_change([column, row], axis, &neighbours);
                }
            }
        }
        work.lines.find_missed(bundle, &rows, job.size);
    }

    /// The line of a pixel's neighbour, or the pixel's own line extrapolated to the neighbour. `None` where it ends.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn line_beside(
        &self,
        root: &Root<'_, '_>,
        job: &TileJob,
        [column, row]: [usize; 2],
        step: [isize; 2],
        rows: &[u16; ROOT],
        bundle: &RayBundle,
        outside: bool,
        work: &PathWork,
        surfaces: &[FoundSurface],
    ) -> Option<[f32; COORDINATES]> {
        let beside = [column.wrapping_add_signed(step[0]), row.wrapping_add_signed(step[1])];
        if beside[0] < job.size && beside[1] < job.size && rows[beside[1]] >> beside[0] & 1 != 0 {
            return Some(work.lines.get(beside));
        }
        let [x, y] = [beside[0].wrapping_add(job.column), beside[1].wrapping_add(job.row)];
        let mut ray = if x < ROOT && y < ROOT { work.rays[y * ROOT + x] } else { None };
        if ray.is_none() {
            let (column, row) = (job.column + column, job.row + row);
            let sample = root.first_sample(column, row) + root.tile.positions.len() / 2;
            let position = root.corner(column, row) + 0.5 + Vec2::new(step[0] as f32, step[1] as f32);
            ray = self.follow(root.tile, surfaces, &chain(root.tile, sample), position);
        }
        match ray {
            Some(ray) if ray.outside == outside => Some(bundle.coordinates(&ray.ray, ray.length)),
            _ => None,
        }
    }

    /// Traces the samples of some pixels of a square: true if anything shows, and in how many any ray goes on.
    fn trace_pixels(
        &self,
        root: &Root<'_, '_>,
        object: u32,
        job: &TileJob,
        rows: &[u16; ROOT],
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> (bool, usize) {
        self.record(root, TileWay::Traced, [job.column, job.row], job.size, || job.rows_among(rows));
        let all = ((1u64 << root.tile.positions.len()) - 1) as u32;
        let (mut any, mut traced) = (false, 0);
        for pixel in job.pixels(rows) {
            let shows = self.trace_pixel(root, object, pixel, all, surfaces, ids);
            traced += usize::from(shows.is_some());
            any |= shows == Some(true);
        }
        (any, traced)
    }

    /// Finds the rays of a square, all of them or a regular choice of a root tile's. Pixels whose rays end or leave
    /// another side than the first are taken from it.
    #[inline(always)]
    fn look(
        &self,
        root: &Root<'_, '_>,
        job: &TileJob,
        area: &mut [u16; ROOT],
        work: &mut PathWork,
        surfaces: &[FoundSurface],
    ) -> Looked {
        let whole = job.size == ROOT && !work.by_rays;
        let PathWork { rays, looked_at, tile_rays, .. } = work;
        tile_rays.clear();
        let (mut outside, mut others, mut ended) = (None, [0; ROOT], [0; ROOT]);
        let all = *area;
        // Without closures, which would not be compiled for the caller's instruction set.
        for row in job.row..job.row + job.size {
            let mut rest = all[row];
            if whole {
                rest = if LOOKED_AT >> row & 1 != 0 { LOOKED_AT } else { 0 };
            }
            while rest != 0 {
                let column = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let position = root.corner(column, row) + 0.5;
                let known = &mut rays[row * ROOT + column];
                if looked_at[row] >> column & 1 == 0 {
                    looked_at[row] |= 1 << column;
                    // The sample in the pixel's middle, nearly.
                    let sample = root.first_sample(column, row) + root.tile.positions.len() / 2;
                    *known = self.follow(root.tile, surfaces, &chain(root.tile, sample), position);
                    Counts::add(&self.counts.rays, 1);
                }
                match known {
                    Some(ray) if *outside.get_or_insert(ray.outside) == ray.outside => {
                        tile_rays.push(TileRay { at: position, ray: ray.ray, length: ray.length });
                    }
                    other => {
                        area[row] &= !(1 << column);
                        let of_kind = if other.is_some() { &mut others } else { &mut ended };
                        of_kind[row] |= 1 << column;
                    }
                }
            }
        }
        Looked { outside: outside.unwrap_or(true), others, ended }
    }
}
