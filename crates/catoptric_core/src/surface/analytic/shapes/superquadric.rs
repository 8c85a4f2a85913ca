//! Superquadrics.

use super::super::derivatives::{self, ImplicitFunction, outer};
use super::super::implicit_shape::ImplicitShape;
use super::super::parameters::{SurfaceError, checked_length};
use super::super::ray::{clip, roomy};
use super::super::tessellation::mesh::{SurfaceMesh, cells};
use crate::math::interval::{Interval, IntervalDual};
use crate::math::portable::PortableMath;
use crate::math::roots::first_interval_root;
use crate::math::scalar::Scalar;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3, Vec2};
use std::f64::consts::FRAC_PI_2;

/// A superquadric (Barr 1981, Superquadrics and angle-preserving transformations) about the origin:
/// `(|x/a|^(2/e2) + |y/b|^(2/e2))^(e2/e1) + |z/c|^(2/e1) = 1`.
///
/// The left side to the power of `e1 / 2` grows in proportion to the distance from the centre; less 1 and times the
/// smallest radius it is `g`. Derivatives of higher order are infinite on the coordinate planes for most exponents:
/// there coordinates are taken as `SOFTENING` away from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Superquadric {
    radii: DVec3,
    exponents: [f64; 2],
}

/// The least distance of coordinates from zero, as a share of the radii: it moves the surface by less than rounding
/// where exponents are at most 2 and by less than 1e-7 of the size elsewhere.
const SOFTENING: f64 = 1e-15;

/// The exponents that are allowed: from nearly a box to four cusps.
const EXPONENTS: std::ops::RangeInclusive<f64> = 0.05..=4.0;

impl Superquadric {
    /// The superquadric of these radii along x, y and z (each from 1e-9 to 1e9) and exponents `[e1, e2]` (each from
    /// 0.05, nearly a box, over 1, an ellipsoid, and 2, an octahedron, to 4, which has cusps).
    pub fn new(radii: [f64; 3], exponents: [f64; 2]) -> Result<Self, SurfaceError> {
        for radius in radii {
            checked_length("radii", radius)?;
        }
        if exponents.iter().any(|exponent| !EXPONENTS.contains(exponent)) {
            let (least, most) = (EXPONENTS.start(), EXPONENTS.end());
            let problem = format!("{exponents:?}; exponents must be from {least} to {most}");
            return Err(SurfaceError::new("exponents", problem));
        }
        Ok(Self { radii: DVec3::from(radii), exponents })
    }

    /// The radii along x, y and z.
    pub fn radii(&self) -> DVec3 {
        self.radii
    }

    /// The exponents `[e1, e2]`: of the profiles along z, and of the sections across z.
    pub fn exponents(&self) -> [f64; 2] {
        self.exponents
    }

    pub(in super::super) fn scaled(&self, scale: f64) -> Self {
        Self { radii: self.radii * scale, exponents: self.exponents }
    }

    /// The value of `g` at a point in the surface's frame, for numbers of any kind.
    pub fn value<S: Scalar>(&self, point: [S; 3]) -> S {
        ImplicitFunction::value(self, point)
    }

    /// Value and gradient of `g` at a point in the surface's frame.
    pub fn value_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        let [e1, e2] = self.exponents;
        let soft2 = SOFTENING * SOFTENING;
        let unit = point / self.radii;
        let squares = unit * unit + soft2;
        let across = Mean::new(e2, squares.x, squares.y);
        let all = Mean::new(e1, across.value, squares.z);
        let size = all.value.sqrt();
        let (x, y, z) = (all.slope[0] * across.slope[0], all.slope[0] * across.slope[1], all.slope[1]);
        let least = self.radii.min_element();
        let gradient = DVec3::new(x, y, z) * unit / self.radii * (least / size);
        (least * (size - 1.0), gradient)
    }

    /// The first root along a ray between distances in a box around the surface, where all exponents are at most 2.
    /// `g` is convex then: Newton's method from outside the root never passes it.
    fn convex_root(&self, origin: DVec3, direction: DVec3, enter: f64, leave: f64) -> Option<f64> {
        let along = |t: f64| {
            let (value, gradient) = self.value_and_gradient(origin + direction * t);
            (value, gradient.dot(direction))
        };
        let (at_enter, _) = along(enter);
        // From inside the body the way out is the only root; it is approached from the far end.
        let (mut t, forwards) = if at_enter >= 0.0 { (enter, true) } else { (leave, false) };
        let settled = 4.0 * f64::EPSILON * (self.radii.max_element() + t.abs());
        for _ in 0..200 {
            let (value, slope) = along(t);
            if value <= 0.0 {
                // On the surface, or past it by rounding; a surface that starts beyond the end is not met.
                return (forwards || t < leave).then_some(t);
            }
            if (slope < 0.0) != forwards || slope == 0.0 {
                return None; // it passes beside
            }
            let next = t - value / slope;
            if !(next >= enter && next <= leave) {
                return None;
            }
            if (next - t).abs() <= settled {
                return Some(next);
            }
            t = next;
        }
        None
    }
}

/// The mean `(u^(1/e) + v^(1/e))^e` of two positive numbers, with its derivatives; it grows in proportion to them.
struct Mean {
    value: f64,
    slope: [f64; 2],
    /// The mixed second derivative; the others follow, as the first ones depend on the ratio of the numbers alone.
    mixed: f64,
}

impl Mean {
    #[inline]
    fn new(exponent: f64, u: f64, v: f64) -> Self {
        let power = 1.0 / exponent;
        let larger = u.max(v);
        let (p, q) = ((u / larger).power(power), (v / larger).power(power));
        let sum = p + q;
        let value = larger * sum.power(exponent);
        let slope = [value * p / (sum * u), value * q / (sum * v)];
        Self { value, slope, mixed: (1.0 - power) * slope[0] * slope[1] / value }
    }
}

/// The same for all kinds of numbers.
fn mean<S: Scalar>(exponent: f64, u: S, v: S) -> S {
    let larger = S::constant(u.representative().max(v.representative()));
    let power = 1.0 / exponent;
    ((u / larger).powf(power) + (v / larger).powf(power)).powf(exponent) * larger
}

impl ImplicitFunction for Superquadric {
    fn value<S: Scalar>(&self, [x, y, z]: [S; 3]) -> S {
        let [e1, e2] = self.exponents;
        let square = |x: S, radius: f64| (x * S::constant(1.0 / radius)).powi(2) + S::constant(SOFTENING * SOFTENING);
        let across = mean(e2, square(x, self.radii.x), square(y, self.radii.y));
        let size = mean(e1, across, square(z, self.radii.z)).sqrt();
        (size - S::constant(1.0)) * S::constant(self.radii.min_element())
    }
}

impl ImplicitShape for Superquadric {
    fn corners(&self) -> [DVec3; 2] {
        [-self.radii, self.radii]
    }

    fn taylor2(&self, point: DVec3) -> Taylor2 {
        let [e1, e2] = self.exponents;
        let unit = point / self.radii;
        let squares = unit * unit + SOFTENING * SOFTENING;
        let inverse2 = 1.0 / (self.radii * self.radii);
        // Derivatives of the squares of the scaled coordinates.
        let first = 2.0 * point * inverse2;
        let second = 2.0 * inverse2;
        let across = Mean::new(e2, squares.x, squares.y);
        let all = Mean::new(e1, across.value, squares.z);
        let (u, v) = (squares.x, squares.y);
        let gradient_across = DVec3::new(across.slope[0] * first.x, across.slope[1] * first.y, 0.0);
        let mut hessian_across = DMat3::ZERO;
        hessian_across.x_axis.x = across.slope[0] * second.x - v / u * across.mixed * first.x * first.x;
        hessian_across.y_axis.y = across.slope[1] * second.y - u / v * across.mixed * first.y * first.y;
        hessian_across.x_axis.y = across.mixed * first.x * first.y;
        hessian_across.y_axis.x = hessian_across.x_axis.y;
        let along_z = DVec3::new(0.0, 0.0, first.z);
        let gradient = gradient_across * all.slope[0] + along_z * all.slope[1];
        let mut hessian = outer(gradient_across, gradient_across) * (-squares.z / across.value * all.mixed)
            + (outer(gradient_across, along_z) + outer(along_z, gradient_across)) * all.mixed
            + hessian_across * all.slope[0];
        hessian.z_axis.z += all.slope[1] * second.z - across.value / squares.z * all.mixed * first.z * first.z;
        let size = all.value.sqrt();
        let least = self.radii.min_element();
        Taylor2 {
            value: least * (size - 1.0),
            gradient: gradient * (0.5 * least / size),
            hessian: (hessian - outer(gradient, gradient) * (0.5 / all.value)) * (0.5 * least / size),
        }
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        derivatives::taylor3(self, point)
    }

    fn outwards(&self, point: DVec3) -> DVec3 {
        self.value_and_gradient(point).1
    }

    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        let (enter, leave) = clip(origin, direction, roomy(self.corners()), near, far)?;
        if self.is_convex() {
            return self.convex_root(origin, direction, enter, leave);
        }
        let along = |axis: usize, t: Interval| {
            let value = Interval::constant(origin[axis]) + t * Interval::constant(direction[axis]);
            IntervalDual { value, slope: Interval::constant(direction[axis]) }
        };
        first_interval_root(
            |t| self.value([along(0, t), along(1, t), along(2, t)]),
            |t| {
                let (value, gradient) = self.value_and_gradient(origin + direction * t);
                (value, gradient.dot(direction))
            },
            enter,
            leave,
        )
    }

    fn tessellate(&self, fineness: f64) -> SurfaceMesh {
        // Barr's parameters: angles whose powers crowd the points where the surface bends most.
        let quarter_cells = cells(80, fineness);
        let [e1, e2] = self.exponents;
        let powers = |exponent: f64, step: u32| {
            // The same numbers in all quarters, and exact ones at their ends.
            let (quarter, step) = (step / quarter_cells % 4, step % quarter_cells);
            let (sin, cos) = match step {
                0 => (0.0, 1.0),
                _ => (step as f64 / quarter_cells as f64 * FRAC_PI_2).sine_cosine(),
            };
            let (sin, cos) = (sin.power(exponent), cos.power(exponent));
            match quarter {
                0 => (sin, cos),
                1 => (cos, -sin),
                2 => (-sin, -cos),
                _ => (-cos, sin),
            }
        };
        let mut mesh = SurfaceMesh::default();
        let (rows, columns) = (2 * quarter_cells, 4 * quarter_cells);
        for row in 0..=rows {
            let (height, wide) = powers(e1, row + 3 * quarter_cells);
            for column in 0..=columns {
                let (y, x) = powers(e2, column);
                let position = (DVec3::new(x * wide, y * wide, height) * self.radii).as_vec3();
                let gradient = self.outwards(position.as_dvec3());
                mesh.positions.push(position);
                mesh.normals.push(gradient.normalize_or(DVec3::Z).as_vec3());
                mesh.uvs.push(Vec2::new(column as f32 / columns as f32, 1.0 - row as f32 / rows as f32));
            }
        }
        mesh.join_grid(rows, columns);
        mesh
    }

    fn is_convex(&self) -> bool {
        self.exponents.iter().all(|exponent| *exponent <= 2.0)
    }
}
