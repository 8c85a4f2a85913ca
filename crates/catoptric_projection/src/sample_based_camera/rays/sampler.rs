//! The tracing of a field's rays: regular ones, and others close to where paths change between these.

use super::follow::{Bounces, FollowSteps, Follower};
use super::grid_ray::GridRay;
use super::primary_visibility::{PrimaryVisibility, VisibilityRow};
use super::rows::{GridEntry, NO_CELL, PathNumbers, RowEntries};
use crate::find::ray_map::{RayField, Specular};
use catoptric_core::scene::Ray;
use catoptric_core::scene::hit::PrimitiveHit;
use catoptric_engine::method::projector::SpecularPath;
use std::ops::Range;

/// The accuracy with which the end of paths between neighbouring rays is found, in pixels. Chosen, not measured.
pub(in super::super) const BORDER_PX: f32 = 0.06;

/// Scratch space that workers keep from row to row.
#[derive(Default)]
pub(super) struct GridScratch {
    pub(super) steps: FollowSteps,
    pub(super) numbers: PathNumbers,
    row: VisibilityRow,
}

/// Traces the rays of a field.
pub(in super::super) struct RaySampler<'a> {
    pub(super) specular: &'a Specular<'a>,
    follower: Follower<'a>,
    pub(super) field: &'a dyn RayField,
    pub(in super::super) spacing_px: f32,
    /// Number of regular rays across and down.
    pub(super) size: [u32; 2],
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

    /// The regular rays of a row, with the paths that each takes.
    pub(super) fn row(
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
    pub(super) fn close_in(
        &self,
        cells: [[u32; 2]; 2],
        signature: u64,
        scratch: &mut GridScratch,
        entries: &mut RowEntries,
    ) {
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
