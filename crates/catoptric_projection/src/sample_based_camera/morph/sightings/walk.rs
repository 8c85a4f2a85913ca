//! A reflection point followed while its eye moves from one place to another, beyond the horizon of the mirror too.
//!
//! There the eye sees the place from the other side, and the law of reflection goes on smoothly. But the constraint on
//! unit vectors that solvers of paths use is fulfilled there by the straight line through the mirror as well, and
//! Newton's method prefers that. With `a` and `b` the ways to the eye and to the point, not of unit length, and `t` for
//! their parts across the normal,
//!
//! `a_t (b . n) + b_t (a . n) = 0`
//!
//! holds for reflections, and where both ways graze, each in its own direction: that is recognised. On the horizon
//! itself both are one, so a step over it has to begin near its end: it is taken in strides, each begun where the last
//! two lead.

use crate::find::work;
use catoptric_engine::optics::path::manifold::{ManifoldFrame, ManifoldVertex, SpecularSurfaces};
use glam::{DMat2, DVec2, DVec3, Mat3, Vec3};

/// Strides of the eye: few, and more where these do not lead there. Chosen, not measured.
const FEW_STRIDES: u32 = 2;
const STRIDES: u32 = 8;

/// The greatest mismatch of the ends of the way at which a result of few strides is accepted. Chosen, not measured.
const SAME_SHEET: f32 = 0.35;

/// Steps of Newton's method in each. Chosen, not measured.
const STEPS: u32 = 8;

/// Work of a step.
const WORK_A_STEP: u64 = 3;

/// Sines of the angles at which ways graze. Chosen, not measured.
const GRAZING: f64 = 1e-7;

/// The sine of the angle by which a solved reflection misses the point.
const SOLVED: f64 = 1e-12;

/// The expected move of a reflection point with the eye, by the derivatives at both ends of the eye's way: on one sheet
/// each end's derivative moves the point for half of the way, but for terms of third order.
pub(in super::super) fn expected_move([from, to]: [Mat3; 2], way: Vec3) -> Vec3 {
    (from + to) * (way * 0.5)
}

/// A reflection point and how it moves.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Reflection {
    pub(in super::super) position: DVec3,
    pub(in super::super) normal: DVec3,
    /// A step of the scene point moves it by `moves[0] (by_point[0] . step) + moves[1] (by_point[1] . step)`.
    moves: [DVec3; 2],
    by_point: [DVec3; 2],
    /// A step of the eye likewise.
    by_eye: [DVec3; 2],
}

impl Reflection {
    /// The derivative of the reflection point with respect to the scene point.
    pub(in super::super) fn change_with_point(&self) -> Mat3 {
        self.change(&self.by_point)
    }

    /// The derivative of the reflection point with respect to the eye.
    pub(in super::super) fn change_with_eye(&self) -> Mat3 {
        self.change(&self.by_eye)
    }

    /// The distance of another reflection from the expected place of this one while the eye moves, as a share of the
    /// expected move.
    fn mismatch(&self, other: &Self, way: DVec3) -> f32 {
        let expected = expected_move([self.change_with_eye(), other.change_with_eye()], way.as_vec3());
        (other.position - self.position).as_vec3().distance(expected) / expected.length()
    }

    fn change(&self, by: &[DVec3; 2]) -> Mat3 {
        let column = |axis: usize| (self.moves[0] * by[0][axis] + self.moves[1] * by[1][axis]).as_vec3();
        Mat3::from_cols(column(0), column(1), column(2))
    }
}

/// A place of a surface with its tangents.
type Site = (ManifoldVertex, ManifoldFrame);

/// A mirror and the scene point that it shows.
pub(in super::super) struct Mirror<'a> {
    pub(in super::super) surfaces: &'a SpecularSurfaces<'a>,
    pub(in super::super) object: u32,
    /// The scene point.
    pub(in super::super) point: DVec3,
    /// The reflection point may move so far at a time.
    pub(in super::super) reach: f64,
}

impl Mirror<'_> {
    /// The reflection as an eye sees it near a place; `None` if the method does not converge.
    pub(in super::super) fn seen(&self, eye: DVec3, near: &ManifoldVertex) -> Option<Reflection> {
        self.solved(eye, &self.surfaces.landed(self.object, near)?).map(|(_, found)| found)
    }

    /// The reflection as the eye sees it at the end of its way; `start` is near the one that it sees at the beginning.
    /// `None` if the method does not converge.
    pub(in super::super) fn walked(&self, start: &ManifoldVertex, way: [DVec3; 2]) -> Option<Reflection> {
        let start = self.solved(way[0], &self.surfaces.landed(self.object, start)?)?;
        let found = self.walked_in(FEW_STRIDES, start, way);
        let found = found.filter(|found| start.1.mismatch(found, way[1] - way[0]) <= SAME_SHEET);
        found.or_else(|| self.walked_in(STRIDES, start, way))
    }

    fn walked_in(&self, strides: u32, start: (Site, Reflection), [from, to]: [DVec3; 2]) -> Option<Reflection> {
        let (mut now, mut found) = start;
        let mut before: Option<DVec3> = None;
        for stride in 1..=strides {
            let eye = from.lerp(to, f64::from(stride) / f64::from(strides));
            let expected = before.and_then(|before| self.gone_on(before, &now)).unwrap_or(now);
            before = Some(now.0.position);
            (now, found) = self.solved(eye, &expected)?;
        }
        Some(found)
    }

    /// The place after as much motion again.
    fn gone_on(&self, before: DVec3, now: &Site) -> Option<Site> {
        let [right, up] = now.1.tangents;
        let motion = now.0.position - before;
        let (a, b, c) = (right.length_squared(), right.dot(up), up.length_squared());
        let (along, across) = (motion.dot(right), motion.dot(up));
        let step = DVec2::new(c * along - b * across, a * across - b * along) / (a * c - b * b);
        self.surfaces.stepped(self.object, now, step)
    }

    /// The reflection point near a start.
    fn solved(&self, eye: DVec3, start: &Site) -> Option<(Site, Reflection)> {
        let mut at = *start;
        for _ in 0..=STEPS {
            let constraint = self.constraint(eye, &at)?;
            if constraint.miss < SOLVED {
                return constraint.is_reflection.then(|| (at, constraint.reflection(&at)));
            }
            at = self.surfaces.stepped(self.object, &at, constraint.step)?;
            if at.0.position.distance_squared(start.0.position) > self.reach * self.reach {
                return None;
            }
        }
        None
    }

    /// The constraint at a place.
    fn constraint(&self, eye: DVec3, (at, frame): &Site) -> Option<Constraint> {
        work::add(WORK_A_STEP);
        let ManifoldFrame { normal, tangents, normal_change, .. } = *frame;
        let (a, b) = (eye - at.position, self.point - at.position);
        let (up_a, up_b) = (a.dot(normal), b.dot(normal));
        let across = tangents.map(|tangent| tangent - normal * tangent.dot(normal));
        let missed = across.map(|across| (a * up_b + b * up_a).dot(across));
        // The change with a step along each tangent: the ways become shorter by it, the normal turns.
        let change = [0, 1].map(|axis: usize| {
            let (tangent, turn) = (tangents[axis], normal_change[axis]);
            let slant = tangent.dot(normal);
            let change = a * (b.dot(turn) - slant) + b * (a.dot(turn) - slant)
                - tangent * (up_a + up_b)
                - turn * (2.0 * up_a * up_b);
            DVec2::new(change.dot(across[0]), change.dot(across[1]))
        });
        let inverse = DMat2::from_cols(change[0], change[1]).inverse();
        let missed = DVec2::from(missed);
        let miss = missed.length() / (a.length() * b.length() * across[0].length().max(across[1].length()));
        (inverse.is_finite() && miss.is_finite()).then_some(Constraint {
            step: -(inverse * missed),
            miss,
            is_reflection: up_a * up_b > 0.0 && up_a.abs() > GRAZING * a.length() && up_b.abs() > GRAZING * b.length(),
            inverse,
            by_point: across.map(|across| normal * a.dot(across) + across * up_a),
            by_eye: across.map(|across| normal * b.dot(across) + across * up_b),
        })
    }
}

/// The constraint to first order.
struct Constraint {
    /// The step of Newton's method along the tangents.
    step: DVec2,
    /// The sine of the angle by which the reflection misses the point.
    miss: f64,
    /// True if both ways are on one side of the mirror.
    is_reflection: bool,
    /// The inverse of the constraint's derivative: from changes of the constraint to steps.
    inverse: DMat2,
    /// The derivative of the constraint with respect to the scene point.
    by_point: [DVec3; 2],
    /// The derivative of the constraint with respect to the eye.
    by_eye: [DVec3; 2],
}

impl Constraint {
    /// The reflection at a place where it is fulfilled.
    fn reflection(&self, (at, frame): &Site) -> Reflection {
        let Self { inverse, by_point, by_eye, .. } = *self;
        let along = |axis: usize| -(frame.tangents[0] * inverse.col(axis).x + frame.tangents[1] * inverse.col(axis).y);
        Reflection { position: at.position, normal: frame.normal, moves: [along(0), along(1)], by_point, by_eye }
    }
}
