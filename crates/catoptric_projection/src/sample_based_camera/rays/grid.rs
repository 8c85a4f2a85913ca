//! The dense ray map: every d-th view ray in both directions, followed through reflectors and lenses, and rays close to
//! where paths end.

use super::creases;
use super::extent::extent;
use super::follow::FollowSteps;
use super::path_rays::{DensePathRays, NO_RAY};
use super::pieces;
use super::primary_visibility::PrimaryVisibility;
use super::rows::{NO_CELL, PathNumbers, RowEntries};
use super::sampler::{GridScratch, RaySampler};
use crate::find::ray_map::{RayField, Specular};
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_engine::method::projector::SpecularPath;
use std::ops::Range;

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
            let mut group = rays_of_path(path.clone(), &found, of_rows, columns, reach.into());
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
            // One more cell on every side allows for rounding.
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

/// The rays of a path that were found in some rows, by these numbers there. `reach` is how far rays are expected to
/// go.
fn rays_of_path(
    path: SpecularPath,
    rows: &[RowEntries],
    found: &[(u32, u32)],
    columns: u32,
    reach: f64,
) -> DensePathRays {
    let entries =
        || found.iter().flat_map(|&(row, number)| rows[row as usize].of_path(number).iter().map(move |&at| (row, at)));
    let cell = |(row, at): (u32, u32)| rows[row as usize].entries[at as usize].cell;
    let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
    let mut count = 0;
    for entry in entries() {
        for (axis, index) in cell(entry).into_iter().enumerate() {
            low[axis] = low[axis].min(index);
            high[axis] = high[axis].max(index);
        }
        count += 1;
    }
    let size = [0, 1].map(|axis: usize| high[axis] + 1 - low[axis].min(high[axis]));
    let bin = |[column, row]: [u32; 2]| ((row - low[1]) * size[0] + column - low[0]) as usize;
    let mut starts = vec![0u32; (size[0] * size[1]) as usize + 1];
    for entry in entries() {
        starts[bin(cell(entry)) + 1] += 1;
    }
    for index in 1..starts.len() {
        starts[index] += starts[index - 1];
    }
    let mut next = starts.clone();
    let mut order = vec![(0u32, 0u32); count];
    // Regular rays come first among the entries, so they do in their cells.
    for entry in entries() {
        let next = &mut next[bin(cell(entry))];
        order[*next as usize] = entry;
        *next += 1;
    }
    let rays = parallel::map_collect(count, |index| rows[order[index].0 as usize].rays[order[index].1 as usize]);
    let between: Vec<[u32; 2]> =
        order.iter().map(|&(row, at)| rows[row as usize].entries[at as usize].between).collect();
    let is_regular = |start: u32, end: u32| start < end && between[start as usize][0] == NO_CELL;
    let regular = starts.windows(2).map(|ends| if is_regular(ends[0], ends[1]) { ends[0] } else { NO_RAY }).collect();
    let mut group = DensePathRays::of_cells(path, rays, [low, size], starts, regular);
    group.set_pieces(pieces::of(&group, &between, columns, reach));
    group
}
