//! Spheres.

use super::super::derivatives::without_third;
use super::super::implicit_shape::ImplicitShape;
use super::super::tessellation::mesh::{SurfaceMesh, cells, sphere_mesh};
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3};

/// `g = (|p|^2 - r^2) / 2r`.
pub(in super::super) struct Sphere {
    pub(in super::super) radius: f64,
}

/// Rings of the tessellation: the error is at most `1 - cos` of half a cell's diagonal, a radius: 9.7e-5, which is
/// 2.8e-5 of the box's diagonal.
pub(in super::super) const RINGS: u32 = 160;

impl ImplicitShape for Sphere {
    fn corners(&self) -> [DVec3; 2] {
        [DVec3::splat(-self.radius), DVec3::splat(self.radius)]
    }

    #[inline]
    fn taylor2(&self, point: DVec3) -> Taylor2 {
        let inverse = 1.0 / self.radius;
        Taylor2 {
            value: 0.5 * (point.length_squared() * inverse - self.radius),
            gradient: point * inverse,
            hessian: DMat3::from_diagonal(DVec3::splat(inverse)),
        }
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        without_third(self.taylor2(point))
    }

    #[inline]
    fn outwards(&self, point: DVec3) -> DVec3 {
        point
    }

    #[inline]
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        meet_sphere(origin, direction, self.radius * self.radius, near, far)
    }

    fn tessellate(&self, fineness: f64) -> SurfaceMesh {
        let rings = cells(RINGS, fineness);
        sphere_mesh(self.radius as f32, rings, 2 * rings)
    }

    fn is_convex(&self) -> bool {
        true
    }
}

/// The hit of a ray (its direction of any length) with a sphere about the origin.
#[inline]
pub(in super::super) fn meet_sphere(origin: DVec3, direction: DVec3, radius2: f64, near: f64, far: f64) -> Option<f64> {
    let length2 = direction.length_squared();
    let along = -origin.dot(direction) / length2;
    // Distance of the ray's line from the centre, without cancellation.
    let closest = origin + direction * along;
    let discriminant = (radius2 - closest.length_squared()) / length2;
    if discriminant < 0.0 {
        return None;
    }
    let half = discriminant.sqrt();
    let distance = if along - half >= near { along - half } else { along + half };
    // Written so that a NaN is no hit.
    (distance >= near && distance < far).then_some(distance)
}
