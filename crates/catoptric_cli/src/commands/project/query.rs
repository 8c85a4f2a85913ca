//! Answers for points: chunk by chunk, on all threads, in their order.

use super::camera::PinholeCamera;
use super::input::Points;
use super::output::{Row, Table};
use crate::failure::Failure;
use catoptric::methods::path_query::{FoundPath, PathSearch};
use catoptric::methods::projection::find::path_visibility::PathVisibility;
use catoptric::methods::projector::MAX_BOUNCES;
use catoptric::parallel;
use catoptric::progress::{Cancelled, Progress};
use glam::DVec3;
use std::io;

/// Points that are read, projected and written together.
const CHUNK: usize = 16_384;
/// Points that a thread takes at a time.
const PIECE: usize = 128;
/// The counts of points by their outcome.
#[derive(Clone, Copy, Default)]
pub(super) struct PointCounts {
    pub(super) points: u64,
    pub(super) reflections: u64,
    /// Points that nothing hides from the eye, where that was asked for.
    pub(super) in_sight: u64,
    pub(super) without: u64,
    pub(super) infinite: u64,
    pub(super) cut_short: u64,
}

/// The search and view for every point.
pub(super) struct Query<'a> {
    pub(super) search: &'a dyn PathSearch,
    /// Leaves out paths that reflectors and lenses block; `None` if none is left out, or if the search does it.
    pub(super) visibility: Option<PathVisibility<'a>>,
    /// Tells what hides points in pictures.
    pub(super) hiding: PathVisibility<'a>,
    pub(super) eye: DVec3,
    /// The camera in whose picture bounce points have their pixels.
    pub(super) camera: Option<PinholeCamera>,
    pub(super) table: &'a Table,
    /// The straight lines from eye to points are rows, too.
    pub(super) direct: bool,
    /// Where the scene's origin lies in the coordinates of points.
    pub(super) origin: DVec3,
}

pub(super) enum StreamError {
    Cancelled(Cancelled),
    Points(Failure),
    Output(io::Error),
}

/// Reads, projects and writes chunk by chunk: the next is read while one is projected.
pub(super) fn stream(
    points: &mut Points,
    query: &Query<'_>,
    progress: &dyn Progress,
    mut write: impl FnMut(&[u8]) -> io::Result<()>,
) -> Result<PointCounts, StreamError> {
    let mut counts = PointCounts::default();
    let mut chunk = points.read(CHUNK).map_err(StreamError::Points)?;
    while !chunk.is_empty() {
        let first = counts.points;
        let (pieces, next) = rayon::join(|| query.answer(first, &chunk), || points.read(CHUNK));
        for (rows, piece) in &pieces {
            write(rows).map_err(StreamError::Output)?;
            counts.points += piece.points;
            counts.reflections += piece.reflections;
            counts.in_sight += piece.in_sight;
            counts.without += piece.without;
            counts.infinite += piece.infinite;
            counts.cut_short += piece.cut_short;
        }
        chunk = next.map_err(StreamError::Points)?;
        progress.at("projecting", points.bytes_read(), points.total_bytes()).map_err(StreamError::Cancelled)?;
    }
    Ok(counts)
}

impl Query<'_> {
    /// The rows of a chunk of points, in pieces, in order.
    fn answer(&self, first: u64, chunk: &[DVec3]) -> Vec<(Vec<u8>, PointCounts)> {
        parallel::map_init_collect(chunk.len().div_ceil(PIECE), Vec::new, |found, piece| {
            let start = piece * PIECE;
            let points = &chunk[start..(start + PIECE).min(chunk.len())];
            let mut rows = self.table.rows();
            let mut counts = PointCounts { points: points.len() as u64, ..PointCounts::default() };
            for (index, &point) in points.iter().enumerate() {
                found.clear();
                let (number, place, point) = (first + (start + index) as u64, point, point - self.origin);
                if self.direct {
                    let length = self.eye.distance(point);
                    let path =
                        FoundPath { path: self.table.straight(), optical_length: length, ..FoundPath::default() };
                    let blocked_by = self.hiding.first_blocker(self.eye, point, &[], &[]);
                    counts.in_sight += u64::from(blocked_by.is_none());
                    rows.push(&self.row((number, place), &path, blocked_by, point));
                }
                let outcome = self.search.search(point, found);
                counts.cut_short += u64::from(outcome.cut_short);
                if outcome.infinite {
                    counts.infinite += 1;
                    continue;
                }
                found.retain(|path| self.is_visible(path, point));
                counts.reflections += found.len() as u64;
                counts.without += u64::from(found.is_empty());
                for path in found.iter() {
                    let bounces = &self.search.paths()[path.path as usize].bounces;
                    let bounce_points = &path.bounce_points[..path.bounce_count.min(MAX_BOUNCES)];
                    let blocked_by = self.hiding.first_blocker(self.eye, point, bounces, bounce_points);
                    rows.push(&self.row((number, place), path, blocked_by, path.bounce_points[0]));
                }
            }
            (rows.into_bytes(), counts)
        })
    }

    /// The row of a path to a point, whose first place from the eye is `seen_at`.
    fn row<'p>(
        &self,
        (point, place): (u64, DVec3),
        path: &'p FoundPath,
        blocked_by: Option<u32>,
        seen_at: DVec3,
    ) -> Row<'p> {
        let image = self.camera.as_ref().and_then(|camera| camera.pixel_of(seen_at));
        let in_picture = self.camera.as_ref().map(|camera| image.is_some_and(|pixel| camera.holds(pixel)));
        Row { point, place, path, image, in_picture, blocked_by }
    }

    fn is_visible(&self, path: &FoundPath, point: DVec3) -> bool {
        self.visibility.as_ref().is_none_or(|visibility| {
            let bounces = &path.bounce_points[..path.bounce_count.min(MAX_BOUNCES)];
            visibility.is_visible(self.eye, point, &self.search.paths()[path.path as usize], bounces)
        })
    }
}
