//! Exact specular paths by Newton's method on the specular constraint.
//!
//! At a bounce with unit vectors `w` towards its two neighbours on the path and indices of refraction `eta` of the
//! media that they lead through, light takes the path if `h = eta w + eta' w'` is along the normal (Walter and others
//! 2007, section 4; for reflection both indices are 1 and `h` is the half vector). The unknowns are two tangent
//! coordinates a bounce. A bounce's constraint depends on its neighbours alone, so Newton's matrix is block-tridiagonal
//! (Jakob and Marschner 2012, section 4) and is solved by elimination of its 2x2 blocks.

mod damped;

use super::bundle::{Bounce, BounceKind, Eye, RayBundle};
use crate::optics::path::manifold::{ManifoldFrame, ManifoldVertex, SpecularSurfaces};
use catoptric_core::surface::SurfacePatch;
use glam::{DMat2, DVec2, DVec3};

/// The most bounces of a projected path.
pub const MAX_BOUNCES: usize = 4;

/// The bounces of a path and where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSites {
    /// The number of bounces, at most [`MAX_BOUNCES`].
    pub count: usize,
    /// The interactions, from the eye; entries from `count` on are unused.
    pub bounces: [Bounce; MAX_BOUNCES],
    /// Their places, from the eye.
    pub sites: [ManifoldVertex; MAX_BOUNCES],
}

impl PathSites {
    /// A path from its bounces, counted from the eye; returns `None` if there are more than [`MAX_BOUNCES`].
    pub fn new(bounces: &[(Bounce, ManifoldVertex)]) -> Option<Self> {
        let mut path = Self {
            count: bounces.len(),
            bounces: [Bounce { object: 0, kind: BounceKind::Reflect }; MAX_BOUNCES],
            sites: [ManifoldVertex::default(); MAX_BOUNCES],
        };
        for (k, (bounce, site)) in bounces.iter().enumerate() {
            *path.bounces.get_mut(k)? = *bounce;
            path.sites[k] = *site;
        }
        Some(path)
    }
}

/// The result of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// The path.
    pub sites: PathSites,
    /// The largest norm over the bounces of the constraint: of the part of `h` across the normal.
    pub residual: f64,
    /// Newton steps taken.
    pub steps: u32,
    /// The residual is at most the tolerance.
    pub converged: bool,
}

/// Steps are halved at most this often.
const MAX_HALVINGS: u32 = 5;

/// Three steps must bring the residual below this share of its value, or there is nothing to be found. Far from the
/// path, where the length of a step is limited, it shrinks slowly; at a double root (on a caustic) each step takes
/// three quarters of it away.
const MIN_PROGRESS: f64 = 0.9;

/// The longest step of a bounce, of the distance to its nearer neighbour and of the radius of curvature.
const LONGEST_STEP: f64 = 0.7;

/// Moves the bounces of a path until light from `point` reaches the eye along it.
///
/// `start` is near the path that is looked for. At most `max_steps` steps are taken, Newton's and, where these fail on
/// two bounces and more, damped ones; they end as soon as the residual is at most `tolerance` (1e-10, say; rounding
/// leaves about 1e-15). If they do not reach it, the last path is returned with `converged` false. Bounces may end up
/// beyond the borders of open surfaces, on their continuation: see [`SpecularSurfaces::is_within`]. Occlusion by other
/// objects is not tested here.
///
/// Returns `None` if the path leaves a surface, the matrix is singular, anything is not finite, or the path is of the
/// wrong branch: a reflection with its neighbours on opposite sides, a transmission with both on one side or towards
/// the wrong one, a lens whose inside the path enters and leaves by the outside.
pub fn solve(
    surfaces: &SpecularSurfaces<'_>,
    eye: &Eye,
    point: DVec3,
    start: &PathSites,
    max_steps: u32,
    tolerance: f64,
) -> Option<Solution> {
    solve_within(surfaces, eye, point, start, max_steps, tolerance, f64::INFINITY)
}

/// As [`solve`], but gives up (`None`) as soon as the first bounce is further than `reach` from where it started: for
/// callers with other starts for places beyond.
pub fn solve_within(
    surfaces: &SpecularSurfaces<'_>,
    eye: &Eye,
    point: DVec3,
    start: &PathSites,
    max_steps: u32,
    tolerance: f64,
    reach: f64,
) -> Option<Solution> {
    match start.count {
        1 => Problem::<1>::new(surfaces, eye, point, start)?.solved(max_steps, tolerance, reach),
        2 => Problem::<2>::new(surfaces, eye, point, start)?.solved(max_steps, tolerance, reach),
        3 => Problem::<3>::new(surfaces, eye, point, start)?.solved(max_steps, tolerance, reach),
        4 => Problem::<4>::new(surfaces, eye, point, start)?.solved(max_steps, tolerance, reach),
        _ => None,
    }
}

/// The residual of a path as it stands (see [`Solution::residual`]); returns `None` if there is no constraint.
pub fn residual(surfaces: &SpecularSurfaces<'_>, eye: &Eye, point: DVec3, path: &PathSites) -> Option<f64> {
    match path.count {
        1 => Problem::<1>::new(surfaces, eye, point, path)?.residual(),
        2 => Problem::<2>::new(surfaces, eye, point, path)?.residual(),
        3 => Problem::<3>::new(surfaces, eye, point, path)?.residual(),
        4 => Problem::<4>::new(surfaces, eye, point, path)?.residual(),
        _ => None,
    }
}

/// The path's outgoing rays with all their neighbours, to second order: for its Jacobian and its focal points.
///
/// Returns `None` if a surface has no normal, a ray grazes, or the path is refracted where there is total reflection.
pub fn bundle_of(surfaces: &SpecularSurfaces<'_>, eye: &Eye, path: &PathSites) -> Option<RayBundle> {
    bundle_over(surfaces, eye, path, |object, site| surfaces.patch(object, site)).map(|(bundle, _)| bundle)
}

/// The path's outgoing rays to first order, and for every bounce whether it is met from the outer side.
///
/// Cheaper than [`bundle_of`]: the second derivatives of the bundle are invalid. Returns `None` in the same cases.
pub fn first_order_bundle_of(
    surfaces: &SpecularSurfaces<'_>,
    eye: &Eye,
    path: &PathSites,
) -> Option<(RayBundle, [bool; MAX_BOUNCES])> {
    bundle_over(surfaces, eye, path, |object, site| {
        let ManifoldFrame { position, normal, tangents, normal_change } = surfaces.frame(object, site)?;
        Some(SurfacePatch { position, normal, tangents, normal_change, ..SurfacePatch::default() })
    })
}

/// The outgoing rays of a path over patches of its surfaces, and which bounces are met from the outer side.
#[inline]
fn bundle_over(
    surfaces: &SpecularSurfaces<'_>,
    eye: &Eye,
    path: &PathSites,
    patch_at: impl Fn(u32, &ManifoldVertex) -> Option<SurfacePatch>,
) -> Option<(RayBundle, [bool; MAX_BOUNCES])> {
    let mut bundle: Option<RayBundle> = None;
    let mut outside = [true; MAX_BOUNCES];
    for (k, (bounce, site)) in path.bounces.get(..path.count)?.iter().zip(&path.sites).enumerate() {
        let patch = patch_at(bounce.object, site)?;
        let (arrived, parameters) = match &bundle {
            None => (RayBundle::arriving(eye, &patch)?, RayBundle::own_parameters()),
            Some(bundle) => bundle.advanced(&patch)?,
        };
        outside[k] = arrived.direction.value.dot(patch.normal) <= 0.0;
        let index = surfaces.index_of(bounce.object);
        bundle = Some(arrived.scattered(&patch, &parameters, bounce.kind, index)?);
    }
    Some((bundle?, outside))
}

/// The way from a bounce to a neighbour.
#[derive(Clone, Copy)]
struct Leg {
    /// The unit vector to it.
    towards: DVec3,
    /// One over the distance; 0 at infinity.
    inverse_length: f64,
}

impl Leg {
    #[inline]
    fn between(from: DVec3, to: DVec3) -> Option<Self> {
        let way = to - from;
        let inverse_length = way.length_squared().sqrt().recip();
        let towards = way * inverse_length;
        (inverse_length > 0.0 && towards.is_finite()).then_some(Self { towards, inverse_length })
    }

    /// The change of the unit vector as its end moves.
    #[inline]
    fn turned(&self, motion: DVec3) -> DVec3 {
        (motion - self.towards * self.towards.dot(motion)) * self.inverse_length
    }
}

/// A bounce's constraint.
#[derive(Clone, Copy)]
struct BounceConstraint {
    to_eye: Leg,
    to_point: Leg,
    /// The generalised half vector `h`.
    half: DVec3,
    /// The part of it across the normal, squared length.
    across2: f64,
    /// Everything is on the side where it belongs.
    on_branch: bool,
}

/// The constraints of a bounce to first order.
struct Linearised {
    own: DMat2,
    before: DMat2,
    after: DMat2,
    rest: DVec2,
}

/// A path on its way to a solution.
#[doc(hidden)]
pub struct Problem<'a, const N: usize> {
    surfaces: &'a SpecularSurfaces<'a>,
    eye: &'a Eye,
    point: DVec3,
    bounces: [Bounce; N],
    /// Indices of refraction towards the eye and towards the point.
    indices: [[f64; 2]; N],
    /// True if a transmission comes (seen from the eye) from the outer side.
    from_outside: [bool; N],
    at: [(ManifoldVertex, ManifoldFrame); N],
    constraints: [BounceConstraint; N],
}

impl<'a, const N: usize> Problem<'a, N> {
    /// The path as it stands; returns `None` if it has no constraint.
    pub fn new(
        surfaces: &'a SpecularSurfaces<'a>,
        eye: &'a Eye,
        point: DVec3,
        path: &PathSites,
    ) -> Option<Problem<'a, N>> {
        let bounces: [Bounce; N] = path.bounces.get(..N)?.try_into().ok()?;
        let mut at = [(ManifoldVertex::default(), ManifoldFrame::default()); N];
        for k in 0..N {
            at[k] = surfaces.landed(bounces[k].object, &path.sites[k])?;
        }
        let mut from_outside = [true; N];
        let mut indices = [[1.0; 2]; N];
        for k in 0..N {
            let previous = if k == 0 { None } else { Some(at[k - 1].1.position) };
            let frame = &at[k].1;
            let direction = match previous {
                None => eye.direction_to(frame.position)?,
                Some(previous) => frame.position - previous,
            };
            from_outside[k] = direction.dot(frame.normal) <= 0.0;
            if bounces[k].kind == BounceKind::Transmit {
                if !surfaces.is_lens(bounces[k].object) {
                    return None;
                }
                let index = surfaces.index_of(bounces[k].object);
                indices[k] = if from_outside[k] { [1.0, index] } else { [index, 1.0] };
            }
        }
        let unset = Leg { towards: DVec3::ZERO, inverse_length: 0.0 };
        let unset =
            BounceConstraint { to_eye: unset, to_point: unset, half: DVec3::ZERO, across2: 0.0, on_branch: false };
        let mut problem = Problem { surfaces, eye, point, bounces, indices, from_outside, at, constraints: [unset; N] };
        problem.constraints = problem.constraints_at(&at)?;
        Some(problem)
    }

    /// The constraints of a path; returns `None` if two neighbours coincide or are not finite.
    #[inline]
    fn constraints_at(&self, at: &[(ManifoldVertex, ManifoldFrame); N]) -> Option<[BounceConstraint; N]> {
        let mut constraints = self.constraints;
        for k in 0..N {
            let frame = &at[k].1;
            let to_eye = match (k, self.eye) {
                (0, Eye::Point(eye)) => Leg::between(frame.position, *eye)?,
                (0, Eye::Direction(direction)) => Leg { towards: -*direction, inverse_length: 0.0 },
                _ => Leg::between(frame.position, at[k - 1].1.position)?,
            };
            let next = if k + 1 < N { at[k + 1].1.position } else { self.point };
            let to_point = Leg::between(frame.position, next)?;
            let half = to_eye.towards * self.indices[k][0] + to_point.towards * self.indices[k][1];
            let across2 = (half - frame.normal * half.dot(frame.normal)).length_squared();
            let on_branch = self.is_on_branch(k, frame, &to_eye, &to_point);
            constraints[k] = BounceConstraint { to_eye, to_point, half, across2, on_branch };
        }
        Some(constraints)
    }

    /// Returns true if both legs of a bounce are on the sides where they belong, by the shading normal.
    #[inline]
    fn is_on_branch(&self, k: usize, frame: &ManifoldFrame, to_eye: &Leg, to_point: &Leg) -> bool {
        let cosines = (to_eye.towards.dot(frame.normal), to_point.towards.dot(frame.normal));
        match self.bounces[k].kind {
            BounceKind::Reflect => cosines.0 * cosines.1 > 0.0,
            BounceKind::Transmit => cosines.0 * cosines.1 < 0.0 && (cosines.0 > 0.0) == self.from_outside[k],
        }
    }

    fn residual(&self) -> Option<f64> {
        let residual = largest(&self.constraints);
        residual.is_finite().then_some(residual)
    }

    /// The sum of the squares of the constraints.
    #[inline]
    pub fn square(&self) -> f64 {
        sum_of_squares(&self.constraints)
    }

    /// The same after a step; returns `None` if it leaves a surface.
    pub fn square_after(&self, step: &[DVec2; N]) -> Option<f64> {
        let at = self.stepped(step, 1.0)?;
        self.constraints_at(&at).map(|constraints| sum_of_squares(&constraints))
    }

    /// Returns true if Newton's method alone finds a path of the right branch.
    pub fn is_solved_by_newton(mut self, max_steps: u32, tolerance: f64) -> bool {
        self.newton(max_steps, &mut 0, tolerance, f64::INFINITY);
        largest(&self.constraints) <= tolerance && self.is_consistent()
    }

    /// Newton's method, and damped steps where it fails.
    fn solved(mut self, max_steps: u32, tolerance: f64, reach: f64) -> Option<Solution> {
        let start = (self.at, self.constraints);
        let mut steps = 0;
        let came_to_an_end = self.newton(max_steps, &mut steps, tolerance, reach).is_some();
        let mut residual = largest(&self.constraints);
        if N > 1 && residual > tolerance && steps < max_steps {
            (self.at, self.constraints) = start;
            residual = self.descended(max_steps, &mut steps, tolerance, reach);
        } else if !came_to_an_end {
            return None;
        }
        if !residual.is_finite() || !self.is_consistent() {
            return None;
        }
        let mut sites = PathSites {
            count: N,
            bounces: [self.bounces[0]; MAX_BOUNCES],
            sites: [ManifoldVertex::default(); MAX_BOUNCES],
        };
        for k in 0..N {
            sites.bounces[k] = self.bounces[k];
            sites.sites[k] = self.at[k].0;
        }
        Some(Solution { sites, residual, steps, converged: residual <= tolerance })
    }

    /// Newton's method; returns `None` if a step cannot be taken or leaves the reach.
    fn newton(&mut self, max_steps: u32, steps: &mut u32, tolerance: f64, reach: f64) -> Option<()> {
        let start = self.at[0].1.position;
        let mut residual = largest(&self.constraints);
        // The residuals of the last three steps, the latest first.
        let mut earlier = [f64::INFINITY; 3];
        while residual > tolerance && *steps < max_steps && residual < MIN_PROGRESS * earlier[2] {
            earlier = [residual, earlier[0], earlier[1]];
            let step = self.newton_step()?;
            if !self.advance(&step)? {
                break;
            }
            if self.at[0].1.position.distance_squared(start) > reach * reach {
                return None;
            }
            *steps += 1;
            residual = largest(&self.constraints);
        }
        Some(())
    }

    /// The linearised constraints of a bounce: their change with its own motion, with that of the bounce before and of
    /// the one after (zero where there is none), and the negative constraints.
    #[inline]
    fn linearised(&self, k: usize) -> Linearised {
        let (frame, constraint) = (&self.at[k].1, &self.constraints[k]);
        let (normal, half) = (frame.normal, constraint.half);
        let slant = frame.tangents.map(|tangent| tangent.dot(normal));
        let across = [0, 1].map(|i: usize| frame.tangents[i] - normal * slant[i]);
        let project = |change: DVec3| DVec2::new(change.dot(across[0]), change.dot(across[1]));
        let [index_eye, index_point] = self.indices[k];
        let along = half.dot(normal);
        // C_i = h . t_i - (h . n) (n . t_i), the second term for tangents that an interpolated normal is not
        // perpendicular to.
        let own = [0, 1].map(|j: usize| {
            let (motion, turn) = (frame.tangents[j], frame.normal_change[j]);
            let change =
                constraint.to_eye.turned(motion) * -index_eye + constraint.to_point.turned(motion) * -index_point;
            let turned = half.dot(turn);
            project(change)
                - DVec2::new(
                    turned * slant[0] + along * turn.dot(frame.tangents[0]),
                    turned * slant[1] + along * turn.dot(frame.tangents[1]),
                )
        });
        let neighbour = |to: &Leg, index: f64, neighbour: usize| {
            let block = self.at[neighbour].1.tangents.map(|motion| project(to.turned(motion) * index));
            DMat2::from_cols(block[0], block[1])
        };
        Linearised {
            own: DMat2::from_cols(own[0], own[1]),
            before: if k > 0 { neighbour(&constraint.to_eye, index_eye, k - 1) } else { DMat2::ZERO },
            after: if k + 1 < N { neighbour(&constraint.to_point, index_point, k + 1) } else { DMat2::ZERO },
            rest: -project(half),
        }
    }

    /// The step to where the linearised constraints vanish.
    #[inline]
    pub fn newton_step(&self) -> Option<[DVec2; N]> {
        // Forward elimination: row k then reads u[k] + over[k] u[k + 1] = right[k].
        let mut over = [DMat2::ZERO; N];
        let mut right = [DVec2::ZERO; N];
        for k in 0..N {
            let Linearised { own: mut matrix, before, after, mut rest } = self.linearised(k);
            if k > 0 {
                matrix -= before * over[k - 1];
                rest -= before * right[k - 1];
            }
            let inverse = inverted(&matrix)?;
            right[k] = inverse * rest;
            over[k] = inverse * after;
        }
        for k in (0..N.saturating_sub(1)).rev() {
            let following = right[k + 1];
            right[k] -= over[k] * following;
        }
        Some(right)
    }

    /// Goes along a step as far as the residual shrinks; false if it does not shrink at all, `None` if every
    /// part of the step leaves a surface.
    #[inline]
    fn advance(&mut self, step: &[DVec2; N]) -> Option<bool> {
        let before = self.square();
        let was_on_branch = self.constraints.iter().all(|constraint| constraint.on_branch);
        let mut share = self.trusted_share(step);
        let mut stayed = false;
        for _ in 0..=MAX_HALVINGS {
            if let Some(at) = self.stepped(step, share) {
                stayed = true;
                if let Some(constraints) = self.constraints_at(&at) {
                    let after = sum_of_squares(&constraints);
                    let is_on_branch = constraints.iter().all(|constraint| constraint.on_branch);
                    if after < before && (is_on_branch || !was_on_branch) {
                        (self.at, self.constraints) = (at, constraints);
                        return Some(true);
                    }
                }
            }
            share *= 0.5;
        }
        stayed.then_some(false)
    }

    /// The share of a step within which the linearisation is valid.
    #[inline]
    fn trusted_share(&self, step: &[DVec2; N]) -> f64 {
        let mut share: f64 = 1.0;
        for ((step, (_, frame)), constraint) in step.iter().zip(&self.at).zip(&self.constraints) {
            let turn2 = frame.normal_change[0].length_squared().max(frame.normal_change[1].length_squared());
            let legs = constraint.to_eye.inverse_length.max(constraint.to_point.inverse_length);
            let sharpest2 = turn2.max(legs * legs);
            let limit2 = LONGEST_STEP * LONGEST_STEP / sharpest2;
            let length2 = step.length_squared();
            if length2 * share * share > limit2 {
                share = (limit2 / length2).sqrt();
            }
        }
        share
    }

    #[inline]
    fn stepped(&self, step: &[DVec2; N], share: f64) -> Option<[(ManifoldVertex, ManifoldFrame); N]> {
        let mut at = self.at;
        for k in 0..N {
            at[k] = self.surfaces.stepped(self.bounces[k].object, &self.at[k], step[k] * share)?;
        }
        Some(at)
    }

    /// Returns true if all of the path lies on the surfaces of its bounces.
    fn is_consistent(&self) -> bool {
        let side = |k: usize, leg: &Leg| leg.towards.dot(self.at[k].1.geometric_normal()) > 0.0;
        for k in 0..N {
            let (bounce, constraint) = (&self.bounces[k], &self.constraints[k]);
            let (eye_side, point_side) = (side(k, &constraint.to_eye), side(k, &constraint.to_point));
            let reflects = bounce.kind == BounceKind::Reflect;
            let is_blind = reflects && eye_side && self.surfaces.is_mirror_inside_only(bounce.object);
            if !constraint.on_branch || reflects != (eye_side == point_side) || is_blind {
                return false;
            }
            // Between two bounces on one body light stays inside it or outside.
            let stays = |next: usize| {
                let same_body = self.bounces[next].object == bounce.object && self.surfaces.is_lens(bounce.object);
                !same_body || side(next, &self.constraints[next].to_eye) == point_side
            };
            if k + 1 < N && !stays(k + 1) {
                return false;
            }
        }
        true
    }
}

#[inline]
fn sum_of_squares<const N: usize>(constraints: &[BounceConstraint; N]) -> f64 {
    constraints.iter().map(|constraint| constraint.across2).sum()
}

fn largest<const N: usize>(constraints: &[BounceConstraint; N]) -> f64 {
    let mut largest2 = 0.0;
    for constraint in constraints {
        // Not `max`, which would swallow a NaN.
        if constraint.across2 > largest2 || constraint.across2.is_nan() {
            largest2 = constraint.across2;
        }
    }
    largest2.sqrt()
}

/// The inverse of a matrix that is not singular to rounding.
#[inline]
fn inverted(matrix: &DMat2) -> Option<DMat2> {
    let (a, b) = (matrix.x_axis, matrix.y_axis);
    let determinant = a.x * b.y - b.x * a.y;
    let scale2 = a.length_squared() + b.length_squared();
    let is_regular = determinant.abs() > 1e-15 * scale2;
    let inverse = 1.0 / determinant;
    let inverted = DMat2::from_cols(DVec2::new(b.y, -a.y) * inverse, DVec2::new(-b.x, a.x) * inverse);
    (is_regular && inverted.is_finite()).then_some(inverted)
}
