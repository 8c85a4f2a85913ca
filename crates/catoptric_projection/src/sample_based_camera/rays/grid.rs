//! The dense ray map: every d-th view ray in both directions, followed through reflectors and lenses, and rays close to
//! where paths end.

use super::creases;
use super::follow::{Bounces, FollowSteps, Follower};
pub(in super::super) use super::path_rays::DensePathRays;
use super::primary_visibility::{PrimaryVisibility, VisibilityRow};
use crate::find::ray_map::{RayField, Specular};
use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::Ray;
use catoptric_core::scene::hit::PrimitiveHit;
use catoptric_engine::method::projector::SpecularPath;
use glam::DVec3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;

/// Where paths end between neighbouring rays is found this near, in pixels. Chosen, not measured.
pub(in super::super) const BORDER_PX: f32 = 0.06;

/// Index of no cell of the map.
pub(in super::super) const NO_CELL: u32 = u32::MAX;

/// An outgoing ray, without the path that led to it.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct GridRay {
    /// Place of its view ray, in cells: those of the regular map are at whole numbers.
    pub(in super::super) place: [f32; 2],
    /// The first bounce point, and the unit normal there, on the side of the eye.
    pub(in super::super) first: DVec3,
    pub(in super::super) normal: DVec3,
    /// Its tail, the last bounce point, and unit direction.
    pub(in super::super) tail: DVec3,
    pub(in super::super) direction: DVec3,
    /// Optical length from the eye (its plane) to the tail.
    pub(in super::super) length: f64,
    /// Index of refraction of what it runs through.
    pub(in super::super) medium: f64,
}

/// The rays of every path, on one grid of cells.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct RayGrid {
    /// Pixels between neighbouring rays; those of cell `(i, j)` are at `(i + 1/2, j + 1/2)` times this in the field.
    pub(in super::super) spacing_px: f32,
    pub(in super::super) groups: Vec<DensePathRays>,
    /// Rays followed, bounces included; those of the regular map that meet nothing are not counted where they were
    /// drawn.
    pub(in super::super) traced: u64,
}

/// Place of a ray in the grid. Apart from the ray itself: sorting looks at these alone.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct GridEntry {
    /// The column and row of its cell.
    pub(in super::super) cell: [u32; 2],
    /// The cells between whose rays it was looked for; [`NO_CELL`] for regular rays.
    pub(in super::super) between: [u32; 2],
    /// Index of its path among those of its row.
    path: u32,
}

/// The rays of one row.
#[derive(Default)]
pub(in super::super) struct RowEntries {
    /// The paths that occur.
    paths: Vec<Bounces>,
    pub(in super::super) entries: Vec<GridEntry>,
    pub(in super::super) rays: Vec<GridRay>,
    /// The numbers of the entries, path by path, and where each path starts.
    by_path: Vec<u32>,
    starts: Vec<usize>,
    traced: u64,
}

impl RowEntries {
    /// The numbers of a path's entries.
    pub(in super::super) fn of_path(&self, path: u32) -> &[u32] {
        &self.by_path[self.starts[path as usize]..self.starts[path as usize + 1]]
    }

    fn finished(mut self, traced: u64) -> Self {
        self.traced = traced;
        self.starts = vec![0; self.paths.len() + 1];
        for entry in &self.entries {
            self.starts[entry.path as usize + 1] += 1;
        }
        for path in 0..self.paths.len() {
            self.starts[path + 1] += self.starts[path];
        }
        let mut next = self.starts.clone();
        self.by_path = vec![0; self.entries.len()];
        for (number, entry) in self.entries.iter().enumerate() {
            let next = &mut next[entry.path as usize];
            self.by_path[*next] = number as u32;
            *next += 1;
        }
        self
    }
}

/// Numbers of paths.
type PathNumbers = HashMap<Bounces, u32, BuildHasherDefault<SignatureHasher>>;

/// Signatures are mixed already.
#[derive(Default)]
struct SignatureHasher(u64);

impl Hasher for SignatureHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(self.0.rotate_left(8) ^ u64::from(byte));
        }
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = number;
    }
}

/// Scratch space that workers keep from row to row.
#[derive(Default)]
struct GridScratch {
    steps: FollowSteps,
    numbers: PathNumbers,
    row: VisibilityRow,
}

/// Traces the rays of a field.
pub(in super::super) struct RaySampler<'a> {
    specular: &'a Specular<'a>,
    follower: Follower<'a>,
    field: &'a dyn RayField,
    pub(in super::super) spacing_px: f32,
    /// Number of regular rays across and down.
    size: [u32; 2],
}

/// Place, cell and neighbours of a ray to enter.
#[derive(Clone, Copy)]
struct GridPlace {
    place: [f32; 2],
    cell: [u32; 2],
    between: [u32; 2],
}

impl<'a> RaySampler<'a> {
    /// Samples a regular ray every `spacing_px`. Objects of `mapped` show environment maps: no path goes on at them.
    pub(in super::super) fn new(
        specular: &'a Specular<'a>,
        field: &'a dyn RayField,
        spacing_px: f32,
        mapped: &'a [bool],
    ) -> Self {
        let size = field.size_px().map(|size| ((size / spacing_px).ceil() as u32).max(1));
        Self { specular, follower: Follower::new(specular, mapped), field, spacing_px, size }
    }

    /// The outgoing ray of a path at a place (in cells), if the path is seen there.
    pub(in super::super) fn ray_on(
        &self,
        path: &SpecularPath,
        place: [f32; 2],
        steps: &mut FollowSteps,
    ) -> Option<GridRay> {
        let (ray, near) = self.ray(place);
        let wanted = |bounces: &Bounces| path.bounces.starts_with(bounces.so_far());
        let Some(meeting) = self.follower.traced(&ray, near) else {
            steps.traced += 1;
            return None;
        };
        let mut on_path = None;
        self.follower.follow(&ray, &meeting, steps, &wanted, &mut |bounces, ray| {
            if bounces.so_far().len() == path.bounces.len() {
                on_path = Some(GridRay { place, ..ray });
            }
        });
        on_path
    }

    /// The ray at a place, in cells.
    fn ray(&self, place: [f32; 2]) -> (Ray, f32) {
        let [x, y] = place.map(|place| (place + 0.5) * self.spacing_px);
        self.field.ray(x, y)
    }

    /// Follows a ray; returns the signature of the paths it takes, 0 for none.
    #[inline]
    fn enter(
        &self,
        ray: &Ray,
        meeting: &PrimitiveHit,
        at: GridPlace,
        scratch: &mut GridScratch,
        entries: &mut RowEntries,
    ) -> u64 {
        let mut signature = 0u64;
        let GridScratch { steps, numbers, .. } = scratch;
        let mut last = u32::MAX;
        self.follower.follow(ray, meeting, steps, &|_| true, &mut |bounces, ray| {
            signature = signature.wrapping_add(bounces.signature);
            if entries.paths.get(last as usize) != Some(bounces) {
                last = *numbers.entry(*bounces).or_insert_with(|| {
                    entries.paths.push(*bounces);
                    entries.paths.len() as u32 - 1
                });
            }
            let GridPlace { place, cell, between } = at;
            entries.entries.push(GridEntry { cell, between, path: last });
            entries.rays.push(GridRay { place, ..ray });
        });
        signature
    }

    /// Traces and follows the ray at a place.
    fn sample(&self, at: GridPlace, scratch: &mut GridScratch, entries: &mut RowEntries) -> u64 {
        let (ray, near) = self.ray(at.place);
        match self.follower.traced(&ray, near) {
            Some(meeting) => self.enter(&ray, &meeting, at, scratch, entries),
            None => {
                scratch.steps.traced += 1;
                0
            }
        }
    }

    /// The regular rays of a row, and what paths each takes.
    fn row(
        &self,
        number: u32,
        span: Range<u32>,
        seen: Option<&PrimaryVisibility<'_>>,
        scratch: &mut GridScratch,
    ) -> (RowEntries, Vec<u64>) {
        let mut entries = RowEntries::default();
        let mut signatures = vec![0; self.size[0] as usize];
        scratch.steps.traced = 0;
        scratch.numbers.clear();
        let at = |column: u32| GridPlace {
            place: [column as f32, number as f32],
            cell: [column, number],
            between: [NO_CELL; 2],
        };
        if let Some(seen) = seen {
            let mut row = std::mem::take(&mut scratch.row);
            seen.row(number, &mut row);
            let count = row.seen().count();
            entries.entries.reserve(count);
            entries.rays.reserve(count);
            for (column, ray, meeting) in row.seen() {
                signatures[column as usize] = self.enter(ray, meeting, at(column), scratch, &mut entries);
            }
            scratch.row = row;
        } else {
            for column in span {
                signatures[column as usize] = self.sample(at(column), scratch, &mut entries);
            }
        }
        (entries.finished(scratch.steps.traced), signatures)
    }

    /// Closes in on where paths change between the rays of two cells with different signatures.
    fn close_in(&self, cells: [[u32; 2]; 2], signature: u64, scratch: &mut GridScratch, entries: &mut RowEntries) {
        let between = cells.map(|[column, row]| row * self.size[0] + column);
        let [mut from, mut to] = cells.map(|cell| cell.map(|index| index as f32));
        let mut apart_px = self.spacing_px;
        while apart_px > BORDER_PX {
            let place = [0, 1].map(|axis: usize| 0.5 * (from[axis] + to[axis]));
            let cell = place.map(|place| place.round() as u32);
            let same = self.sample(GridPlace { place, cell, between }, scratch, entries) == signature;
            *(if same { &mut from } else { &mut to }) = place;
            apart_px *= 0.5;
        }
    }
}

impl RayGrid {
    /// Follows the rays of a field.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(in super::super) fn new(sampler: &RaySampler<'_>, progress: &dyn Progress) -> Result<Self, Cancelled> {
        let RaySampler { specular, field, spacing_px, size: [columns, rows], .. } = *sampler;
        let seen = PrimaryVisibility::new(specular, field, spacing_px, [columns, rows]);
        let spans = match seen {
            Some(_) => Vec::new(),
            None => spans(specular, field, spacing_px, [columns, rows]),
        };
        let row_count = rows as usize;
        let regular =
            parallel::map_init_stage(progress, "tracing rays", row_count, GridScratch::default, |scratch, row| {
                let span = spans.get(row).cloned().unwrap_or_default();
                sampler.row(row as u32, span, seen.as_ref(), scratch)
            })?;
        let borders =
            parallel::map_init_stage(progress, "closing in", row_count, GridScratch::default, |scratch, row| {
                let mut entries = RowEntries::default();
                scratch.steps.traced = 0;
                scratch.numbers.clear();
                let own = &regular[row].1;
                let below = regular.get(row + 1).map(|below| &below.1);
                for column in 0..columns as usize {
                    let beside = own.get(column + 1).map(|signature| ([column + 1, row], signature));
                    let below = below.map(|below| ([column, row + 1], &below[column]));
                    for (other, signature) in [beside, below].into_iter().flatten() {
                        if *signature != own[column] {
                            let cells = [[column, row], other].map(|cell| cell.map(|index| index as u32));
                            sampler.close_in(cells, own[column], scratch, &mut entries);
                        }
                    }
                }
                entries.finished(scratch.steps.traced)
            })?;
        let regular = regular.into_iter().map(|(entries, _)| entries);
        let found: Vec<RowEntries> = regular.chain(borders).collect();
        let traced: u64 = found.iter().map(|row| row.traced).sum();
        let groups = by_path(&found);
        let reach = specular.scene.bounds.diagonal();
        let groups = parallel::map_stage(progress, "sorting rays", groups.len(), |index| {
            let (path, of_rows) = &groups[index];
            let mut group = DensePathRays::new(path.clone(), &found, of_rows, columns, reach.into());
            let mut steps = FollowSteps::default();
            let beside = creases::beside(&group, sampler, reach.into(), &mut steps);
            group.add(beside);
            (group, steps.traced)
        })?;
        let traced = traced + groups.iter().map(|(_, traced)| traced).sum::<u64>();
        Ok(Self { spacing_px, groups: groups.into_iter().map(|(group, _)| group).collect(), traced })
    }
}

/// The columns of each row in which reflectors and lenses may be seen first.
fn spans(specular: &Specular<'_>, field: &dyn RayField, spacing_px: f32, [columns, rows]: [u32; 2]) -> Vec<Range<u32>> {
    let mut spans = vec![0..0; rows as usize];
    for object in specular.scene.specular_objects() {
        let bounds = &specular.scene.objects[object as usize].bounds;
        let seen = extent(bounds, field).map(|[low, high]| {
            let cell = |px: f64| (px / f64::from(spacing_px) - 0.5).clamp(-1.0, 1e9);
            // One cell more on every side, for rounding.
            let [first, last] = [low, high].map(|corner| corner.map(cell));
            [first.map(|cell| (cell - 1.0).max(0.0) as u32), last.map(|cell| (cell + 2.0).max(0.0) as u32)]
        });
        let [low, high] = seen.unwrap_or([[0, 0], [columns, rows]]);
        for span in &mut spans[(low[1].min(rows)) as usize..(high[1] + 1).min(rows) as usize] {
            let (start, end) = (low[0].min(columns), (high[0] + 1).min(columns));
            *span = if span.start >= span.end { start..end } else { span.start.min(start)..span.end.max(end) };
        }
    }
    spans
}

/// The rectangle of the field that a box appears in; returns `None` if some of it is beside or behind the eye.
pub(in super::super) fn extent(bounds: &Aabb, field: &dyn RayField) -> Option<[[f64; 2]; 2]> {
    let mut found = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for corner in 0..8 {
        let axis = |axis: usize| f64::from(if corner >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] });
        let place = field.place_of(DVec3::new(axis(0), axis(1), axis(2)))?;
        for (axis, place) in place.into_iter().enumerate() {
            found[0][axis] = found[0][axis].min(place);
            found[1][axis] = found[1][axis].max(place);
        }
    }
    Some(found)
}

/// The paths in order, and the rows that each occurs in with its numbers there.
fn by_path(rows: &[RowEntries]) -> Vec<(SpecularPath, Vec<(u32, u32)>)> {
    let mut known = PathNumbers::default();
    let mut groups: Vec<(SpecularPath, Vec<(u32, u32)>)> = Vec::new();
    for (row, entries) in rows.iter().enumerate() {
        for (number, bounces) in entries.paths.iter().enumerate() {
            let group = *known.entry(*bounces).or_insert_with(|| {
                groups.push((bounces.path(), Vec::new()));
                groups.len() as u32 - 1
            });
            groups[group as usize].1.push((row as u32, number as u32));
        }
    }
    groups.sort_by(|a, b| a.0.cmp(&b.0));
    groups
}
