//! Appearances at the corners of a piece, drawn up to where they end.

use super::boundary_traces::BoundaryTrace;
use super::drawing::PieceDrawing;
use super::shapes::{PieceCorner, TracePlace};
use catoptric_engine::method::projector::{Projection, VertexProjector};

/// The share of the way beyond a fold that is left out, too: part of the surface that ends in a fold comes back on
/// another sheet, at an angle. Chosen, not measured.
const BACK_SHARE: f32 = 0.5;

/// The greatest distance, in pixels, at which the parts left out of a piece are looked for: the solver finds
/// appearances there that are stretched without bounds. Chosen, not measured.
const FARTHEST_LEFT_OUT_PX: f32 = 32.0;

/// The factor by which a piece beside a fold may reach further than its corners predict. There appearances move as the
/// square root of the rest of the way: twice as far as predicted from their start. Chosen, not measured.
const BESIDE_FOLDS: f32 = 1.75;

impl<P: VertexProjector + ?Sized> PieceDrawing<'_, P> {
    /// Draws an appearance, unless an earlier corner has it too.
    pub(super) fn emit_appearance(&mut self, corners: &[PieceCorner; 3], from: usize, index: usize) {
        let own = &corners[from];
        let one = self.appearances[index];
        let mut shared: [Option<usize>; 3] = [None; 3];
        shared[from] = Some(index);
        for (k, other) in corners.iter().enumerate().filter(|(k, _)| *k != from) {
            let partner = self.partner(index, own, other);
            if partner.is_some() && k < from {
                return; // drawn from there
            }
            shared[k] = partner;
        }
        if let [Some(_), Some(_), Some(_)] = shared {
            let (second, third) = ((from + 1) % 3, (from + 2) % 3);
            let agree = shared[second].and_then(|there| self.partner(there, &corners[second], &corners[third]));
            let agrees = agree.is_none() || agree == shared[third];
            let shown = [0, 1, 2].map(|k: usize| shared[k].map_or(one, |at| self.appearances[at]));
            if self.rule.leaves_out() && (!agrees || self.is_bent(corners, &shown)) {
                return self.leave_out(shown.map(|one| one.image_px));
            }
            if agrees {
                self.push([0, 1, 2].map(|k: usize| (shown[k], corners[k].weights)));
            }
            return;
        }
        if self.limit == 0 {
            // The end of the appearance is not known.
            self.mesh.unfinished += 1;
            return;
        }
        let goes_beside = |k: usize| {
            let stays = |at: usize, next: usize| {
                self.rule.stays_beside(&self.appearances[at], corners[next].position - corners[k].position)
            };
            shared[k].is_none_or(|at| stays(at, (k + 1) % 3) && stays(at, (k + 2) % 3))
        };
        if (0..3).all(goes_beside) {
            return;
        }
        if self.rule.leaves_out() {
            return self.emit_beside_hole(corners, shared);
        }
        // Two ways lead from a corner (or from the two of an edge) to the end of the appearance; the drawn part lies
        // between them.
        let mut ways: [Option<BoundaryTrace>; 2] = [None, None];
        let mut number = 0;
        for k in 0..3 {
            let Some(here) = shared[k] else { continue };
            for next in [(k + 1) % 3, (k + 2) % 3] {
                if shared[next].is_none() {
                    ways[number] = Some(self.way_to_end(here, &corners[k], &corners[next]));
                    number += 1;
                }
            }
        }
        if let [Some(left), Some(right)] = &ways {
            self.piece = corners.map(|corner| TracePlace::of(&corner));
            let far = |k: usize| self.piece[(from + k) % 3];
            let alone = shared.iter().flatten().count() == 1;
            self.far_side = alone.then(|| [far(1), far(2)]);
            self.fill(left, right, 0);
        }
    }

    /// Draws a piece that only some corners share into the hole that the others lie in, or leaves it out.
    fn emit_beside_hole(&mut self, corners: &[PieceCorner; 3], shared: [Option<usize>; 3]) {
        let mut shown = shared.map(|index| index.map(|index| self.appearances[index]));
        for k in 0..3 {
            // The start is the corner before, or the one before that.
            let from = [1, 2].map(|back| (k + back) % 3).into_iter().find(|&from| shared[from].is_some());
            if let (None, Some(from)) = (shown[k], from)
                && let Some(index) = shared[from]
            {
                shown[k] = self.continued_into_hole(&self.appearances[index].clone(), &corners[from], &corners[k]);
            }
        }
        if let [Some(a), Some(b), Some(c)] = shown {
            return self.push([(a, corners[0].weights), (b, corners[1].weights), (c, corners[2].weights)]);
        }
        for (k, index) in shared.iter().enumerate() {
            let Some(index) = *index else { continue };
            let (one, here) = (self.appearances[index], &corners[k]);
            let mut places = [one.image_px; 5];
            for next in [1, 2] {
                let there = &corners[(k + next) % 3];
                let step = there.position - here.position;
                let way_px = self.rule.way_px(&self.appearances[index], self.of(here), self.of(there), step);
                let way = (one.predicted(step) - one.image_px).normalize_or_zero();
                let (ahead, back) = (BESIDE_FOLDS * way_px, BACK_SHARE * way_px);
                places[2 * next - 1] += way * ahead.min(FARTHEST_LEFT_OUT_PX);
                places[2 * next] -= way * back.min(FARTHEST_LEFT_OUT_PX);
            }
            self.leave_out(places);
        }
    }

    /// The appearance at another corner into which `one` goes on, if that lies in a hole, where it is not drawn.
    fn continued_into_hole(&mut self, one: &Projection, from: &PieceCorner, to: &PieceCorner) -> Option<Projection> {
        let step = to.position - from.position;
        if !self.rule.is_in_hole(one.predicted(step), &self.mesh.holes) {
            return None;
        }
        let found = self.continued(one, to.position, step);
        Some(found.unwrap_or_else(|| Projection { image_px: one.predicted(step), ..*one }))
    }
}
