//! Rays between those of the map, traced where these are too few for a camera: as many as it takes.

use super::builder::CameraBuilder;
use super::bundles::{Leaves, places_of};
use super::fit::{Fit, FitSpan, FitTerms};
use crate::sample_based_camera::rays::follow::FollowSteps;
use crate::sample_based_camera::rays::grid_ray::GridRay;
use crate::sample_based_camera::rays::pieces;
use crate::sample_based_camera::rays::sampler::BORDER_PX;

/// Rays across and down a block when it is looked at more closely: two steps finer than two by two.
const ACROSS: usize = 5;

/// Places nearer to each other than this share of a block are one. Chosen, not measured.
const SAME_PLACE: f32 = 1e-3;

/// A part of the map between its regular rays.
struct RayBlock {
    /// The corners of the block, in cells.
    low: [f32; 2],
    high: [f32; 2],
    /// The numbers of the rays in it, all of one piece.
    rays: Vec<u32>,
    /// Spacing, in cells.
    apart: f32,
}

/// Traces rays of one piece of a path.
struct Tracing<'a> {
    builder: &'a CameraBuilder<'a>,
    piece: u32,
    /// Rays around, if there are other pieces among them, with their pieces.
    around: Vec<(GridRay, u32)>,
    steps: FollowSteps,
    found: Leaves,
}

impl CameraBuilder<'_> {
    /// The leaves over rays of a block of the map that cannot be halved any more.
    ///
    /// At most about `limit` rays are traced for it: if these are too few, leaves interpolate.
    pub(in super::super) fn finer(&self, rays: &[u32], piece: u32, limit: u64) -> Leaves {
        let [low, high] = places_of(rays.iter().map(|&ray| &self.group.rays[ray as usize]));
        let cells = |axis: usize| low[axis].floor() as i64..=high[axis].ceil() as i64;
        let around = cells(1).flat_map(|row| cells(0).map(move |column| (column, row)));
        let around = around.flat_map(|(column, row)| self.group.in_cell(column, row));
        let mut around: Vec<(GridRay, u32)> =
            around.map(|ray| (self.group.rays[ray], self.group.piece_of_ray[ray])).collect();
        if around.iter().all(|(_, other)| *other == piece) {
            around.clear();
        }
        let mut tracing =
            Tracing { builder: self, piece, around, steps: FollowSteps::default(), found: Leaves::default() };
        tracing.divide(RayBlock { low, high, rays: rays.to_vec(), apart: 1.0 }, &[], limit);
        tracing.found.traced = tracing.steps.traced;
        tracing.found
    }
}

impl Tracing<'_> {
    fn ray(&self, number: u32) -> &GridRay {
        let own = &self.builder.group.rays;
        (number as usize).checked_sub(own.len()).map_or_else(|| &own[number as usize], |added| &self.found.added[added])
    }

    /// Makes the leaves of a block whose rays are too few for a camera; `around` are the rays of a larger block.
    fn divide(&mut self, mut block: RayBlock, around: &[u32], limit: u64) {
        let longest = (0..2).map(|axis| block.high[axis] - block.low[axis]).fold(0.0, f32::max);
        let apart = longest / (ACROSS - 1) as f32;
        let is_finest = apart * self.builder.sampler.spacing_px < self.builder.demand.finest_ray_px;
        let is_spent = limit < (ACROSS * ACROSS) as u64;
        if is_finest || is_spent {
            self.found.unrefined += u64::from(!is_finest);
            // At the border of the piece a block may have a ray or two.
            if !self.interpolate(&block) {
                block.rays = around.to_vec();
                self.interpolate(&block);
            }
            return;
        }
        let traced = self.steps.traced;
        self.look_closely(&mut block, apart);
        let limit = limit.saturating_sub(self.steps.traced - traced) / 4;
        block.apart = apart;
        if self.fit(&block) {
            return;
        }
        let middle = [0, 1].map(|axis: usize| 0.5 * (block.low[axis] + block.high[axis]));
        for quarter in 0..4 {
            let second = [quarter & 1 == 1, quarter >> 1 == 1];
            let low = [0, 1].map(|axis: usize| if second[axis] { middle[axis] } else { block.low[axis] });
            let high = [0, 1].map(|axis: usize| if second[axis] { block.high[axis] } else { middle[axis] });
            let inside = |place: [f32; 2]| (0..2).all(|axis| (low[axis]..=high[axis]).contains(&place[axis]));
            let rays: Vec<u32> = block.rays.iter().copied().filter(|&ray| inside(self.ray(ray).place)).collect();
            let quarter = RayBlock { low, high, rays, apart };
            if !quarter.rays.is_empty() && !self.fit(&quarter) {
                self.divide(quarter, &block.rays, limit);
            }
        }
    }

    /// Makes a camera of the block's rays, if there is an accurate one.
    fn fit(&mut self, block: &RayBlock) -> bool {
        let rays: Vec<GridRay> = block.rays.iter().map(|&ray| *self.ray(ray)).collect();
        let Some(fit) = self.builder.fit_to(&rays, block.apart) else { return false };
        let span = FitSpan { apart: block.apart, interpolates: false };
        let leaf = fit.leaf(rays.iter(), self.piece, [block.low, block.high], span);
        self.found.push(leaf, block.rays.clone());
        true
    }

    /// Makes a leaf that interpolates between the block's rays, if there are enough.
    fn interpolate(&mut self, block: &RayBlock) -> bool {
        let rays: Vec<GridRay> = block.rays.iter().map(|&ray| *self.ray(ray)).collect();
        let Some(fit) = Fit::nearest(&rays, FitTerms::Quadratic).or_else(|| Fit::interpolating(&rays)) else {
            return false;
        };
        let span = FitSpan { apart: block.apart, interpolates: true };
        let leaf = fit.leaf(rays.iter(), self.piece, [block.low, block.high], span);
        self.found.push(leaf, block.rays.clone());
        true
    }

    /// Traces the rays of a block that are `apart` from each other, and closes in on where the piece ends.
    fn look_closely(&mut self, block: &mut RayBlock, apart: f32) {
        let count = [0, 1].map(|axis: usize| ((block.high[axis] - block.low[axis]) / apart).round() as usize + 1);
        let place_of = |column: usize, row: usize| {
            [(0, column), (1, row)].map(|(axis, index): (usize, usize)| {
                // The last one exactly, whatever the rounding.
                if index + 1 == count[axis] && index > 0 {
                    block.high[axis]
                } else {
                    block.low[axis] + index as f32 * apart
                }
            })
        };
        let places: Vec<[f32; 2]> = (0..count[1])
            .flat_map(|row| (0..count[0]).map(move |column| (column, row)))
            .map(|(c, r)| place_of(c, r))
            .collect();
        let known: Vec<[f32; 2]> = block.rays.iter().map(|&ray| self.ray(ray).place).collect();
        let is_known = |place: &[f32; 2]| {
            let near = |other: &[f32; 2]| (0..2).all(|axis| (other[axis] - place[axis]).abs() < SAME_PLACE * apart);
            known.iter().any(near)
        };
        let seen: Vec<bool> = places.iter().map(|place| is_known(place) || self.trace(*place, block)).collect();
        for row in 0..count[1] {
            for column in 0..count[0] {
                let own = row * count[0] + column;
                let right = (column + 1 < count[0]).then_some(own + 1);
                let below = (row + 1 < count[1]).then_some(own + count[0]);
                for next in [right, below].into_iter().flatten() {
                    match (seen[own], seen[next]) {
                        (true, false) => self.close_in(places[own], places[next], apart, block),
                        (false, true) => self.close_in(places[next], places[own], apart, block),
                        _ => {}
                    }
                }
            }
        }
    }

    /// Adds the last rays of the piece on the way from a place where it is seen to one where it is not.
    fn close_in(&mut self, mut from: [f32; 2], mut to: [f32; 2], apart: f32, block: &mut RayBlock) {
        let mut apart_px = apart * self.builder.sampler.spacing_px;
        while apart_px > BORDER_PX {
            let middle = [0, 1].map(|axis: usize| 0.5 * (from[axis] + to[axis]));
            *(if self.trace(middle, block) { &mut from } else { &mut to }) = middle;
            apart_px *= 0.5;
        }
    }

    /// Adds the ray at a place, if the piece is seen there; whether it is.
    fn trace(&mut self, place: [f32; 2], block: &mut RayBlock) -> bool {
        let builder = self.builder;
        let Some(ray) = builder.sampler.ray_on(&builder.group.path, place, &mut self.steps) else { return false };
        let piece = pieces::of_most_alike(&ray, &self.around, builder.bounds.diagonal().into());
        if piece.is_some_and(|piece| piece != self.piece) {
            return false;
        }
        block.rays.push((builder.group.rays.len() + self.found.added.len()) as u32);
        self.found.added.push(ray);
        true
    }
}
