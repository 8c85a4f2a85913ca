//! A specular path together with all paths near it: a two-parameter family of rays, to second order.
//!
//! The parameters are the tangent coordinates `z` of the first reflection point (counted from the eye). After any
//! number of reflections and refractions the family of outgoing rays is `o(z) + s d(z)`, and a scene point near the
//! central ray lies on the ray whose `z` solves `o(z) + s d(z) = p`: two by two equations whose matrix is linear in
//! the distance along the ray. So one expansion a sample ray gives the path Jacobian and the path Hessian at every
//! distance (what Chen and Arvo 2000, section V, leave open), its determinant gives the focal points, and the number
//! of bounces costs nothing any more.

use catoptric_core::math::jet::{PAIRS, ScalarJet, VectorJet};
use catoptric_core::surface::patch::{SurfacePatch, tangent_frame};
use glam::{DMat2, DMat3, DVec2, DVec3};

/// The light's interaction at a bounce.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BounceKind {
    /// The ray is reflected.
    Reflect,
    /// The ray passes into or out of a lens object.
    Transmit,
}

impl BounceKind {
    /// Both kinds.
    pub const BOTH: [Self; 2] = [Self::Reflect, Self::Transmit];

    /// The event at a bounce of a path that takes second branches at the bounces of these bits.
    #[inline(always)] // for the instructions of its callers
    pub fn at(bounce: usize, second_branches: u64) -> Self {
        if second_branches >> bounce & 1 != 0 { Self::Transmit } else { Self::Reflect }
    }

    /// The letter of the kind in tables: `R` or `T`.
    pub fn letter(self) -> char {
        match self {
            Self::Reflect => 'R',
            Self::Transmit => 'T',
        }
    }
}

/// One bounce of a specular path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Bounce {
    /// The object that reflects or refracts.
    pub object: u32,
    /// The interaction there.
    pub kind: BounceKind,
}

/// The origin of a view's rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// All pass through a point.
    Point(DVec3),
    /// All have one (unit) direction.
    Direction(DVec3),
}

impl Eye {
    /// The unit direction of the view ray to a point; returns `None` at the eye itself.
    pub fn direction_to(&self, point: DVec3) -> Option<DVec3> {
        match *self {
            Self::Point(eye) => (point - eye).try_normalize(),
            Self::Direction(direction) => Some(direction),
        }
    }
}

/// A ray and all its neighbours in a two-parameter family, to second order in the family's parameters `z`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayBundle {
    /// The first reflection point.
    pub first: VectorJet,
    /// The rays' origins: the last reflection point.
    pub origin: VectorJet,
    /// Their unit directions.
    pub direction: VectorJet,
    /// Focal points that the central ray has passed before its origin.
    pub focal_points_passed: u32,
}

impl RayBundle {
    /// View rays as they arrive at their first reflection points, before the first interaction.
    ///
    /// Returns `None` if the eye lies on the surface or in its tangent plane.
    pub fn arriving(eye: &Eye, patch: &SurfacePatch) -> Option<Self> {
        let at = VectorJet { value: patch.position, first: patch.tangents, second: patch.bend };
        let direction = match *eye {
            Eye::Point(eye) => {
                let mut from_eye = at;
                from_eye.value -= eye;
                if from_eye.value.length_squared() < f64::MIN_POSITIVE {
                    return None;
                }
                from_eye.normalized()
            }
            Eye::Direction(direction) => VectorJet::constant(direction),
        };
        let bundle = Self { first: at, origin: at, direction, focal_points_passed: 0 };
        bundle.is_finite().then_some(bundle)
    }

    /// The rays where they arrive at the next surface, given by its patch about the point where the central ray meets
    /// it, and the patch's parameters there as functions of `z`.
    ///
    /// Returns `None` if the central ray grazes the surface.
    pub fn advanced(&self, patch: &SurfacePatch) -> Option<(Self, [ScalarJet; 2])> {
        // o(z) + s(z) d(z) = x(u(z)): linear in (s, u) to each order, always with the same matrix.
        let matrix = DMat3::from_cols(self.direction.value, -patch.tangents[0], -patch.tangents[1]);
        let determinant = matrix.determinant();
        if determinant.is_nan() || determinant.abs() <= 1e-12 {
            return None;
        }
        let inverse = matrix.inverse();
        let length = (patch.position - self.origin.value).dot(self.direction.value);
        let mut s = ScalarJet::constant(length);
        let mut u = [ScalarJet::default(); 2];
        let solve = |right: DVec3| (inverse * right).to_array();
        for a in 0..2 {
            let [ds, du, dv] = solve(-(self.origin.first[a] + self.direction.first[a] * length));
            (s.first[a], u[0].first[a], u[1].first[a]) = (ds, du, dv);
        }
        for (k, (a, b)) in PAIRS.into_iter().enumerate() {
            let surface = patch.bend[0] * (u[0].first[a] * u[0].first[b])
                + patch.bend[1] * (u[0].first[a] * u[1].first[b] + u[1].first[a] * u[0].first[b])
                + patch.bend[2] * (u[1].first[a] * u[1].first[b]);
            let ray = self.origin.second[k]
                + self.direction.second[k] * length
                + self.direction.first[a] * s.first[b]
                + self.direction.first[b] * s.first[a];
            let [ds, du, dv] = solve(surface - ray);
            (s.second[k], u[0].second[k], u[1].second[k]) = (ds, du, dv);
        }
        let at = VectorJet { value: patch.position, first: patch.tangents, second: patch.bend };
        let passed = OutgoingRays::new(self).map_or(0, |rays| rays.focal_points_before(length));
        let origin = at.composed(&u);
        let bundle = Self { origin, focal_points_passed: self.focal_points_passed + passed, ..*self };
        bundle.is_finite().then_some((bundle, u))
    }

    /// The rays after a reflection or refraction at the surface that they have arrived at.
    ///
    /// `u` are the patch's parameters as functions of `z` (see [`Self::advanced`]; the identity at the first bounce),
    /// `index` is the lens's index of refraction over that of its surroundings. None on total internal reflection.
    pub fn scattered(&self, patch: &SurfacePatch, u: &[ScalarJet; 2], kind: BounceKind, index: f64) -> Option<Self> {
        let outer = VectorJet { value: patch.normal, first: patch.normal_change, second: patch.normal_bend };
        let outer = outer.composed(u);
        let from_outside = self.direction.value.dot(patch.normal) <= 0.0;
        let normal = if from_outside { outer } else { outer * -1.0 };
        let cosine = -self.direction.dot(&normal);
        let direction = match kind {
            BounceKind::Reflect => self.direction + normal.scaled(&(cosine * 2.0)),
            BounceKind::Transmit => {
                let eta = if from_outside { 1.0 / index } else { index };
                let one = ScalarJet::constant(1.0);
                let cos2_out = one - (one - cosine * cosine) * (eta * eta);
                if cos2_out.value.is_nan() || cos2_out.value <= 0.0 {
                    return None;
                }
                self.direction * eta + normal.scaled(&(cosine * eta - cos2_out.sqrt()))
            }
        };
        let bundle = Self { direction, ..*self };
        bundle.is_finite().then_some(bundle)
    }

    /// The identity: the first patch's parameters as functions of `z`.
    pub fn own_parameters() -> [ScalarJet; 2] {
        let unit = |a: usize| {
            let mut jet = ScalarJet::default();
            jet.first[a] = 1.0;
            jet
        };
        [unit(0), unit(1)]
    }

    fn is_finite(&self) -> bool {
        self.first.is_finite() && self.origin.is_finite() && self.direction.is_finite()
    }
}

/// A bundle's outgoing rays, made ready for the question on which of them a scene point lies.
///
/// Lateral positions are measured in the frame `across`, perpendicular to the central ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutgoingRays {
    /// The origin of the central ray.
    pub origin: DVec3,
    /// The unit direction of the central ray.
    pub direction: DVec3,
    /// Two unit vectors perpendicular to it and to each other.
    pub across: [DVec3; 2],
    /// Lateral change of the origins with `z`: `origin_change[i][a]`.
    origin_change: [[f64; 2]; 2],
    /// Lateral change of the directions with `z`.
    direction_change: [[f64; 2]; 2],
    /// Change of the origins along the central ray.
    origin_along: [f64; 2],
    /// Lateral second derivatives of the origins.
    origin_bend: [[f64; 3]; 2],
    /// Lateral second derivatives of the directions.
    direction_bend: [[f64; 3]; 2],
}

/// The change of the parameters of the ray through a point as the point moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Perturbation {
    /// The parameters of the ray through the moved point, to first order.
    pub linear: DVec2,
    /// The second-order term.
    pub quadratic: DVec2,
    /// Distance of the moved point along the central ray.
    pub distance: f64,
}

/// The first-order part of a [`Perturbation`].
#[derive(Clone, Copy, Debug)]
pub struct FirstOrder {
    /// The parameters of the ray through the moved point.
    pub linear: DVec2,
    /// Distance of the moved point along the central ray.
    pub distance: f64,
    /// The change of the parameters with a lateral step, `[a][i]`.
    focus: [[f64; 2]; 2],
}

impl FirstOrder {
    /// The change of the parameters with a lateral step.
    #[inline]
    pub fn lateral_change(&self) -> DMat2 {
        let [[a, b], [c, d]] = self.focus;
        DMat2::from_cols_array(&[a, c, b, d])
    }
}

impl OutgoingRays {
    /// Lateral change of the directions with `z`: radians a unit of the parameters, a column a parameter.
    #[inline]
    pub fn direction_change(&self) -> DMat2 {
        let [[a, b], [c, d]] = self.direction_change;
        DMat2::from_cols_array(&[a, c, b, d])
    }

    /// The rays that leave a bundle; returns `None` if the direction is not finite.
    pub fn new(bundle: &RayBundle) -> Option<Self> {
        let direction = bundle.direction.value.try_normalize()?;
        let across = tangent_frame(direction);
        let lateral = |vectors: &[DVec3; 2]| [0, 1].map(|i: usize| vectors.map(|vector| across[i].dot(vector)));
        let bends = |vectors: &[DVec3; 3]| [0, 1].map(|i: usize| vectors.map(|vector| across[i].dot(vector)));
        Some(Self {
            origin: bundle.origin.value,
            direction,
            across,
            origin_change: lateral(&bundle.origin.first),
            direction_change: lateral(&bundle.direction.first),
            origin_along: bundle.origin.first.map(|change| change.dot(direction)),
            origin_bend: bends(&bundle.origin.second),
            direction_bend: bends(&bundle.direction.second),
        })
    }

    /// The change of a point at `distance` along the ray with `z`, in the lateral frame: `[i][a]`.
    #[inline]
    pub fn spread(&self, distance: f64) -> [[f64; 2]; 2] {
        let (o, d) = (&self.origin_change, &self.direction_change);
        [0, 1].map(|i: usize| [0, 1].map(|a: usize| o[i][a] + distance * d[i][a]))
    }

    /// The origin of the ray with parameters `z`: to second order across the central ray, to first order along it.
    #[inline]
    pub fn origin_near(&self, z: DVec2) -> DVec3 {
        let squares = [0.5 * z.x * z.x, z.x * z.y, 0.5 * z.y * z.y];
        let along = self.origin_along[0] * z.x + self.origin_along[1] * z.y;
        let lateral = [0, 1].map(|i: usize| {
            let bend: f64 = self.origin_bend[i].iter().zip(squares).map(|(bend, square)| bend * square).sum();
            self.origin_change[i][0] * z.x + self.origin_change[i][1] * z.y + bend
        });
        self.origin + self.direction * along + self.across[0] * lateral[0] + self.across[1] * lateral[1]
    }

    /// The change by the wavefront through the central ray at `distance` of the length of the way to a point beside it:
    /// half the second derivative along the lateral part of `relative` (from the rays' origin).
    #[inline]
    pub fn wavefront_bend(&self, distance: f64, relative: DVec3) -> f64 {
        let Some(focus) = self.focus(distance) else { return 0.0 };
        let lateral = self.across.map(|axis| axis.dot(relative));
        let z = focus.map(|row| row[0] * lateral[0] + row[1] * lateral[1]);
        // The direction's change with the step, along the step.
        let turn = self.direction_change.map(|row| row[0] * z[0] + row[1] * z[1]);
        0.5 * (turn[0] * lateral[0] + turn[1] * lateral[1])
    }

    /// [`Self::spread`] on the ray with parameters `z` beside the central one, to first order in `z`.
    #[inline]
    pub fn spread_near(&self, distance: f64, z: DVec2) -> [[f64; 2]; 2] {
        let mut spread = self.spread(distance);
        let forward = -(self.origin_along[0] * z.x + self.origin_along[1] * z.y);
        for (i, row) in spread.iter_mut().enumerate() {
            let bend = |k: usize| self.origin_bend[i][k] + distance * self.direction_bend[i][k];
            let slope = self.direction_change[i];
            row[0] += bend(0) * z.x + bend(1) * z.y + forward * slope[0] + lift(&slope, z) * self.origin_along[0];
            row[1] += bend(1) * z.x + bend(2) * z.y + forward * slope[1] + lift(&slope, z) * self.origin_along[1];
        }
        spread
    }

    /// The axes that a scene point's steps are measured along on the ray with parameters `z`, perpendicular to it to
    /// first order in `z`: a step changes the parameters by the inverse of [`Self::spread_near`] times these products.
    #[inline]
    pub fn across_near(&self, z: DVec2) -> [DVec3; 2] {
        [0, 1].map(|i: usize| self.across[i] + self.direction * lift(&self.direction_change[i], z))
    }

    /// The number of focal points that a ray near the central one has passed at `distance`, from the determinant of
    /// [`Self::spread_near`] there.
    ///
    /// The determinant's sign separates one from zero and two; the central ray's focal distances separate zero from
    /// two.
    #[inline]
    pub fn focal_points_near(&self, distance: f64, z: DVec2, determinant: f64) -> u32 {
        let [[a, b], [c, d]] = self.spread_near(0.0, z);
        if (a * d - b * c) * determinant < 0.0 {
            return 1;
        }
        match self.focal_distances() {
            [Some(first), Some(second)] if distance > 0.5 * (first + second) => 2,
            _ => 0,
        }
    }

    /// The inverse of [`Self::spread`]: change of `z` with a lateral step, `[a][i]`; returns `None` at a focal point.
    #[inline]
    pub fn focus(&self, distance: f64) -> Option<[[f64; 2]; 2]> {
        let [[a, b], [c, d]] = self.spread(distance);
        let determinant = a * d - b * c;
        let inverse = 1.0 / determinant;
        inverse.is_finite().then_some([[d * inverse, -b * inverse], [-c * inverse, a * inverse]])
    }

    /// The parameters of the ray through a point near the central ray, to second order; returns `None` at a focal
    /// point.
    #[inline]
    pub fn perturbed(&self, point: DVec3) -> Option<Perturbation> {
        let first = self.first_order(point)?;
        Some(Perturbation { linear: first.linear, quadratic: self.second_order(&first), distance: first.distance })
    }

    /// The first-order part of [`Self::perturbed`].
    #[inline]
    pub fn first_order(&self, point: DVec3) -> Option<FirstOrder> {
        let relative = point - self.origin;
        let distance = relative.dot(self.direction);
        let focus = self.focus(distance)?;
        let lateral = self.across.map(|axis| axis.dot(relative));
        let linear = DVec2::from(focus.map(|row| row[0] * lateral[0] + row[1] * lateral[1]));
        Some(FirstOrder { linear, distance, focus })
    }

    /// The second-order part of [`Self::perturbed`].
    #[inline]
    pub fn second_order(&self, first: &FirstOrder) -> DVec2 {
        let FirstOrder { linear, distance, focus } = *first;
        let along = |row: &[f64; 2], right: &[f64; 2]| row[0] * right[0] + row[1] * right[1];
        let z = linear.to_array();
        let forward = -along(&self.origin_along, &z);
        let squares = [0.5 * z[0] * z[0], z[0] * z[1], 0.5 * z[1] * z[1]];
        let bend = [0, 1].map(|i: usize| {
            let coefficient = |k: usize| self.origin_bend[i][k] + distance * self.direction_bend[i][k];
            coefficient(0) * squares[0]
                + coefficient(1) * squares[1]
                + coefficient(2) * squares[2]
                + forward * along(&self.direction_change[i], &z)
        });
        DVec2::from(focus.map(|row| -along(&row, &bend)))
    }

    /// The lateral second-order terms of [`Self::second_order`] as quadratic forms of the parameters (`xx / 2`, `xy`,
    /// `yy / 2`), for both axes: those that do not depend on the distance along the ray, and those for a distance of 1.
    pub fn bend_forms(&self) -> [[[f64; 3]; 2]; 2] {
        let [along_x, along_y] = self.origin_along;
        let origin = [0, 1].map(|i: usize| {
            let ([xx, xy, yy], [x, y]) = (self.origin_bend[i], self.direction_change[i]);
            [xx - 2.0 * along_x * x, xy - along_x * y - along_y * x, yy - 2.0 * along_y * y]
        });
        [origin, self.direction_bend]
    }

    /// The distances along the central ray at which neighbouring rays meet it, ascending; at most two, and only
    /// those in front of the origin.
    ///
    /// They are where `det(A + t B) = 0`: the roots of a quadratic.
    pub fn focal_distances(&self) -> [Option<f64>; 2] {
        let ([[a, b], [c, d]], [[e, f], [g, h]]) = (self.origin_change, self.direction_change);
        let constant = a * d - b * c;
        let linear = a * h + e * d - b * g - f * c;
        let square = e * h - f * g;
        let mut found = [None; 2];
        let mut count = 0;
        let discriminant = linear * linear - 4.0 * square * constant;
        if discriminant.is_nan() || discriminant < 0.0 {
            return found;
        }
        // The stable form: no difference of nearly equal numbers.
        let sum = -0.5 * (linear + discriminant.sqrt().copysign(linear));
        for root in [sum / square, constant / sum] {
            if root > 0.0 && root.is_finite() {
                found[count] = Some(root);
                count += 1;
            }
        }
        if let [Some(first), Some(second)] = found
            && first > second
        {
            found.swap(0, 1);
        }
        found
    }

    /// The number of focal points before a distance.
    pub fn focal_points_before(&self, distance: f64) -> u32 {
        self.focal_distances().iter().flatten().filter(|focal| **focal < distance).count() as u32
    }
}

/// The effect of a step along the central ray across the ray with parameters `z`, measured on an axis along which
/// directions change by `slope`.
#[inline]
fn lift(slope: &[f64; 2], z: DVec2) -> f64 {
    -(slope[0] * z.x + slope[1] * z.y)
}
