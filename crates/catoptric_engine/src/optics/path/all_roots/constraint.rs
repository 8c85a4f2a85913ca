//! The specular constraint at points of a surface: its residual, its Jacobian, and bounds of it over a piece.

use super::cover::{BoundingCone, SurfaceCell, angle_between, onto_surface};
use crate::optics::path::bundle::Eye;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::surface::patch::{SurfacePatch, tangent_frame};
use catoptric_core::surface::{PlacedSurface, Taylor2};
use glam::{DMat2, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// The sides of the surface on which a path's ends lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    /// Both on the same side.
    Same,
    /// The eye on the outer side, the point on the inner one.
    EyeOutside,
    /// The eye on the inner side, the point on the outer one.
    EyeInside,
}

/// The ends of a path of one bounce: `sum_k eta_k w_k` must be normal to the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpecularConstraint {
    pub(super) eye: Eye,
    pub(super) point: DVec3,
    /// Indices of refraction on the side of the eye, and of the point.
    pub(super) weights: [f64; 2],
    pub(super) sides: Sides,
}

/// The constraint at a point of the surface.
struct Local {
    tangents: [DVec3; 2],
    residual: DVec2,
    /// The residual's change with a step in the tangents.
    matrix: DMat2,
}

/// A unit vector to one of a path's ends.
#[derive(Clone, Copy)]
struct Towards {
    direction: DVec3,
    distance: f64,
}

/// The verdict on a piece of surface; the first two are certain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The piece holds no root.
    Empty,
    /// The piece holds one root at most, and that one is here: a root, but possibly a little outside the piece.
    One(DVec3),
    /// The piece must be split.
    Open,
}

/// Residuals up to this count as 0: some hundred times the rounding of a sum of unit vectors.
const RESIDUAL: f64 = 1e-13;

impl SpecularConstraint {
    fn towards(&self, at: DVec3) -> [Towards; 2] {
        let finite = |end: DVec3| {
            let distance = end.distance(at);
            Towards { direction: (end - at) / distance, distance }
        };
        let eye = match self.eye {
            Eye::Point(eye) => finite(eye),
            Eye::Direction(direction) => Towards { direction: -direction, distance: f64::INFINITY },
        };
        [eye, finite(self.point)]
    }

    /// Returns true if the ends lie on the required sides; an end in the tangent plane is on neither.
    fn sided(&self, at: DVec3, normal: DVec3) -> bool {
        let [eye, point] = self.towards(at).map(|end| end.direction.dot(normal));
        match self.sides {
            Sides::Same => eye * point > 0.0,
            Sides::EyeOutside => eye > 0.0 && point < 0.0,
            Sides::EyeInside => eye < 0.0 && point > 0.0,
        }
    }

    /// Returns true if a piece can hold a root as far as ball and cone decide. The half vector's change within the ball
    /// is bounded by the ball's apparent size from both ends; a root needs it within the cone (or the opposite one).
    pub(super) fn possible(&self, bounds: &BoundingCone) -> bool {
        let ends = self.towards(bounds.center);
        let mut half = DVec3::ZERO;
        let mut change = 0.0;
        let mut positive = [false; 2];
        let mut negative = [false; 2];
        for (k, end) in ends.iter().enumerate() {
            if end.distance <= bounds.radius {
                return true;
            }
            let apparent = (bounds.radius / end.distance).arc_sine();
            let tilt = angle_between(end.direction, bounds.axis);
            positive[k] = tilt - bounds.angle - apparent < FRAC_PI_2;
            negative[k] = tilt + bounds.angle + apparent > FRAC_PI_2;
            half += end.direction * self.weights[k];
            change += self.weights[k] * 2.0 * (0.5 * apparent).sine();
        }
        let sided = match self.sides {
            Sides::Same => positive[0] && positive[1] || negative[0] && negative[1],
            Sides::EyeOutside => positive[0] && negative[1],
            Sides::EyeInside => negative[0] && positive[1],
        };
        let tilt = angle_between(half, bounds.axis);
        let beside = (tilt.min(PI - tilt) - bounds.angle).max(0.0);
        sided && half.length() * beside.sine() <= change
    }

    fn local(&self, at: DVec3, taylor: &Taylor2) -> Option<Local> {
        let normal = taylor.normal()?;
        let tangents = tangent_frame(normal);
        let flat = |v: DVec3| DVec2::new(tangents[0].dot(v), tangents[1].dot(v));
        let shape = taylor.hessian * taylor.gradient.length_recip();
        let mut half = DVec3::ZERO;
        let mut columns = [DVec2::ZERO; 2];
        for (end, weight) in self.towards(at).iter().zip(self.weights) {
            half += end.direction * weight;
            let direction = flat(end.direction);
            for (a, column) in columns.iter_mut().enumerate() {
                *column -= (DVec2::AXES[a] - direction * direction[a]) * (weight / end.distance);
            }
        }
        // The residual is h - (h.n) n in the tangent plane; h.n changes nothing there, n does.
        let along = half.dot(normal);
        let matrix = [0, 1].map(|a: usize| columns[a] - flat(shape * tangents[a]) * along);
        let local = Local { tangents, residual: flat(half), matrix: DMat2::from_cols(matrix[0], matrix[1]) };
        (local.residual.is_finite() && local.matrix.is_finite()).then_some(local)
    }

    /// The root that Newton's method (with the pseudo-inverse, so that it works on curves of roots too) finds from a
    /// point on the surface in steps no longer than `reach` each, and whether the ends are on the right sides there.
    pub(super) fn newton(&self, surface: &PlacedSurface, start: DVec3, reach: f64) -> Option<(DVec3, bool)> {
        let (mut at, mut taylor) = (start, surface.taylor2(start));
        let mut best = (f64::INFINITY, at, taylor);
        let mut stalled = 0;
        for _ in 0..100 {
            let local = self.local(at, &taylor)?;
            let residual = local.residual.length();
            if residual < 0.9 * best.0 {
                stalled = 0;
            } else {
                stalled += 1;
            }
            if residual < best.0 {
                best = (residual, at, taylor);
            }
            if residual == 0.0 || stalled > 4 {
                break;
            }
            let u = pseudo_solve(&local.matrix, -local.residual).clamp_length_max(reach);
            let step = local.tangents[0] * u.x + local.tangents[1] * u.y;
            (at, taylor) = onto_surface(surface, at + step)?;
        }
        let (residual, at, taylor) = best;
        let scale = self.weights[0].max(self.weights[1]);
        let normal = taylor.normal()?;
        (residual <= RESIDUAL * scale).then(|| (at, self.sided(at, normal)))
    }

    /// The direction along the surface in which the constraint does not change to first order; returns `None` if it
    /// changes in all directions.
    pub(super) fn unchanging_direction(&self, surface: &PlacedSurface, at: DVec3) -> Option<DVec3> {
        let local = self.local(at, &surface.taylor2(at))?;
        let (largest, direction) = largest_singular(&local.matrix);
        // Roots are exact enough for this where they form curves: the residual is linear across them.
        let scale = self.towards(at).iter().zip(self.weights).map(|(end, weight)| weight / end.distance).sum::<f64>();
        if local.matrix.determinant().abs() > SINGULAR * largest * largest && largest > SINGULAR * scale {
            return None;
        }
        let along = direction.perp();
        Some(local.tangents[0] * along.x + local.tangents[1] * along.y)
    }

    /// The certain verdict on a cell whose ball and cone leave it open.
    ///
    /// With `r` the residual in tangent coordinates `u` about the centre, `J` its Jacobian there, and `L` a bound of
    /// its second derivative: `|J^-1 r(u)| >= |J^-1 r(0)| - |u| - 1/2 |J^-1| L |u|^2`, so there is no root where the
    /// right side is positive all over the ball; and where `|J^-1| L |u| < 1`, `r` is one to one. `L` follows from
    /// distances, curvature and its change at the centre, with the change doubled as a margin, and is used only if
    /// the normals at the corners keep to it.
    pub(super) fn verdict(&self, surface: &PlacedSurface, cell: &SurfaceCell) -> Verdict {
        let BoundingCone { center, radius, angle, .. } = cell.bounds;
        if angle >= 0.5 {
            return Verdict::Open;
        }
        let taylor = surface.taylor3(center);
        let (Some(patch), Some(local)) =
            (SurfacePatch::of_implicit(center, &taylor), self.local(center, &taylor.lower))
        else {
            return Verdict::Open;
        };
        let Some(bound) = self.second_derivative(&patch, cell) else { return Verdict::Open };
        let inverse = local.matrix.inverse();
        if !inverse.is_finite() {
            return Verdict::Open;
        }
        let [a, b] = [inverse.x_axis, inverse.y_axis];
        let nonlinear = (a.length_squared() + b.length_squared()).sqrt() * bound;
        let away = (inverse * local.residual).length();
        if away > radius + 0.5 * nonlinear * radius * radius {
            return Verdict::Empty;
        }
        // `bound` holds as far as twice the radius.
        let unique_within = (0.9 / nonlinear).min(2.0 * radius);
        if unique_within >= radius
            && let Some((root, sided)) = self.newton(surface, center, radius)
            && root.distance(center) <= unique_within
        {
            return if sided { Verdict::One(root) } else { Verdict::Empty };
        }
        Verdict::Open
    }

    /// A bound of the residual's second derivative within twice a cell's radius; returns `None` if it cannot be given.
    fn second_derivative(&self, patch: &SurfacePatch, cell: &SurfaceCell) -> Option<f64> {
        let reach = 2.0 * cell.bounds.radius;
        let sum = |vectors: &[DVec3]| vectors.iter().map(|vector| vector.length_squared()).sum::<f64>().sqrt();
        let [uu, uv, vv] = patch.normal_bend;
        let normal_bend = 2.0 * sum(&[uu, uv, uv, vv]);
        let curvature = sum(&patch.normal_change) + reach * normal_bend;
        for (corner, normal) in cell.corners().iter().zip(&cell.normals) {
            let step = *corner - patch.position;
            let turned = patch.normal_change[0] * patch.tangents[0].dot(step)
                + patch.normal_change[1] * patch.tangents[1].dot(step);
            let off = (*normal - patch.normal - turned).length();
            // The rounding of unit vectors, and of corners that lie on the surface to rounding alone.
            let rounding = 1e-14 * (1.0 + curvature * patch.position.length());
            if off > 0.5 * normal_bend * step.length_squared() + rounding {
                return None;
            }
        }
        let (mut half, mut first, mut second) = (0.0, 0.0, 0.0);
        for (end, weight) in self.towards(patch.position).iter().zip(self.weights) {
            let least = end.distance - reach;
            if least <= 0.0 {
                return None;
            }
            half += weight;
            first += weight / least;
            // The second derivative of a unit vector is 2/sqrt(3) over the distance squared at most.
            second += weight * (1.155 / least + curvature) / least;
        }
        Some(2.0 * second + 4.0 * first * curvature + half * (2.0 * normal_bend + 2.0 * curvature * curvature))
    }
}

/// Ratio of the two singular values of a matrix below which the smaller one counts as 0.
const SINGULAR: f64 = 1e-10;

/// The shortest least-squares solution of `m u = right`.
fn pseudo_solve(m: &DMat2, right: DVec2) -> DVec2 {
    let (largest, direction) = largest_singular(m);
    if largest <= 0.0 || largest.is_nan() {
        return DVec2::ZERO;
    }
    if m.determinant().abs() > SINGULAR * largest * largest {
        return m.inverse() * right;
    }
    direction * ((*m * direction).dot(right) / (largest * largest))
}

/// A matrix's largest singular value and the unit vector that it stretches by it.
fn largest_singular(m: &DMat2) -> (f64, DVec2) {
    let normal = m.transpose() * *m;
    let (trace, gap) = (normal.x_axis.x + normal.y_axis.y, normal.x_axis.x - normal.y_axis.y);
    let spread = (gap * gap + 4.0 * normal.y_axis.x * normal.y_axis.x).sqrt();
    // The columns of normal - smallest * I are along the vector.
    let smallest = 0.5 * (trace - spread);
    let columns = [normal.x_axis - DVec2::X * smallest, normal.y_axis - DVec2::Y * smallest];
    let longer = if columns[0].length_squared() >= columns[1].length_squared() { columns[0] } else { columns[1] };
    ((0.5 * (trace + spread)).sqrt(), longer.try_normalize().unwrap_or(DVec2::X))
}
