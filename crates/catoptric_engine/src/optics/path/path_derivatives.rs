//! Path Jacobians and path Hessians of specular paths, by the recursion of Chen and Arvo 2000 (Perturbation methods
//! for interactive specular reflections, section II), carried over to refraction and to paths that mix both.
//!
//! A path is ordered as in the paper, *from the scene point to the eye*: `p = x_0, x_1 .. x_N, q = x_(N+1)`. Everywhere
//! else in this crate bounces are counted from the eye, so `x_N` here is bounce 0 there. At each bounce, with unit
//! vectors `w` from `x_i` to its neighbours, the path is stationary (Fermat; the paper's equation 5 has both weights
//! 1):
//!
//! ```text
//! F = ( lambda grad g(x_i) - eta_(i-1) w_(i-1) - eta_(i+1) w_(i+1),  g(x_i) ) = 0
//! ```
//!
//! where `eta` is the index of refraction on the side of each neighbour. `x_i` is a function of `x_(i-1)`
//! alone, all later points following from it; `J_i` and `H_i` are that function's derivatives. They exist where no
//! focal point of the rays from the eye lies at `x_(i-1)`: there, and at the bounces between only there, the recursion
//! has no answer even if `dx_N / dp` exists. [`RayBundle`](super::bundle::RayBundle) derives the same numbers without
//! that limit, and for all points of a ray at once.

use super::bundle::Eye;
use super::specular_solver::MAX_BOUNCES;
use catoptric_core::surface::Taylor3;
use catoptric_core::surface::patch::tangent_frame;
use glam::{DMat2, DMat3, DVec2, DVec3};

/// A bounce as path derivatives need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathBounce {
    /// The bounce point `x_i`, world.
    pub position: DVec3,
    /// The surface's implicit function there; its scale does not matter.
    pub taylor: Taylor3,
    /// Index of refraction on the side of the neighbour towards the scene point, and towards the eye. Only their
    /// ratio matters: 1 and 1 for any reflection.
    pub weights: [f64; 2],
}

/// First and second derivatives of one point by another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointDerivatives {
    /// The Jacobian: column `k` is the change with the other point's component `k`.
    pub jacobian: DMat3,
    /// The Hessian (equation 3): a symmetric matrix for each component of this point.
    pub hessian: [DMat3; 3],
}

impl PointDerivatives {
    /// The derivatives of a point that stays where it is.
    pub const ZERO: Self = Self { jacobian: DMat3::ZERO, hessian: [DMat3::ZERO; 3] };

    /// The change with a step of the other point, to first order (equation 15) or to second (equation 16).
    #[inline]
    pub fn change(&self, step: DVec3, second_order: bool) -> DVec3 {
        let linear = self.jacobian * step;
        if second_order { linear + self.bilinear(step, step) * 0.5 } else { linear }
    }

    /// The Hessian along two directions: the vector `(a H^1 b, a H^2 b, a H^3 b)`.
    #[inline]
    pub fn bilinear(&self, a: DVec3, b: DVec3) -> DVec3 {
        let [x, y, z] = self.hessian.map(|matrix| a.dot(matrix * b));
        DVec3::new(x, y, z)
    }

    /// This function of a point that is itself a function (`inner`) of a third: the chain rule to second order.
    pub fn after(&self, inner: &Self) -> Self {
        let outer_second: [DVec3; 6] = std::array::from_fn(|k| {
            let (a, b) = SYMMETRIC_PAIRS[k];
            self.bilinear(inner.jacobian.col(a), inner.jacobian.col(b))
                + self.jacobian * DVec3::from(inner.hessian.map(|matrix| matrix.col(a)[b]))
        });
        Self { jacobian: self.jacobian * inner.jacobian, hessian: symmetric(&outer_second) }
    }

    fn is_finite(&self) -> bool {
        self.jacobian.is_finite() && self.hessian.iter().all(DMat3::is_finite)
    }
}

/// The derivatives of all bounces of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathDerivatives {
    /// `J_i` and `H_i` of bounce `x_i` by `x_(i-1)` at index `i - 1`: from the scene point on. Those beyond
    /// `bounce_count` are zero.
    pub bounces: [PointDerivatives; MAX_BOUNCES],
    /// The number of bounces of the path.
    pub bounce_count: usize,
    /// The path's distance from a caustic, 0 (on one) to 1: the smallest over the bounces of
    /// `|det| / (|M|^2 / 2)` of the constraint's 2x2 matrix in the tangent plane, `|M|` its Frobenius norm; for
    /// well-conditioned paths the relative error is about 1e-16 over it.
    pub conditioning: f64,
}

/// Matrices whose `conditioning` is not above this count as singular.
const SINGULAR: f64 = 1e-13;

/// Pairs of components of a symmetric 3x3 matrix, in the order of [`symmetric`].
const SYMMETRIC_PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// The three Hessians whose components for the six [`SYMMETRIC_PAIRS`] are given as vectors.
fn symmetric(pairs: &[DVec3; 6]) -> [DMat3; 3] {
    [0, 1, 2].map(|i: usize| {
        let [xx, xy, xz, yy, yz, zz] = pairs.map(|vector| vector[i]);
        DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
    })
}

impl PathDerivatives {
    /// The derivatives of the path from `point` over `bounces` (in the paper's order, from the point on) to the eye
    /// (`PathJacHess` in the paper). The path must satisfy the specular constraint and lie on the surfaces: the
    /// derivatives are as exact as that.
    ///
    /// None without bounces or with more than [`MAX_BOUNCES`], on a caustic, where neighbouring points coincide, or
    /// where anything is not finite.
    pub fn of_path(point: DVec3, bounces: &[PathBounce], eye: &Eye) -> Option<Self> {
        let bounce_count = bounces.len();
        if bounce_count == 0 || bounce_count > MAX_BOUNCES {
            return None;
        }
        let mut path = Self { bounces: [PointDerivatives::ZERO; MAX_BOUNCES], bounce_count, conditioning: 1.0 };
        // J_(N+1) = 0 and H_(N+1) = 0: the eye stays where it is.
        let mut next = PointDerivatives::ZERO;
        for i in (0..bounce_count).rev() {
            let bounce = &bounces[i];
            let previous = if i == 0 { point } else { bounces[i - 1].position };
            let towards_previous = UnitVector::between(bounce.position, previous)?;
            let towards_next = match (bounces.get(i + 1), *eye) {
                (Some(neighbour), _) => UnitVector::between(bounce.position, neighbour.position)?,
                (None, Eye::Point(q)) => UnitVector::between(bounce.position, q)?,
                (None, Eye::Direction(direction)) => UnitVector::at_infinity(-direction),
            };
            let segment = PathSegment::new(bounce, towards_previous, towards_next)?;
            let solver = segment.jacobian_solver(&next)?;
            let first = segment.first_order(&solver);
            next = segment.second_order(&solver, &first, &next);
            if !next.is_finite() {
                return None;
            }
            path.bounces[i] = next;
            path.conditioning = path.conditioning.min(solver.conditioning);
        }
        Some(path)
    }

    /// The derivatives by the scene point of the bounce nearest to the eye, `x_N`: where the point appears.
    pub fn total(&self) -> PointDerivatives {
        let mut bounces = self.bounces[..self.bounce_count].iter();
        let first = bounces.next().copied().unwrap_or(PointDerivatives::ZERO);
        bounces.fold(first, |inner, outer| outer.after(&inner))
    }

    /// The changes of all bounce points with a step of the scene point: equation 4, or its first-order part; from the
    /// scene point on. Those beyond the number of bounces are zero.
    pub fn perturbed(&self, step: DVec3, second_order: bool) -> [DVec3; MAX_BOUNCES] {
        let mut changes = [DVec3::ZERO; MAX_BOUNCES];
        let mut step = step;
        for (change, bounce) in changes.iter_mut().zip(&self.bounces[..self.bounce_count]) {
            step = bounce.change(step, second_order);
            *change = step;
        }
        changes
    }
}

/// A unit vector from one point to another, and how it turns.
#[derive(Clone, Copy)]
struct UnitVector {
    direction: DVec3,
    /// One over the distance; 0 for a point at infinity.
    inverse_distance: f64,
}

impl UnitVector {
    fn between(from: DVec3, to: DVec3) -> Option<Self> {
        let inverse_distance = (to - from).length_recip();
        let direction = (to - from) * inverse_distance;
        (inverse_distance.is_finite() && direction.is_finite()).then_some(Self { direction, inverse_distance })
    }

    fn at_infinity(direction: DVec3) -> Self {
        Self { direction, inverse_distance: 0.0 }
    }

    /// The vector's change with a relative step of its ends: the matrix `(I - w w^T) / r`.
    fn change(&self) -> DMat3 {
        let w = self.direction;
        (DMat3::IDENTITY - DMat3::from_cols(w * w.x, w * w.y, w * w.z)) * self.inverse_distance
    }

    /// The vector's second derivative along two relative steps of its ends.
    fn bend(&self, a: DVec3, b: DVec3) -> DVec3 {
        let w = self.direction;
        let (wa, wb) = (w.dot(a), w.dot(b));
        let sum = w * (a.dot(b) - 3.0 * wa * wb) + b * wa + a * wb;
        sum * -(self.inverse_distance * self.inverse_distance)
    }
}

/// A bounce between its neighbours, with `g` scaled to a gradient of unit length.
struct PathSegment {
    normal: DVec3,
    hessian: DMat3,
    third: Taylor3,
    inverse_gradient: f64,
    multiplier: f64,
    towards: [UnitVector; 2],
    weights: [f64; 2],
}

/// `Gamma` of equation 9 made ready to be inverted, by elimination in the surface's own frame: a column `(f, h)` is
/// solved by the step `n h` out of the surface, two unknowns in the tangent plane, and the multiplier last. That costs
/// a 2x2 inverse and loses nothing to the different units of the four rows.
struct GammaSolver {
    /// The upper left 3x3 block of `Gamma`.
    block: DMat3,
    normal: DVec3,
    tangents: [DVec3; 2],
    inverse: DMat2,
    conditioning: f64,
}

impl GammaSolver {
    fn new(block: DMat3, normal: DVec3) -> Option<Self> {
        let tangents = tangent_frame(normal);
        let [a, b] = tangents.map(|tangent| {
            let column = block * tangent;
            DVec2::new(tangents[0].dot(column), tangents[1].dot(column))
        });
        let matrix = DMat2::from_cols(a, b);
        let determinant = matrix.determinant();
        let norm2 = a.length_squared() + b.length_squared();
        let conditioning = 2.0 * determinant.abs() / norm2;
        if !(conditioning > SINGULAR && conditioning.is_finite()) {
            return None;
        }
        Some(Self { block, normal, tangents, inverse: matrix.inverse(), conditioning })
    }

    /// `Gamma^-1 (f, h)`: the change of `x_i` and of the multiplier.
    fn solve(&self, f: DVec3, h: f64) -> (DVec3, f64) {
        let out = self.normal * h;
        let rest = f - self.block * out;
        let u = self.inverse * DVec2::new(self.tangents[0].dot(rest), self.tangents[1].dot(rest));
        let step = out + self.tangents[0] * u.x + self.tangents[1] * u.y;
        (step, self.normal.dot(f - self.block * step))
    }
}

/// `D` of equation 9: the changes of `x_i` (that is `J_i`) and of the multiplier with `x_(i-1)`.
struct FirstOrder {
    jacobian: DMat3,
    multiplier_change: DVec3,
}

impl PathSegment {
    fn new(bounce: &PathBounce, towards_previous: UnitVector, towards_next: UnitVector) -> Option<Self> {
        let inverse_gradient = bounce.taylor.lower.gradient.length_recip();
        let normal = bounce.taylor.lower.normal()?;
        let [eta_previous, eta_next] = bounce.weights;
        // The paper divides by one non-zero component; the projection on the normal uses all three.
        let sum = towards_previous.direction * eta_previous + towards_next.direction * eta_next;
        Some(Self {
            normal,
            hessian: bounce.taylor.lower.hessian * inverse_gradient,
            third: bounce.taylor,
            inverse_gradient,
            multiplier: sum.dot(normal),
            towards: [towards_previous, towards_next],
            weights: bounce.weights,
        })
    }

    /// The upper three rows of `T_i` (towards the previous point) or of `B_i` (towards the next one), equation 8; the
    /// fourth row is zero.
    fn neighbour_change(&self, neighbour: usize) -> DMat3 {
        self.towards[neighbour].change() * -self.weights[neighbour]
    }

    /// `Gamma_i = A_i + aug(B_i J_(i+1))`, ready to be inverted (`SimpleJac` in the paper).
    fn jacobian_solver(&self, next: &PointDerivatives) -> Option<GammaSolver> {
        let (t, b) = (self.neighbour_change(0), self.neighbour_change(1));
        // Both unit vectors turn the other way when x_i itself moves.
        let a = self.hessian * self.multiplier - t - b;
        GammaSolver::new(a + b * next.jacobian, self.normal)
    }

    /// Equation 7.
    fn first_order(&self, solver: &GammaSolver) -> FirstOrder {
        let t = self.neighbour_change(0);
        let columns = [0, 1, 2].map(|k| solver.solve(-t.col(k), 0.0));
        let [x, y, z] = columns.map(|(step, _)| step);
        let multiplier_change = DVec3::from(columns.map(|(_, change)| change));
        FirstOrder { jacobian: DMat3::from_cols(x, y, z), multiplier_change }
    }

    /// Equations 10 to 14, contracted (`SimpleHess` in the paper): the terms of equations 11 to 13 with both their
    /// free directions filled in are the second derivative of `F` along the changes of all its arguments, plus
    /// `B_i H_(i+1)` along the change of `x_i`; so `Gamma` is inverted for six columns instead of multiplying tensors.
    fn second_order(&self, solver: &GammaSolver, first: &FirstOrder, next: &PointDerivatives) -> PointDerivatives {
        let b_matrix = self.neighbour_change(1);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let pairs: [DVec3; 6] = std::array::from_fn(|index| {
            let (j, k) = SYMMETRIC_PAIRS[index];
            let (xj, xk) = (first.jacobian.col(j), first.jacobian.col(k));
            let (lj, lk) = (first.multiplier_change[j], first.multiplier_change[k]);
            let [before, after] = &self.towards;
            let turned_before = before.bend(axes[j] - xj, axes[k] - xk) * self.weights[0];
            let turned_after = after.bend(next.jacobian * xj - xj, next.jacobian * xk - xk) * self.weights[1];
            let third = DVec3::from(self.third.third.map(|matrix| xj.dot(matrix * xk))) * self.inverse_gradient;
            let f = self.hessian * (xk * lj + xj * lk) + third * self.multiplier - turned_before - turned_after
                + b_matrix * next.bilinear(xj, xk);
            let h = xj.dot(self.hessian * xk);
            solver.solve(-f, -h).0
        });
        PointDerivatives { jacobian: first.jacobian, hessian: symmetric(&pairs) }
    }
}
