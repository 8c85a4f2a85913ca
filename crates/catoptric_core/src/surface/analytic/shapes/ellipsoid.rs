//! Ellipsoids.

use super::super::derivatives::without_third;
use super::super::implicit_shape::ImplicitShape;
use super::super::parameters::{SurfaceError, checked_length};
use super::super::tessellation::mesh::{SurfaceMesh, cells, sphere_mesh};
use super::sphere::{RINGS, meet_sphere};
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3};

/// An ellipsoid about the origin: `g = (x^2/a^2 + y^2/b^2 + z^2/c^2 - 1) m / 2` with the smallest radius `m`.
#[derive(Clone, Debug, PartialEq)]
pub struct Ellipsoid {
    radii: DVec3,
    inverse_radii: DVec3,
}

impl Ellipsoid {
    /// The ellipsoid of these radii along x, y and z; each from 1e-9 to 1e9.
    pub fn new(radii: [f64; 3]) -> Result<Self, SurfaceError> {
        for radius in radii {
            checked_length("radii", radius)?;
        }
        Ok(Self::of_radii(DVec3::from(radii)))
    }

    fn of_radii(radii: DVec3) -> Self {
        Self { radii, inverse_radii: 1.0 / radii }
    }

    /// The radii along x, y and z.
    pub fn radii(&self) -> DVec3 {
        self.radii
    }

    pub(in super::super) fn scaled(&self, scale: f64) -> Self {
        Self::of_radii(self.radii * scale)
    }
}

impl ImplicitShape for Ellipsoid {
    fn corners(&self) -> [DVec3; 2] {
        [-self.radii, self.radii]
    }

    #[inline]
    fn taylor2(&self, point: DVec3) -> Taylor2 {
        let unit = point * self.inverse_radii;
        let least = self.radii.min_element();
        Taylor2 {
            value: 0.5 * least * (unit.length_squared() - 1.0),
            gradient: unit * self.inverse_radii * least,
            hessian: DMat3::from_diagonal(self.inverse_radii * self.inverse_radii * least),
        }
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        without_third(self.taylor2(point))
    }

    #[inline]
    fn outwards(&self, point: DVec3) -> DVec3 {
        point * self.inverse_radii * self.inverse_radii
    }

    #[inline]
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        meet_sphere(origin * self.inverse_radii, direction * self.inverse_radii, 1.0, near, far)
    }

    fn tessellate(&self, fineness: f64) -> SurfaceMesh {
        // A stretched sphere: its error is at most the sphere's times the largest radius.
        let rings = cells(RINGS, fineness);
        let mut mesh = sphere_mesh(1.0, rings, 2 * rings);
        for (position, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
            let unit = normal.as_dvec3();
            *position = (unit * self.radii).as_vec3();
            *normal = (unit * self.inverse_radii).normalize().as_vec3();
        }
        mesh
    }

    fn is_convex(&self) -> bool {
        true
    }
}
