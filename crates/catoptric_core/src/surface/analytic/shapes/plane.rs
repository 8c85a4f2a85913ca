//! Rectangles.

use super::super::derivatives::without_third;
use super::super::implicit_shape::ImplicitShape;
use super::super::tessellation::mesh::SurfaceMesh;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DMat3, DVec3, Vec2, Vec3};

/// `g = y`.
pub(in super::super) struct Plane {
    pub(in super::super) half_width: f64,
    pub(in super::super) half_height: f64,
}

impl ImplicitShape for Plane {
    fn corners(&self) -> [DVec3; 2] {
        let half = DVec3::new(self.half_width, 0.0, self.half_height);
        [-half, half]
    }

    fn taylor2(&self, point: DVec3) -> Taylor2 {
        Taylor2 { value: point.y, gradient: DVec3::Y, hessian: DMat3::ZERO }
    }

    fn taylor3(&self, point: DVec3) -> Taylor3 {
        without_third(self.taylor2(point))
    }

    fn outwards(&self, _: DVec3) -> DVec3 {
        DVec3::Y
    }

    #[inline]
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64> {
        if direction.y == 0.0 {
            return None;
        }
        let distance = -origin.y / direction.y;
        let (x, z) = (origin.x + direction.x * distance, origin.z + direction.z * distance);
        let is_hit = distance >= near && distance < far && x.abs() <= self.half_width && z.abs() <= self.half_height;
        is_hit.then_some(distance)
    }

    fn tessellate(&self, _fineness: f64) -> SurfaceMesh {
        let (w, h) = (self.half_width as f32, self.half_height as f32);
        SurfaceMesh {
            positions: [(-w, -h), (w, -h), (w, h), (-w, h)].map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(),
            normals: vec![Vec3::Y; 4],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            triangles: vec![[0, 2, 1], [0, 3, 2]],
        }
    }

    fn is_convex(&self) -> bool {
        true
    }
}
