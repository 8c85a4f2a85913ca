//! Traces of appearances to their ends, and the strips drawn between them.

use super::drawing::PieceDrawing;
use super::missed_boundaries::{MissedBoundary, edge_key, key};
use super::shapes::{PieceCorner, TracePlace};
use catoptric_core::math::portable::PortableMath;
use catoptric_engine::method::projector::{Projection, VertexProjector};
use glam::{Vec2, Vec3};
use std::ops::Range;

/// The trace of an appearance to its end.
pub(super) struct BoundaryTrace {
    pub(super) from: TracePlace,
    pub(super) end: TracePlace,
    /// The appearance where the way starts.
    pub(super) one: Projection,
    /// The one that it merges with in the end, at the start of the way.
    pub(super) merging: Option<Projection>,
    /// Drawn points, from the start to the end, with the weights there.
    pub(super) points: Vec<(Projection, Vec2)>,
}

impl BoundaryTrace {
    fn end_px(&self) -> Vec2 {
        self.points.last().unwrap_or(&(self.one, Vec2::ZERO)).0.image_px
    }
}

/// The end of an appearance on an edge is found to this power of a half of the edge, and no better than needed.
const MAX_END_STEPS: u32 = 8;
const MIN_END_STEPS: u32 = 2;

/// Two appearances that merge have come nearer than this share of their earlier distance. Chosen, not measured.
const MERGED: f32 = 0.4;

/// A way has not ended if it got to this many of the smallest shares of it from the other point. Chosen, not measured.
const NOT_ENDED: f32 = 1.5;

/// The way to the end of an appearance is made of no more points than this. A bound on time; chosen, not measured.
const MAX_WAY_POINTS: u32 = 12;

/// Between two ways others are put this many times at the most. A bound on time; chosen, not measured.
const MAX_WAY_HALVINGS: u32 = 4;

/// Ends that are not searched for are drawn no further away than this, in pixels. Chosen, not measured.
const MAX_GUESS_PX: f32 = 24.0;

/// The assumed end of an appearance on a step, without a search, and its share of the step: half-way, but not far.
fn guessed_end(one: &Projection, merging: Option<&Projection>, step: Vec3) -> (Projection, f32) {
    if let Some(other) = merging {
        return (Projection { image_px: (one.image_px + other.image_px) * 0.5, ..*one }, 0.5);
    }
    let moves = one.predicted(step).distance(one.image_px);
    let share = if moves > 0.0 { (MAX_GUESS_PX / moves).min(0.5) } else { 0.5 };
    (Projection { image_px: one.predicted(step * share), ..*one }, share)
}

impl<P: VertexProjector + ?Sized> PieceDrawing<'_, P> {
    /// The way of an appearance from corner `a` towards corner `b` up to where it ends.
    pub(super) fn way_to_end(&mut self, index: usize, a: &PieceCorner, b: &PieceCorner) -> BoundaryTrace {
        let one = self.appearances[index];
        let key = (key(a.position), key(b.position), one.image_px.to_array().map(f32::to_bits));
        let merging =
            self.rule.merging(&self.appearances[index], self.of(a), self.of(b), b.position - a.position).copied();
        let range = match self.ends.get(&key) {
            Some(known) => known.clone(),
            None => {
                let range = self.find_end(one, merging, a.position, b.position);
                self.ends.insert(key, range.clone());
                range
            }
        };
        self.way(one, merging, TracePlace::of(a), TracePlace::of(b), range)
    }

    /// A way whose points after the first are `range` of [`Self::way_points`].
    fn way(
        &self,
        one: Projection,
        merging: Option<Projection>,
        from: TracePlace,
        towards: TracePlace,
        range: Range<u32>,
    ) -> BoundaryTrace {
        let found = &self.way_points[range.start as usize..range.end as usize];
        let mut points = Vec::with_capacity(found.len() + 1);
        points.push((one, from.weights));
        points
            .extend(found.iter().map(|(projection, share)| (*projection, from.weights.lerp(towards.weights, *share))));
        let share = found.last().map_or(0.0, |(_, share)| *share);
        let end = TracePlace {
            position: from.position.lerp(towards.position, share),
            weights: from.weights.lerp(towards.weights, share),
        };
        BoundaryTrace { from, end, one, merging, points }
    }

    /// A way that ends between two others: from where the left one starts.
    fn way_between(&mut self, left: &BoundaryTrace, right: &BoundaryTrace) -> Option<BoundaryTrace> {
        let from = left.from;
        let towards = from.beyond(&left.end.middle(&right.end), &self.piece)?;
        let range = self.find_end(left.one, left.merging, from.position, towards.position);
        let least = 0.5f32.powi(self.end_steps(&left.one, towards.position - from.position) as i32);
        let has_ended = self.way_points.last().is_some_and(|(_, share)| *share < 1.0 - NOT_ENDED * least);
        if !has_ended {
            self.note_dip();
        }
        Some(self.way(left.one, left.merging, from, towards, range))
    }

    /// An appearance reaches the side of the piece that its ways lead to.
    fn note_dip(&mut self) {
        let Some([a, b]) = self.far_side else { return };
        let [p, q] = [a.weights, b.weights];
        let side = [p.x + p.y == 1.0 && q.x + q.y == 1.0, p.x == 0.0 && q.x == 0.0, p.y == 0.0 && q.y == 0.0];
        self.dips.push(MissedBoundary {
            edge: edge_key(a.position, b.position),
            triangle: self.source - self.object.first_triangle,
            side: side.iter().position(|on| *on),
        });
        self.far_side = None;
    }

    /// Number of halvings of a step that find the end of an appearance on it.
    fn end_steps(&self, one: &Projection, step: Vec3) -> u32 {
        let extent = one.predicted(step).distance(one.image_px);
        let steps = (extent / self.rule.end_error_px()).logarithm2().ceil();
        (steps as u32).clamp(MIN_END_STEPS, MAX_END_STEPS)
    }

    /// Finds the points after the first on the way of an appearance to its end, each with its share of the step;
    /// returns their range in [`Self::way_points`].
    ///
    /// In a fold both appearances that merge there end at the same place: half-way between them.
    fn find_end(&mut self, one: Projection, merging: Option<Projection>, from: Vec3, towards: Vec3) -> Range<u32> {
        let first = self.way_points.len() as u32;
        let step = towards - from;
        if self.is_spent() {
            let guess = guessed_end(&one, merging.as_ref(), step);
            self.mesh.unfinished += 1;
            self.way_points.push(guess);
            return first..first + 1;
        }
        let mut met = merging;
        let (mut near, mut far) = (0.0f32, 1.0f32);
        let mut last = one;
        for _ in 0..self.end_steps(&one, step) {
            let share = (near + far) * 0.5;
            let (position, on) = (from.lerp(towards, share), step * (share - near));
            match self.continued(&last, position, on) {
                Some(found) => {
                    (last, near) = (found, share);
                    met = met.and_then(|other| self.continued(&other, position, on).or(Some(other)));
                }
                None => far = share,
            }
        }
        // Towards a fold an appearance moves as the square root of the rest of the way: these shares make even steps.
        let count = (last.image_px.distance(one.image_px) / self.rule.way_step_px()).ceil();
        let (mut known, mut before) = (one, 0.0);
        for number in 1..(count as u32).min(MAX_WAY_POINTS) {
            let left = 1.0 - number as f32 / count;
            let share = near * (1.0 - left * left);
            if let Some(found) = self.continued(&known, from.lerp(towards, share), step * (share - before)) {
                (known, before) = (found, share);
                self.way_points.push((found, share));
            }
        }
        // Others end at a silhouette, and the supposed partner is far away.
        let gap = merging.map_or(0.0, |other| other.image_px.distance(one.image_px));
        if let Some(other) = met
            && other.image_px.distance(last.image_px) < MERGED * gap
        {
            last.image_px = (last.image_px + other.image_px) * 0.5;
            last.path_length = (last.path_length + other.path_length) * 0.5;
        }
        self.way_points.push((last, near));
        first..self.way_points.len() as u32
    }

    /// The appearance at a point that continues one a step away.
    pub(super) fn continued(&mut self, one: &Projection, position: Vec3, step: Vec3) -> Option<Projection> {
        self.scratch.clear();
        self.object.follow(self.projector, one, position, &mut self.scratch);
        self.mesh.points_projected += 1;
        self.rule.continued(one, self.scratch.all(), step).copied()
    }

    /// Draws the area between two ways, with more ways between them where their ends are far from each other.
    pub(super) fn fill(&mut self, left: &BoundaryTrace, right: &BoundaryTrace, depth: u32) {
        let is_wide = !self.is_spent() && left.end_px().distance(right.end_px()) > self.rule.end_step_px();
        if is_wide
            && depth < MAX_WAY_HALVINGS
            && let Some(middle) = self.way_between(left, right)
        {
            self.fill(left, &middle, depth + 1);
            self.fill(&middle, right, depth + 1);
        } else {
            self.fill_between(&left.points, &right.points);
        }
    }

    /// Draws the strip between two ways.
    fn fill_between(&mut self, left: &[(Projection, Vec2)], right: &[(Projection, Vec2)]) {
        let place = |way: &[(Projection, Vec2)], index: usize| way.get(index).map(|(point, _)| point.image_px);
        let (mut i, mut j) = (0, 0);
        while let (Some(&here), Some(&there)) = (left.get(i), right.get(j)) {
            // Goes on along the side that makes the shorter diagonal.
            let on_left = place(left, i + 1).map(|next| next.distance_squared(there.0.image_px));
            let on_right = place(right, j + 1).map(|next| next.distance_squared(here.0.image_px));
            match (on_left, on_right) {
                (Some(left_length), right_length) if right_length.is_none_or(|right| left_length <= right) => {
                    self.push([here, left[i + 1], there]);
                    i += 1;
                }
                (_, Some(_)) => {
                    self.push([here, right[j + 1], there]);
                    j += 1;
                }
                _ => break,
            }
        }
    }
}
