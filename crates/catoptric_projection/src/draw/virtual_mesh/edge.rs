//! When an edge of virtual geometry is divided, and which appearances at its ends belong together.

use super::picture_scale::PictureScale;
use super::quality::{Ends, MeshQuality};
use catoptric_core::math::Aabb;
use catoptric_engine::method::projector::Projection;
use catoptric_engine::raster::{BLOCK, BlockMask};
use glam::{Vec2, Vec3};

/// Edges longer than this share of their distance from the reflector are divided whatever their ends show: something
/// may appear between them. Chosen, not measured.
const LONGEST: f32 = 0.35;

/// Things in and beside the box of a reflector count as this share of its radius away: where a reflector stands on
/// something, narrow strips of that appear at its foot. Chosen, not measured.
const NEAREST: f32 = 0.1;

/// Bend assumed for an edge too long for a first-order prediction, in pixels.
const UNSEEN: f32 = 1e4;

/// Appearances that are this many times further apart than both are expected to move are not one that has moved.
/// Chosen, not measured.
const JUMP: f32 = 4.0;

/// The greatest distance of the reflection points of appearances that are joined by nearness alone, as a share of the
/// reflector's radius: a quarter of its size. Chosen, not measured.
const JOINED: f32 = 0.5;

/// Edges shorter than this share of the scene are never divided. Chosen, not measured.
const SHORTEST: f32 = 1e-4;

/// Like [`SHORTEST`], where strongly bent pieces are left out: nearly all pieces that are stretched so much are.
const SHORTEST_LEFT_OUT: f32 = 5e-4;

/// The longest pieces on which an appearance ends, in smallest sizes of pieces: the way to the end is followed. Chosen,
/// not measured.
const END_PIECES: f32 = 32.0;

/// The steps in which the way to the end is followed, in smallest sizes of pieces. Chosen, not measured.
const WAY_STEPS: f32 = 5.0;

/// The longest pieces on which appearances end, in pixels, where such pieces are left out: about a block of the
/// picture. Chosen, not measured.
const LEFT_OUT_PX: f32 = 8.0;

/// The smallest bent pieces that are divided, in pixels, where pieces are left out: smaller ones are left out, too.
/// Chosen, not measured.
const SMALLEST_BENT_PX: f32 = 3.0;

/// Pieces in holes that are shorter than this are not divided, in pixels: two blocks. Chosen, not measured.
const IN_HOLE_PX: f32 = 16.0;

/// The accuracy of ends, as a share of the smallest size of pieces. Chosen, not measured.
const END_ERROR: f32 = 0.125;

/// First-order start of the picture of an edge.
struct Bend {
    /// Predicted length, in pixels.
    moves: f32,
    /// The distance of that from the move along a straight edge, in pixels; a quarter of it is the error in the middle.
    deviation: f32,
}

/// Estimates of errors beyond this mean that nothing is known. Chosen, not measured.
const MAX_UNCERTAIN_PX: f32 = 1.0;

/// The length over which the border of an appearance is drawn straight, in smallest sizes of pieces. Chosen, not
/// measured.
const END_STEPS: f32 = 12.0;

/// Rules for edges: everything here depends on the two ends alone, and not on their order.
#[derive(Clone, PartialEq)]
pub(super) struct EdgeRule {
    edge_error_px: f32,
    piece_px: f32,
    is_plain: bool,
    picture: PictureScale,
    ends: Ends,
    center: Vec3,
    radius: f32,
    /// The corners of its box.
    low: Vec3,
    high: Vec3,
    shortest: f32,
}

impl EdgeRule {
    pub(super) fn new(quality: &MeshQuality, last_reflector: &Aabb, scene_size: f32) -> Self {
        Self {
            edge_error_px: quality.edge_error_px,
            piece_px: quality.piece_px,
            is_plain: quality.is_plain,
            picture: quality.picture,
            ends: quality.ends,
            center: last_reflector.center(),
            radius: last_reflector.diagonal() * 0.5,
            low: last_reflector.min,
            high: last_reflector.max,
            shortest: scene_size * if quality.ends == Ends::LeftOut { SHORTEST_LEFT_OUT } else { SHORTEST },
        }
    }

    /// The picture that everything is drawn into.
    pub(super) fn picture(&self) -> &PictureScale {
        &self.picture
    }

    /// The steps in which the way of an appearance to its end is followed, in pixels.
    pub(super) fn way_step_px(&self) -> f32 {
        self.piece_px * WAY_STEPS
    }

    /// Accuracy of ends, in pixels.
    pub(super) fn end_error_px(&self) -> f32 {
        self.piece_px * END_ERROR
    }

    /// The greatest distance of the ends of ways from each other, in pixels: appearances end on a curve.
    pub(super) fn end_step_px(&self) -> f32 {
        self.piece_px * END_STEPS
    }

    /// The priority of an edge's division: 0 where it needs none, else its length in the picture: halving the longest
    /// edges first makes compact pieces.
    ///
    /// Parts in `holes` of the picture are not drawn, and need none.
    pub(super) fn split_priority(
        &self,
        a: Vec3,
        at_a: &[Projection],
        b: Vec3,
        at_b: &[Projection],
        holes: &BlockMask,
    ) -> f32 {
        let step = b - a;
        let length = step.length();
        if length.is_nan() || length <= self.shortest {
            return 0.0;
        }
        let middle = (a + b) * 0.5;
        let beyond = (self.low - middle).max(middle - self.high).max(Vec3::ZERO).length();
        let near = (2.0 * beyond).max(NEAREST * self.radius);
        let distance = middle.distance(self.center).max(self.radius).min(near);
        let excess = length / (LONGEST * distance);
        if excess > 1.0 {
            return excess * UNSEEN;
        }
        if let ([one], [other]) = (at_a, at_b)
            && self.may_join(one, other)
        {
            // The strain is equal from both ends.
            return self.strain_between(one, other, step, holes);
        }
        let forward = at_a.iter().map(|one| self.strain_at(one, at_a, at_b, step, holes));
        let backward = at_b.iter().map(|one| self.strain_at(one, at_b, at_a, -step, holes));
        forward.chain(backward).fold(0.0, f32::max)
    }

    /// Priority of a division by an appearance at one end; `step` leads to the other end.
    fn strain_at(
        &self,
        one: &Projection,
        here: &[Projection],
        there: &[Projection],
        step: Vec3,
        holes: &BlockMask,
    ) -> f32 {
        let Some(other) = self.best(one, here, there, step) else {
            if self.stays_beside(one, step) {
                return 0.0;
            }
            // The appearance ends on the way, at the latest half-way to the appearance that it merges with.
            let way_px = self.way_px(one, here, there, step);
            return if way_px < IN_HOLE_PX && self.is_in_hole(one.image_px, holes) { 0.0 } else { self.ending(way_px) };
        };
        self.strain_between(one, other, step, holes)
    }

    /// Priority of a division of a piece so long, where an appearance ends.
    fn ending(&self, extent: f32) -> f32 {
        let longest = if self.leaves_out() { LEFT_OUT_PX } else { self.piece_px * END_PIECES };
        if extent > longest { extent } else { 0.0 }
    }

    /// True if pieces on which appearances end are left out.
    pub(super) fn leaves_out(&self) -> bool {
        self.ends == Ends::LeftOut
    }

    /// True if a place lies in a hole of the picture, or beside the picture, where pieces are left out.
    pub(super) fn is_in_hole(&self, place_px: Vec2, holes: &BlockMask) -> bool {
        if !self.leaves_out() {
            return false;
        }
        let is_inside = place_px.cmpge(Vec2::ZERO).all() && place_px.cmplt(self.picture.size_px).all();
        let [column, row] = [place_px.x, place_px.y].map(|px| (px / BLOCK as f32) as usize);
        !is_inside || holes.has(column, row)
    }

    /// The distance in the picture, in pixels, that an appearance goes on the way to another point where it does not
    /// appear.
    pub(super) fn way_px(&self, one: &Projection, here: &[Projection], there: &[Projection], step: Vec3) -> f32 {
        let moves = (one.predicted(step) - one.image_px).length();
        // Beside a fold it goes as far as the one that it merges with.
        match self.merging(one, here, there, step) {
            Some(other) => moves.min(0.5 * other.image_px.distance(one.image_px)),
            None => moves,
        }
    }

    /// True if an edge between two appearances is drawn too straight.
    pub(super) fn is_bent(&self, one: &Projection, other: &Projection, step: Vec3) -> bool {
        let depths = self.depths(one, other);
        let (ahead, back) = (bend(one, other, step, depths), bend(other, one, -step, depths.swapped()));
        self.is_too_straight(ahead.deviation.max(back.deviation), uncertainty(one, other))
    }

    fn is_too_straight(&self, deviation: f32, uncertainty_px: f32) -> bool {
        deviation * 0.25 > self.edge_error_px + uncertainty_px
    }

    /// Priority of a division between two appearances that belong together.
    fn strain_between(&self, one: &Projection, other: &Projection, step: Vec3, holes: &BlockMask) -> f32 {
        if self.picture.is_beside([one.image_px, other.image_px]) {
            return 0.0;
        }
        let depths = self.depths(one, other);
        let (ahead, back) = (bend(one, other, step, depths), bend(other, one, -step, depths.swapped()));
        let (distance, extent) = (other.image_px.distance(one.image_px), ahead.moves.max(back.moves));
        if distance > JUMP * extent {
            // One appearance ends and another begins, at any distance: smaller pieces would not bring them together.
            return self.ending(extent);
        }
        if distance.max(extent) < IN_HOLE_PX
            && self.is_in_hole(one.image_px, holes)
            && self.is_in_hole(other.image_px, holes)
        {
            return 0.0;
        }
        let smallest = if self.leaves_out() { SMALLEST_BENT_PX } else { self.piece_px };
        let counts = self.is_too_straight(ahead.deviation.max(back.deviation), uncertainty(one, other))
            && distance.max(extent) > smallest;
        if counts { distance } else { 0.0 }
    }

    /// The divisors of the depths of two appearances.
    fn depths(&self, one: &Projection, other: &Projection) -> Depths {
        Depths { own: self.picture.w(one), other: self.picture.w(other) }
    }

    /// The appearance that `one` merges with in a fold on the way to the other end: the nearest on a neighbouring
    /// sheet, where both end.
    pub(super) fn merging<'a>(
        &self,
        one: &Projection,
        here: &'a [Projection],
        there: &[Projection],
        step: Vec3,
    ) -> Option<&'a Projection> {
        let ends = |other: &&Projection| {
            other.focal_index.abs_diff(one.focal_index) == 1 && self.best(other, here, there, step).is_none()
        };
        nearest(one, here.iter().filter(ends))
    }

    /// The appearance at the other end that belongs to `one`; returns `None` if that is not sure.
    pub(super) fn partner<'a>(
        &self,
        one: &Projection,
        here: &[Projection],
        there: &'a [Projection],
        step: Vec3,
    ) -> Option<&'a Projection> {
        let other = match (here, there) {
            // Mostly there is one on each side.
            ([_], [other]) if self.may_join(one, other) => other,
            _ => self.best(one, here, there, step)?,
        };
        (self.are_near(one, other) || self.are_sure(one, other, step)).then_some(other)
    }

    /// True if two appearances can belong together.
    fn may_join(&self, one: &Projection, other: &Projection) -> bool {
        one.focal_index == other.focal_index || self.are_near(one, other)
    }

    /// True if nearness is enough, and two appearances lie near each other on the first reflector.
    fn are_near(&self, one: &Projection, other: &Projection) -> bool {
        self.is_plain && one.reflection_point.distance(other.reflection_point) <= JOINED * self.radius
    }

    /// True if two appearances at the ends of a step predict each other so well that they must belong together.
    fn are_sure(&self, one: &Projection, other: &Projection, step: Vec3) -> bool {
        let size = other.image_px.distance(one.image_px);
        self.mismatch(one, other, step) <= self.allowed_mismatch(size) + uncertainty(one, other)
    }

    /// The appearance after a step that continues `one`; returns `None` if there is none so near to the predicted one.
    pub(super) fn continued<'a>(
        &self,
        one: &Projection,
        after: &'a [Projection],
        step: Vec3,
    ) -> Option<&'a Projection> {
        let fitting = after.iter().filter(|other| other.focal_index == one.focal_index);
        let other = fitting.min_by(|x, y| self.mismatch(one, x, step).total_cmp(&self.mismatch(one, y, step)))?;
        let distance = other.image_px.distance(one.image_px);
        let size = (one.predicted(step) - one.image_px).length().max(distance);
        let allowed = self.allowed_mismatch(size) + uncertainty(one, other);
        // Beside a fold all appearances are expected to move far, and those found there are not the ones that ended in
        // the fold: these would have to come back as far.
        let depths = self.depths(one, other);
        let back = expected(other, -step, depths.swapped()).distance(other.image_px);
        let jumps = distance > self.way_step_px() && distance > JUMP * back;
        (!jumps && expected(one, step, depths).distance(other.image_px) <= allowed).then_some(other)
    }

    /// The greatest error, in pixels, with which appearances of one sheet that are `size` pixels apart may predict each
    /// other.
    fn allowed_mismatch(&self, size: f32) -> f32 {
        (4.0 * self.edge_error_px).max(2.0 * self.piece_px).max(0.75 * size)
    }

    /// The error with which two appearances at the ends of a step predict each other, in pixels.
    fn mismatch(&self, one: &Projection, other: &Projection, step: Vec3) -> f32 {
        let depths = self.depths(one, other);
        let forward = expected(one, step, depths).distance(other.image_px);
        let backward = expected(other, -step, depths.swapped()).distance(one.image_px);
        forward.max(backward)
    }

    /// The appearance at the other end that is predicted best, if `one` is predicted best by it in turn.
    fn best<'a>(
        &self,
        one: &Projection,
        here: &[Projection],
        there: &'a [Projection],
        step: Vec3,
    ) -> Option<&'a Projection> {
        let fitting = there.iter().filter(|other| self.may_join(one, other));
        let (mut own, mut best) = (f32::INFINITY, None);
        for other in fitting {
            let mismatch = self.mismatch(one, other, step);
            if best.is_none() || mismatch < own {
                (own, best) = (mismatch, Some(other));
            }
        }
        let other = best?;
        let mut rivals = here.iter().filter(|rival| self.may_join(rival, one) && !std::ptr::eq(*rival, one));
        (!rivals.any(|rival| self.mismatch(rival, other, step) < own)).then_some(other)
    }

    /// True if an appearance stays out of the picture over a step, predicted from its start.
    pub(super) fn stays_beside(&self, one: &Projection, step: Vec3) -> bool {
        self.picture.is_beside([one.image_px, one.predicted(step)])
    }
}

/// Divisors of depths: the homogeneous coordinates.
#[derive(Clone, Copy)]
struct Depths {
    own: f32,
    other: f32,
}

impl Depths {
    fn swapped(self) -> Self {
        Self { own: self.other, other: self.own }
    }
}

/// Bend of the picture of an edge, predicted from its start.
fn bend(one: &Projection, other: &Projection, step: Vec3, depths: Depths) -> Bend {
    let moves = one.predicted(step) - one.image_px;
    // The move at the start of a straight edge, in perspective. In the middle of a parabola the deviation is a quarter
    // of the difference.
    let straight = (other.image_px - one.image_px) * (depths.other / depths.own);
    Bend { moves: moves.length(), deviation: (moves - straight).length() }
}

/// The expected appearance of `one` after a step, if it becomes another: seen in perspective, it moves the less the
/// further away it gets.
fn expected(one: &Projection, step: Vec3, depths: Depths) -> Vec2 {
    let moves = one.predicted(step) - one.image_px;
    one.image_px + moves * (depths.own / depths.other)
}

/// The error, in pixels, with which two appearances predict each other because of how they were found: division does
/// not reduce it.
fn uncertainty(one: &Projection, other: &Projection) -> f32 {
    (one.error_px + other.error_px).min(MAX_UNCERTAIN_PX)
}

/// The appearance nearest to `one` in the picture.
fn nearest<'a>(one: &Projection, among: impl Iterator<Item = &'a Projection>) -> Option<&'a Projection> {
    let distance = |other: &Projection| other.image_px.distance_squared(one.image_px);
    among.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
