//! A smooth surface near one of its points, to second order: all that optics needs of it.

use super::taylor::Taylor3;
use glam::DVec3;

/// A surface near a point: position and unit normal as polynomials of second degree in two parameters `u`, `v`.
///
/// `position(u, v) = position + sum_a tangents[a] u_a + 1/2 sum_ab bend[ab] u_a u_b`, and the same for the normal;
/// the second derivatives are stored as uu, uv, vv. The tangents are an orthonormal frame of the surface (on meshes of
/// the smooth surface that they stand for: perpendicular to the interpolated normal).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfacePatch {
    /// The point, world.
    pub position: DVec3,
    /// The unit (shading) normal on the outer side.
    pub normal: DVec3,
    /// First derivatives of the position.
    pub tangents: [DVec3; 2],
    /// Second derivatives of the position.
    pub bend: [DVec3; 3],
    /// First derivatives of the unit normal.
    pub normal_change: [DVec3; 2],
    /// Second derivatives of the unit normal.
    pub normal_bend: [DVec3; 3],
}

/// Two unit vectors that form a right-handed frame with a unit vector (Duff and others 2017, Building an orthonormal
/// basis, revisited).
#[inline]
pub fn tangent_frame(normal: DVec3) -> [DVec3; 2] {
    let sign = 1f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

impl SurfacePatch {
    /// The patch of an implicit surface at a point on it, from its Taylor coefficients there: a Monge patch
    /// `x0 + E u + n h(u)` whose height `h` follows from `g = 0`.
    ///
    /// Returns `None` if the gradient vanishes or anything is not finite.
    #[inline]
    pub fn of_implicit(position: DVec3, taylor: &Taylor3) -> Option<Self> {
        let length = taylor.lower.gradient.length();
        let normal = taylor.lower.normal()?;
        let tangents = tangent_frame(normal);
        let hessian = taylor.lower.hessian * (1.0 / length);
        let pairs = [(0, 0), (0, 1), (1, 1)];
        // g = 0 along the patch, to second order: h_ab = -(t_a H t_b) / |grad|.
        let height = pairs.map(|(a, b)| -tangents[a].dot(hessian * tangents[b]));
        let bend = height.map(|h| normal * h);
        // The gradient G over its length at the centre, along the patch:
        // G(u) = n + H x_a u_a + 1/2 (T x_a x_b + H x_ab) u_a u_b, with unit length at the centre.
        let first = [0, 1].map(|a| hessian * tangents[a]);
        let third = |a: usize, b: usize| {
            let (ta, tb) = (tangents[a], tangents[b]);
            DVec3::new(ta.dot(taylor.third[0] * tb), ta.dot(taylor.third[1] * tb), ta.dot(taylor.third[2] * tb))
                / length
        };
        let second: [DVec3; 3] = std::array::from_fn(|k| third(pairs[k].0, pairs[k].1) + hessian * bend[k]);
        let (normal_change, normal_bend) = unit_derivatives(normal, first, second);
        let patch = Self { position, normal, tangents, bend, normal_change, normal_bend };
        patch.is_finite().then_some(patch)
    }

    /// Returns true if every number is finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        let finite = |vectors: &[DVec3]| vectors.iter().all(|vector| vector.is_finite());
        self.position.is_finite()
            && self.normal.is_finite()
            && finite(&self.tangents)
            && finite(&self.bend)
            && finite(&self.normal_change)
            && finite(&self.normal_bend)
    }

    /// The position at parameters `u`, to second order.
    #[inline]
    pub fn position_at(&self, u: [f64; 2]) -> DVec3 {
        self.position
            + self.tangents[0] * u[0]
            + self.tangents[1] * u[1]
            + (self.bend[0] * (u[0] * u[0]) + self.bend[1] * (2.0 * u[0] * u[1]) + self.bend[2] * (u[1] * u[1])) * 0.5
    }
}

/// First and second derivatives of `g / |g|` where `g` has unit length: from those of `g` (second ones as uu, uv, vv).
#[inline]
pub fn unit_derivatives(unit: DVec3, first: [DVec3; 2], second: [DVec3; 3]) -> ([DVec3; 2], [DVec3; 3]) {
    // With r = 1/|g|: r_a = -(g.g_a), r_ab = -(g_a.g_b + g.g_ab) + 3 (g.g_a)(g.g_b).
    let along = first.map(|change| unit.dot(change));
    let changes = [0, 1].map(|a| first[a] - unit * along[a]);
    let pairs = [(0, 0), (0, 1), (1, 1)];
    let bends = std::array::from_fn(|k| {
        let (a, b) = pairs[k];
        let r_ab = -(first[a].dot(first[b]) + unit.dot(second[k])) + 3.0 * along[a] * along[b];
        second[k] - first[a] * along[b] - first[b] * along[a] + unit * r_ab
    });
    (changes, bends)
}
