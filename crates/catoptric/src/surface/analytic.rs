//! Surfaces given by formulas. Rays meet them exactly (in double precision); the rasteriser draws a tessellation.

use super::taylor::{Taylor2, Taylor3};
use crate::math::Aabb;
use glam::{Affine3A, DMat3, DVec3, Mat3, Vec2, Vec3};

/// A surface given by a formula, in its own frame, centred at the origin.
#[derive(Clone, Debug, PartialEq)]
pub enum AnalyticSurface {
    /// A sphere.
    Sphere {
        /// The radius, above 0.
        radius: f32,
    },
    /// A rectangle in the xz plane; its outer side is +y.
    Plane {
        /// Half its extent along x.
        half_width: f32,
        /// Half its extent along z.
        half_height: f32,
    },
}

/// A surface placed in the world by a rotation and a translation.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedSurface {
    /// The shape.
    pub surface: AnalyticSurface,
    /// Its place: rotation and translation only.
    pub world_from_surface: Affine3A,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Distance along the ray.
    pub distance: f32,
    /// The point, on the surface to single precision.
    pub position: Vec3,
    /// The outer unit normal.
    pub normal: Vec3,
    /// The shape operator in world axes: the change of the unit normal with a tangential step is `curvature * step`.
    ///
    /// The surfaces here have one curvature in all directions; it is positive where the outside is convex.
    pub curvature: f32,
}

/// A tessellation of a surface.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMesh {
    /// Points on the surface.
    pub positions: Vec<Vec3>,
    /// Exact outer unit normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl AnalyticSurface {
    /// The box around the surface in its own frame.
    pub fn bounds(&self) -> Aabb {
        let half = match *self {
            Self::Sphere { radius } => Vec3::splat(radius),
            Self::Plane { half_width, half_height } => Vec3::new(half_width, 0.0, half_height),
        };
        Aabb { min: -half, max: half }
    }

    /// The surface, `scale` times as large.
    pub fn scaled(&self, scale: f32) -> Self {
        match *self {
            Self::Sphere { radius } => Self::Sphere { radius: radius * scale },
            Self::Plane { half_width, half_height } => {
                Self::Plane { half_width: half_width * scale, half_height: half_height * scale }
            }
        }
    }

    /// The name of the kind in scene files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Plane { .. } => "plane",
        }
    }

    /// Triangles whose points lie on the surface.
    ///
    /// A sphere's lie at most 5e-5 radii inside it: a twentieth of a pixel when the sphere is 2,000 pixels wide.
    pub fn tessellate(&self) -> SurfaceMesh {
        match *self {
            Self::Sphere { radius } => sphere_mesh(radius, 160, 320),
            Self::Plane { half_width: w, half_height: h } => SurfaceMesh {
                positions: [(-w, -h), (w, -h), (w, h), (-w, h)].map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(),
                normals: vec![Vec3::Y; 4],
                uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
                triangles: vec![[0, 2, 1], [0, 3, 2]],
            },
        }
    }
}

/// A sphere of rings (pole to pole along y) and segments, with exact normals.
pub(crate) fn sphere_mesh(radius: f32, rings: u32, segments: u32) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for ring in 0..=rings {
        let v = ring as f32 / rings as f32;
        let (sin_polar, cos_polar) = (v * std::f32::consts::PI).sin_cos();
        for segment in 0..=segments {
            let u = segment as f32 / segments as f32;
            // The seam's two columns of vertices must be the same points, bit for bit.
            let (sin, cos) = ((segment % segments) as f32 / segments as f32 * std::f32::consts::TAU).sin_cos();
            let sin_polar = if ring == 0 || ring == rings { 0.0 } else { sin_polar };
            let normal = Vec3::new(sin_polar * cos, cos_polar, sin_polar * sin).normalize();
            mesh.positions.push(normal * radius);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    let index = |ring: u32, segment: u32| ring * (segments + 1) + segment;
    for ring in 0..rings {
        for segment in 0..segments {
            let [a, b, c, d] = [
                index(ring, segment),
                index(ring, segment + 1),
                index(ring + 1, segment + 1),
                index(ring + 1, segment),
            ];
            if ring > 0 {
                mesh.triangles.push([a, b, c]);
            }
            if ring + 1 < rings {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

impl PlacedSurface {
    /// The box around the surface in the world.
    pub fn bounds(&self) -> Aabb {
        self.surface.bounds().transformed(&self.world_from_surface)
    }

    /// The surface's implicit function at a world point, to second order. It is meant for points near the surface;
    /// everything is finite for finite points, but the gradient can vanish (at the centre of a sphere, say).
    pub fn taylor2(&self, point: DVec3) -> Taylor2 {
        self.taylor3(point).lower
    }

    /// The surface's implicit function at a world point, to third order.
    pub fn taylor3(&self, point: DVec3) -> Taylor3 {
        let surface_from_world = Mat3::from(self.world_from_surface.matrix3).as_dmat3().transpose();
        let local = surface_from_world * (point - Vec3::from(self.world_from_surface.translation).as_dvec3());
        let lower = match self.surface {
            AnalyticSurface::Sphere { radius } => Taylor2 {
                value: local.length_squared() - (radius as f64).powi(2),
                gradient: surface_from_world.transpose() * local * 2.0,
                hessian: surface_from_world.transpose() * surface_from_world * 2.0,
            },
            AnalyticSurface::Plane { .. } => {
                Taylor2 { value: local.y, gradient: surface_from_world.transpose() * DVec3::Y, hessian: DMat3::ZERO }
            }
        };
        Taylor3 { lower, third: [DMat3::ZERO; 3] }
    }

    /// The distance along a ray that separates its two meetings with the surface: below it lies the nearer.
    ///
    /// Negative infinity where there is one meeting at most.
    pub fn middle_distance(&self, origin: Vec3, direction: Vec3) -> f32 {
        match self.surface {
            AnalyticSurface::Sphere { .. } => (Vec3::from(self.world_from_surface.translation) - origin).dot(direction),
            AnalyticSurface::Plane { .. } => f32::NEG_INFINITY,
        }
    }

    /// The first point of the ray on the surface with a distance between `near` and `far`.
    ///
    /// `direction` is of unit length. Solved in double precision; the distance is rounded to single.
    #[inline]
    pub fn intersect(&self, origin: Vec3, direction: Vec3, near: f32, far: f32) -> Option<SurfaceHit> {
        let surface_from_world = self.world_from_surface.matrix3.transpose();
        let center: Vec3 = self.world_from_surface.translation.into();
        let relative = origin.as_dvec3() - center.as_dvec3();
        let (near, far) = (near as f64, far as f64);
        match self.surface {
            AnalyticSurface::Sphere { radius } => {
                let direction = direction.as_dvec3();
                let radius = radius as f64;
                let length2 = direction.length_squared();
                let along = -relative.dot(direction) / length2;
                // Distance of the ray's line from the centre, without cancellation.
                let closest = relative + direction * along;
                let discriminant = (radius * radius - closest.length_squared()) / length2;
                if discriminant < 0.0 {
                    return None;
                }
                let half = discriminant.sqrt();
                let distance = if along - half >= near { along - half } else { along + half };
                if !(distance >= near && distance < far) {
                    return None;
                }
                let normal = (relative + direction * distance).normalize();
                Some(SurfaceHit {
                    distance: distance as f32,
                    position: (center.as_dvec3() + normal * radius).as_vec3(),
                    normal: normal.as_vec3(),
                    curvature: (1.0 / radius) as f32,
                })
            }
            AnalyticSurface::Plane { half_width, half_height } => {
                let rotate = |v: DVec3| {
                    let m = surface_from_world;
                    DVec3::new(
                        m.x_axis.x as f64 * v.x + m.y_axis.x as f64 * v.y + m.z_axis.x as f64 * v.z,
                        m.x_axis.y as f64 * v.x + m.y_axis.y as f64 * v.y + m.z_axis.y as f64 * v.z,
                        m.x_axis.z as f64 * v.x + m.y_axis.z as f64 * v.y + m.z_axis.z as f64 * v.z,
                    )
                };
                let (o, d) = (rotate(relative), rotate(direction.as_dvec3()));
                if d.y == 0.0 {
                    return None;
                }
                let distance = -o.y / d.y;
                let (x, z) = (o.x + d.x * distance, o.z + d.z * distance);
                let hit =
                    distance >= near && distance < far && x.abs() <= half_width as f64 && z.abs() <= half_height as f64;
                hit.then(|| SurfaceHit {
                    distance: distance as f32,
                    position: self.world_from_surface.transform_point3(Vec3::new(x as f32, 0.0, z as f32)),
                    normal: self.world_from_surface.matrix3.y_axis.into(),
                    curvature: 0.0,
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn tessellations_face_outwards_and_lie_on_the_surface() {
        for surface in
            [AnalyticSurface::Sphere { radius: 2.0 }, AnalyticSurface::Plane { half_width: 1.0, half_height: 3.0 }]
        {
            let mesh = surface.tessellate();
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                let normal = (b - a).cross(c - a);
                assert!(normal.dot(mesh.normals[triangle[0] as usize]) > 0.0);
            }
        }
    }

    #[test]
    fn rays_meet_sphere_and_plane() {
        let place = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.3), Vec3::new(1.0, 2.0, 3.0));
        let sphere = PlacedSurface { surface: AnalyticSurface::Sphere { radius: 0.5 }, world_from_surface: place };
        let hit = sphere.intersect(Vec3::new(1.0, 2.0, 9.0), Vec3::NEG_Z, 0.0, f32::INFINITY).unwrap();
        assert!((hit.distance - 5.5).abs() < 1e-6 && (hit.normal - Vec3::Z).length() < 1e-6);
        let inside = sphere.intersect(Vec3::new(1.0, 2.0, 3.0), Vec3::X, 0.0, f32::INFINITY).unwrap();
        assert!((inside.distance - 0.5).abs() < 1e-6);
        assert!(sphere.intersect(Vec3::new(1.0, 2.0, 9.0), Vec3::Z, 0.0, f32::INFINITY).is_none());

        let plane = AnalyticSurface::Plane { half_width: 1.0, half_height: 2.0 };
        let plane = PlacedSurface { surface: plane, world_from_surface: place };
        let normal: Vec3 = place.matrix3.y_axis.into();
        let hit = plane.intersect(Vec3::new(1.0, 2.0, 3.0) + normal * 4.0, -normal, 0.0, f32::INFINITY).unwrap();
        assert!((hit.distance - 4.0).abs() < 1e-5 && (hit.normal - normal).length() < 1e-6);
        let across: Vec3 = place.matrix3.x_axis.into();
        let outside = Vec3::new(1.0, 2.0, 3.0) + normal * 4.0 + across * 1.01;
        assert!(plane.intersect(outside, -normal, 0.0, f32::INFINITY).is_none());
    }
}
