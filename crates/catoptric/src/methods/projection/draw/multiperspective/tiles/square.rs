//! The full pixels of a path in a root tile: squares with one bundle each, divided until it is accurate.

use super::super::bundles::beam::{Beam, CandidateList};
use super::super::bundles::bundle::{BundleFit, RayBundle, TileRay};
use super::super::bundles::coverage::{DrawnTriangle, NOTHING, ROOT, TileArea, TileSamples};
use super::super::bundles::edges::EdgeFunctions;
use super::super::counts::Counts;
use super::super::source::{Reflections, Root};
use super::follow::{PathRay, chain};
use super::found::FoundSurface;
use super::own::{OwnRule, TOUCHING};
use crate::light::wide_hierarchy::NO_TRIANGLE;
use crate::raster::source::found_id;
use crate::scene::shade::Barycentrics;
use glam::Vec2;

/// Lists of candidates that are longer are not filtered for a quarter of a tile, but found anew.
const LONG_LIST: usize = 384;

/// With more candidates a pixel than this, rays are traced one by one.
const MANY_CANDIDATES: usize = 25;

/// Quarters of a tile find their candidates among the tile's, if its bundle is no worse than this. Chosen, not
/// measured.
const TRUSTED_ERROR_PX: f32 = 2.0;

/// The smallest tile with a bundle, in pixels.
const SMALLEST: usize = 2;

/// The columns and rows of a root tile at which its rays are looked at.
const LOOKED_AT: u16 = 0b1010_1010_0101_0101;

/// Columns and rows of a block that triangles are tested against before they are drawn.
const BLOCK: usize = 8;

/// An object's own triangles count from so much beyond the start of rays, as a share of a tile's extent.
const OWN_MARGIN: f32 = 1e-3;

/// Buffers of the work on one path in a root tile.
#[derive(Default)]
pub(in super::super) struct PathWork {
    /// The rays of pixels, as far as they are known.
    rays: Vec<Option<PathRay>>,
    looked_at: [u16; ROOT],
    tile_rays: Vec<TileRay>,
    fit: BundleFit,
    /// Candidates of the tile and of those that it is a quarter of.
    lists: Vec<CandidateList>,
    stack: Vec<u32>,
    waiting: Vec<TileJob>,
    samples: TileSamples,
    drawn: Vec<(u32, DrawnTriangle)>,
    tested: Vec<usize>,
    numbers: Vec<u32>,
}

/// A square of pixels that waits for its turn.
#[derive(Clone, Copy)]
struct TileJob {
    column: usize,
    row: usize,
    size: usize,
    /// How often the root tile was divided for it: each level has a list of candidates.
    level: usize,
    /// Its candidates are among those of the level before.
    inherits: bool,
}

impl TileJob {
    /// Its pixels among some of the root tile.
    #[inline(always)]
    fn rows_among(&self, rows: &[u16; ROOT]) -> [u16; ROOT] {
        let columns = (((1u32 << self.size) - 1) << self.column) as u16;
        let mut own = [0; ROOT];
        for row in self.row..self.row + self.size {
            own[row] = rows[row] & columns;
        }
        own
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

/// What became of a tile.
enum Outcome {
    /// It is drawn: true if anything shows.
    Drawn(bool),
    /// Its quarters must be; true if their candidates are among its own.
    Divide(bool),
    /// Each of its pixels must be.
    Trace,
}

/// [`Reflections::draw_square`], in the widest lanes that the machine has.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
    "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
))]
#[allow(clippy::too_many_arguments)]
fn draw_square(
    reflections: &Reflections<'_>,
    root: &Root<'_, '_>,
    object: u32,
    job: &TileJob,
    area: &mut [u16; ROOT],
    work: &mut PathWork,
    surfaces: &mut Vec<FoundSurface>,
    ids: &mut [u32],
) -> Outcome {
    reflections.draw_square(root, object, job, area, work, surfaces, ids)
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
        work.waiting.clear();
        work.waiting.push(TileJob { column: 0, row: 0, size: ROOT, level: 0, inherits: false });
        let mut any = false;
        while let Some(job) = work.waiting.pop() {
            let mut area = job.rows_among(rows);
            if pixel_count(&area) == 0 {
                continue;
            }
            match draw_square(self, root, object, &job, &mut area, work, surfaces, ids) {
                Outcome::Drawn(shows) => any |= shows,
                Outcome::Divide(inherits) if job.size > SMALLEST => {
                    Counts::add(&self.counts.divided, 1);
                    work.divide(&job, inherits);
                }
                Outcome::Divide(_) | Outcome::Trace => {
                    any |= self.trace_pixels(root, object, &job, &area, surfaces, ids);
                }
            }
        }
        any
    }

    /// Draws a square if one bundle serves its pixels.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn draw_square(
        &self,
        root: &Root<'_, '_>,
        object: u32,
        job: &TileJob,
        area: &mut [u16; ROOT],
        work: &mut PathWork,
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> Outcome {
        // A rim could hide between the pixels that are looked at.
        if job.size == ROOT && pixel_count(area) < ROOT * ROOT {
            return Outcome::Divide(false);
        }
        let (outside, others) = self.look(root, job, area, work, surfaces);
        if pixel_count(&others) > 0 {
            // A sheet's two sides meet here.
            (0..ROOT).for_each(|row| area[row] |= others[row]);
            return if job.size > SMALLEST { Outcome::Divide(false) } else { Outcome::Trace };
        }
        let half = 0.5 * job.size as f32;
        let center = root.corner(job.column, job.row) + half;
        let Some(bundle) = RayBundle::fit(&work.tile_rays, center, half, &mut work.fit) else {
            return Outcome::Divide(false);
        };
        let beam = Beam::new(&bundle, &work.fit, &self.scene.bounds);
        if work.lists.len() <= job.level {
            work.lists.resize_with(job.level + 1, CandidateList::default);
        }
        let (parents, own) = work.lists.split_at_mut(job.level);
        let list = &mut own[0];
        match parents.last() {
            Some(parent) if job.inherits && parent.len() <= LONG_LIST => list.filter(parent, &beam),
            _ => list.collect(self.hierarchy, &beam, &mut work.stack, MANY_CANDIDATES * pixel_count(area)),
        }
        if list.len() == 0 {
            return Outcome::Drawn(false);
        }
        if list.len() > MANY_CANDIDATES * pixel_count(area) {
            // Its list may not be whole.
            return if job.size > SMALLEST { Outcome::Divide(false) } else { Outcome::Trace };
        }
        let [low, high] = list.depth_range(bundle.origin, bundle.axes[2]);
        let near = low.max(bundle.start_range[0]);
        let error_px = bundle.error_px(&work.fit, [near, high.max(near)]);
        // Where the bundle says little of the rays, those between the pixels that were looked at may leave its beam.
        let inherit = error_px <= TRUSTED_ERROR_PX;
        if error_px > self.accuracy_px {
            return Outcome::Divide(inherit);
        }
        self.counts.accept(error_px);
        Counts::add(&self.counts.pairs, list.len());
        let rule = self.own_rule(object, root.kind, outside);
        Outcome::Drawn(self.draw_candidates(root, &bundle, job, area, &rule, work, surfaces, ids))
    }

    /// Traces the samples of some pixels of a square; true if anything shows.
    fn trace_pixels(
        &self,
        root: &Root<'_, '_>,
        object: u32,
        job: &TileJob,
        rows: &[u16; ROOT],
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> bool {
        let all = ((1u64 << root.tile.positions.len()) - 1) as u32;
        Counts::add(&self.counts.left_pixels, pixel_count(rows));
        let mut any = false;
        for pixel in job.pixels(rows) {
            any |= self.trace_pixel(root, object, pixel, all, surfaces, ids);
        }
        any
    }

    /// Finds the rays of a square, all of them or a regular choice of a root tile's; true if the first leaves the
    /// outer side. Pixels whose rays end, and those (which it returns) whose rays leave the other side, are taken from
    /// it.
    #[inline(always)]
    fn look(
        &self,
        root: &Root<'_, '_>,
        job: &TileJob,
        area: &mut [u16; ROOT],
        work: &mut PathWork,
        surfaces: &[FoundSurface],
    ) -> (bool, [u16; ROOT]) {
        let PathWork { rays, looked_at, tile_rays, .. } = work;
        tile_rays.clear();
        let (mut outside, mut others) = (None, [0; ROOT]);
        let all = *area;
        let whole = job.size == ROOT;
        // No closures here: they would not be compiled for the caller's instruction set.
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
                    ends => {
                        area[row] &= !(1 << column);
                        others[row] |= u16::from(ends.is_some()) << column;
                    }
                }
            }
        }
        (outside.unwrap_or(true), others)
    }

    /// Draws the candidates of a square whose bundle is accurate.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn draw_candidates(
        &self,
        root: &Root<'_, '_>,
        bundle: &RayBundle,
        job: &TileJob,
        rows: &[u16; ROOT],
        own: &OwnRule,
        work: &mut PathWork,
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> bool {
        let mut area = TileArea {
            corner: [0.5 * (1.0 - job.size as f32) * bundle.scale; 2],
            scale: bundle.scale,
            size: job.size,
            rows: [0; ROOT],
        };
        for row in 0..job.size {
            area.rows[row] = rows[job.row + row] >> job.column;
        }
        self.cover(bundle, job.level, &area, own, root.corner(job.column, job.row) + 0.5, work);
        // Surfaces for what shows.
        let PathWork { samples, drawn, numbers, .. } = work;
        numbers.clear();
        numbers.resize(drawn.len(), NOTHING);
        let count = root.tile.positions.len();
        let mut any = false;
        for row in 0..job.size {
            for column in (0..job.size).filter(|column| area.rows[row] >> column & 1 != 0) {
                let first = root.first_sample(job.column + column, job.row + row);
                let shown = &samples.shown[(row * ROOT + column) * count..][..count];
                for (id, &number) in ids[first..first + count].iter_mut().zip(shown) {
                    if number == NOTHING {
                        continue;
                    }
                    any = true;
                    let place = &mut numbers[number as usize];
                    if *place == NOTHING {
                        *place = surfaces.len() as u32;
                        let (triangle, DrawnTriangle { functions: [a, b, c, plane], .. }) = &drawn[number as usize];
                        let sum = std::array::from_fn(|term| a[term] + b[term] + c[term]);
                        let functions = [*b, *c, sum, *plane];
                        surfaces.push(self.found(root, *triangle, bundle.center, bundle.scale, functions));
                    }
                    *id = found_id(*place);
                }
            }
        }
        any
    }

    /// Finds what the samples of a square show among its candidates. `first` is its first pixel's centre.
    #[inline(always)]
    fn cover(
        &self,
        bundle: &RayBundle,
        level: usize,
        area: &TileArea,
        own: &OwnRule,
        first: Vec2,
        work: &mut PathWork,
    ) {
        let PathWork { lists, samples, drawn, tested, fit, .. } = work;
        samples.begin(self.positions);
        drawn.clear();
        tested.clear();
        let axis = bundle.axes[2];
        let blocks = area.size.div_ceil(BLOCK);
        let half = 0.5 * (area.size.min(BLOCK)) as f32 * area.scale;
        let earliest_start = bundle.start_range[0] - fit.start_error;
        let latest_start = bundle.start_range[1] + fit.start_error;
        // The side alone tells triangles that rays leave from those that they meet, also across a thin wall.
        let own_margin = match own.is_closed() {
            true => -fit.start_error,
            false => 2.0 * fit.start_error + OWN_MARGIN * bundle.start_range[1],
        };
        for block in &lists[level].blocks {
            let functions = EdgeFunctions::new(bundle, block);
            // Bits of lanes, for each part of the square and each sign.
            let mut meets = [[0u32; 2]; 4];
            for (part, meets) in meets.iter_mut().enumerate().take(blocks * blocks) {
                let first = area.corner[0] + 0.5 * (area.size.min(BLOCK) as f32 - 1.0) * area.scale;
                let step = BLOCK as f32 * area.scale;
                let place = [first + (part % blocks) as f32 * step, first + (part / blocks) as f32 * step];
                *meets = functions.may_meet(place, [half; 2]);
            }
            let mut lanes = 0;
            for [plus, minus] in meets {
                lanes |= plus | minus;
            }
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let triangle = block.triangles[lane];
                if triangle == NO_TRIANGLE {
                    continue;
                }
                let object = self.scene.triangle_objects[triangle as usize];
                let from = own.distances(self.scene, self.shapes, triangle);
                let depth = |corner: usize| {
                    let at = |axis: usize| block.corners[corner * 3 + axis][lane];
                    (glam::Vec3::new(at(0), at(1), at(2)) - bundle.origin).dot(axis)
                };
                let depths = [depth(0), depth(1), depth(2)];
                for (index, sign) in [1.0, -1.0].into_iter().enumerate() {
                    let is_met = |part: usize| meets[part][index] >> lane & 1 != 0;
                    let margin = match object == own.object {
                        true if from[index] > 0.0 => from[index].max(own_margin),
                        true => own_margin,
                        false => 0.0,
                    };
                    let [earliest, latest] = [earliest_start + margin, latest_start + margin];
                    if !(0..blocks * blocks).any(is_met) || depths.iter().all(|depth| *depth < earliest) {
                        continue;
                    }
                    let starts = depths.iter().any(|depth| *depth < latest).then(|| {
                        let mut starts = bundle.starts;
                        starts[0] += margin;
                        starts
                    });
                    let number = drawn.len() as u32;
                    let mut functions = functions.of_lane(lane, sign);
                    if own.is_around(object) {
                        functions[3].iter_mut().for_each(|term| *term *= 1.0 - TOUCHING);
                    }
                    let one = DrawnTriangle { number, functions, starts };
                    drawn.push((triangle, one));
                    if self.scene.is_alpha_tested(object) {
                        tested.push(number as usize);
                        continue;
                    }
                    for part in (0..blocks * blocks).filter(|part| is_met(*part)) {
                        let row = part / blocks * BLOCK;
                        samples.draw(area, &one, part % blocks * BLOCK, row..(row + BLOCK).min(area.size));
                    }
                }
            }
        }
        self.cover_tested(bundle, area, first, work);
    }

    /// Goes on with the triangles that show where an alpha test passes.
    #[inline(always)]
    fn cover_tested(&self, bundle: &RayBundle, area: &TileArea, first: Vec2, work: &mut PathWork) {
        let PathWork { samples, drawn, tested, .. } = work;
        for &index in tested.iter() {
            let (triangle, drawn) = &drawn[index];
            let [a, b, c, plane] = drawn.functions;
            let sum = std::array::from_fn(|term| a[term] + b[term] + c[term]);
            let surface = FoundSurface {
                triangle: *triangle,
                group: 0,
                patch: 0,
                center: bundle.center,
                scale: bundle.scale,
                functions: [b, c, sum, plane],
            };
            samples.draw_tested(area, drawn, |x, y| {
                let at: Barycentrics = surface.surface(first + Vec2::new(x, y), None).barycentrics;
                self.scene.is_surface_present(*triangle, &at)
            });
        }
    }
}
