//! Tori.

use super::super::derivatives::{self, ImplicitFunction, outer};
use super::super::implicit_shape::ImplicitShape;
use super::super::parameters::{SurfaceError, checked_length};
use super::super::ray::{clip, product_of_quadratics, roomy};
use super::super::tessellation::mesh::{ProfilePoint, SurfaceMesh, cells, revolved};
use crate::math::portable::PortableMath;
use crate::math::roots::first_bernstein_root;
use crate::math::scalar::Scalar;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// A torus about the y axis; `g` is the signed distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Torus {
    major_radius: f64,
    minor_radius: f64,
}

/// Distances from the axis or the ring are rounded up to this share of the major radius: there is no gradient there.
const SOFTENING: f64 = 1e-12;

impl Torus {
    /// The torus whose tube of `minor_radius` runs at `major_radius` about the axis; both from 1e-9 to 1e9, the minor
    /// one the smaller: others pass through themselves.
    pub fn new(major_radius: f64, minor_radius: f64) -> Result<Self, SurfaceError> {
        checked_length("major_radius", major_radius)?;
        checked_length("minor_radius", minor_radius)?;
        if minor_radius >= major_radius {
            let problem = format!("{minor_radius}; must be below `major_radius` {major_radius}");
            return Err(SurfaceError::new("minor_radius", problem));
        }
        Ok(Self { major_radius, minor_radius })
    }

    /// The radius of the circle that the tube runs along.
    pub fn major_radius(&self) -> f64 {
        self.major_radius
    }

    /// The radius of the tube.
    pub fn minor_radius(&self) -> f64 {
        self.minor_radius
    }

    pub(in super::super) fn scaled(&self, scale: f64) -> Self {
        Self { major_radius: self.major_radius * scale, minor_radius: self.minor_radius * scale }
    }

    /// The square of the softening.
    fn soft2(&self) -> f64 {
        (SOFTENING * self.major_radius).powi(2)
    }
}

impl ImplicitFunction for Torus {
    fn value<S: Scalar>(&self, [x, y, z]: [S; 3]) -> S {
        let soft2 = S::constant(self.soft2());
        let beside = (x * x + z * z + soft2).sqrt() - S::constant(self.major_radius);
        (beside * beside + y * y + soft2).sqrt() - S::constant(self.minor_radius)
    }
}

impl ImplicitShape for Torus {
    fn corners(&self) -> [DVec3; 2] {
        let wide = self.major_radius + self.minor_radius;
        let half = DVec3::new(wide, self.minor_radius, wide);
        [-half, half]
    }

    #[inline]
    fn taylor2(&self, point: DVec3) -> Taylor2 {
        let soft2 = self.soft2();
        let axis_distance = (point.x * point.x + point.z * point.z + soft2).sqrt();
        let outwards = DVec3::new(point.x, 0.0, point.z) / axis_distance;
        let beside = axis_distance - self.major_radius;
        let distance = (beside * beside + point.y * point.y + soft2).sqrt();
        let normal = (outwards * beside + DVec3::Y * point.y) / distance;
        // The Hessian of the distance from the axis.
        let turning = (DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0)) - outer(outwards, outwards))
            * (beside / (axis_distance * distance));
        let mut across = outer(outwards, outwards) - outer(normal, normal);
        across.y_axis.y += 1.0;
        Taylor2 { value: distance - self.minor_radius, gradient: normal, hessian: across * (1.0 / distance) + turning }
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        derivatives::taylor3(self, point)
    }

    #[inline]
    fn outwards(&self, point: DVec3) -> DVec3 {
        let axis_distance = (point.x * point.x + point.z * point.z + self.soft2()).sqrt();
        let share = 1.0 - self.major_radius / axis_distance;
        DVec3::new(point.x * share, point.y, point.z * share)
    }

    #[inline]
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        let (enter, leave) = clip(origin, direction, roomy(self.corners()), near, far)?;
        let (a, b) = (origin + direction * enter, origin + direction * leave);
        // (|p|^2 + R^2 - r^2)^2 = 4 R^2 (x^2 + z^2), in Bernstein form between the two points.
        let offset = (self.major_radius - self.minor_radius) * (self.major_radius + self.minor_radius);
        let axial = [a.x * a.x + a.z * a.z, a.x * b.x + a.z * b.z, b.x * b.x + b.z * b.z];
        let sums = [axial[0] + a.y * a.y + offset, axial[1] + a.y * b.y + offset, axial[2] + b.y * b.y + offset];
        let squares = product_of_quadratics(sums, sums);
        let factor = 4.0 * self.major_radius * self.major_radius;
        let tubes = product_of_quadratics(axial.map(|value| value * factor), [1.0; 3]);
        let coefficients: [f64; 5] = std::array::from_fn(|k| squares[k] - tubes[k]);
        let share = first_bernstein_root(&coefficients)?;
        Some(enter + share * (leave - enter))
    }

    fn tessellate(&self, fineness: f64) -> SurfaceMesh {
        // Half of the error of 1e-4 outer radii along each direction.
        let share = self.minor_radius / (self.major_radius + self.minor_radius);
        let steps = cells(((320.0 * share.sqrt()).ceil() as u32).max(16), fineness);
        let point = |step: u32| {
            let (sin, cos) = ((step % steps) as f64 / steps as f64 * TAU).sine_cosine();
            ProfilePoint {
                radius: self.major_radius + self.minor_radius * cos,
                height: self.minor_radius * sin,
                direction: [-sin, cos],
            }
        };
        revolved(&(0..=steps).map(point).collect::<Vec<_>>(), cells(320, fineness))
    }
}
