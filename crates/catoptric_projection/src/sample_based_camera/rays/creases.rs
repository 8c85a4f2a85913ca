//! Creases, and where one part of a reflector hides another: borders between connected regions of one path's rays.

use super::follow::FollowSteps;
use super::grid_ray::GridRay;
use super::path_rays::DensePathRays;
use super::pieces;
use super::sampler::{BORDER_PX, RaySampler};
use std::collections::BTreeMap;

/// Squares through which a border runs are quartered until they are this large, in pixels; then it is about straight.
/// Chosen, not measured.
const STRAIGHT_PX: f32 = 1.0;

/// A ray and its piece.
type CreaseRay = (GridRay, u32);

/// Follows the borders of one path's pieces.
struct Borders<'a> {
    group: &'a DensePathRays,
    sampler: &'a RaySampler<'a>,
    reach: f64,
    steps: &'a mut FollowSteps,
    /// Traced rays by the bits of row and column: neighbouring squares share places.
    traced: BTreeMap<[u32; 2], Option<CreaseRay>>,
}

/// Rays on both sides of the borders between a path's pieces, with their pieces: close to where borders cross the lines
/// between neighbouring regular rays, and along them between these lines. `reach` is how far rays are expected to go.
pub(in super::super) fn beside(
    group: &DensePathRays,
    sampler: &RaySampler<'_>,
    reach: f64,
    steps: &mut FollowSteps,
) -> Vec<CreaseRay> {
    if group.piece_count < 2 {
        return Vec::new();
    }
    let mut borders = Borders { group, sampler, reach, steps, traced: BTreeMap::new() };
    for own in 0..group.rays.len() {
        let [column, row] = group.cell_of(own);
        if group.regular(column, row) != Some(own) {
            continue;
        }
        let known = |right: i64, down: i64| {
            group.regular(column + right, row + down).map(|ray| (group.rays[ray], group.piece_of_ray[ray]))
        };
        let here = (group.rays[own], group.piece_of_ray[own]);
        let (right, below) = (known(1, 0), known(0, 1));
        for next in [right, below].into_iter().flatten() {
            borders.close_in(here, next, sampler.spacing_px);
        }
        if let (Some(right), Some(below), Some(across)) = (right, below, known(1, 1)) {
            borders.quarter([here, right, below, across]);
        }
    }
    borders.traced.into_values().flatten().collect()
}

impl Borders<'_> {
    /// The ray half-way between two others, of the piece of the one among `others` that it resembles most; returns
    /// `None` if the path is not seen there.
    fn between(&mut self, [a, b]: [&CreaseRay; 2], others: &[CreaseRay]) -> Option<CreaseRay> {
        let place = [0, 1].map(|axis: usize| 0.5 * (a.0.place[axis] + b.0.place[axis]));
        let key = [place[1].to_bits(), place[0].to_bits()];
        if let Some(known) = self.traced.get(&key) {
            return *known;
        }
        let found = self.sampler.ray_on(&self.group.path, place, self.steps).map(|ray| {
            let piece = pieces::of_most_alike(&ray, others, self.reach);
            (ray, piece.unwrap_or(a.1))
        });
        self.traced.insert(key, found);
        found
    }

    /// Traces rays between two of different pieces until the border is found.
    fn close_in(&mut self, mut from: CreaseRay, mut to: CreaseRay, mut apart_px: f32) {
        while from.1 != to.1 && apart_px > BORDER_PX {
            // A third region may lie between the two.
            let Some(middle) = self.between([&from, &to], &[from, to]) else { return };
            *(if middle.1 == to.1 { &mut to } else { &mut from }) = middle;
            apart_px *= 0.5;
        }
    }

    /// Traces rays along the borders in a square: its corners row by row.
    fn quarter(&mut self, corners: [CreaseRay; 4]) {
        let [a, b, c, d] = corners;
        if [b, c, d].iter().all(|corner| corner.1 == a.1) {
            return;
        }
        let size_px = (b.0.place[0] - a.0.place[0]) * self.sampler.spacing_px;
        if size_px <= STRAIGHT_PX {
            for [from, to] in [[a, b], [c, d], [a, c], [b, d]] {
                self.close_in(from, to, size_px);
            }
            return;
        }
        let middles = [[&a, &b], [&a, &c], [&a, &d], [&b, &d], [&c, &d]];
        let [above, left, middle, right, below] = middles.map(|ends| self.between(ends, &corners));
        let quarters = [
            [Some(a), above, left, middle],
            [above, Some(b), middle, right],
            [left, middle, Some(c), below],
            [middle, right, below, Some(d)],
        ];
        for quarter in quarters {
            if let [Some(a), Some(b), Some(c), Some(d)] = quarter {
                self.quarter([a, b, c, d]);
            }
        }
    }
}
