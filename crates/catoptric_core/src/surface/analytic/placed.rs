//! Surfaces in the world.

use super::derivatives::outer;
use super::implicit_shape::ImplicitShape;
use super::shapes::{Plane, Sphere};
use super::{AnalyticSurface, with_shape};
use crate::math::Aabb;
use crate::surface::taylor::{Taylor2, Taylor3};
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// A surface placed in the world by a rotation and a translation.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedSurface {
    /// The shape.
    pub surface: AnalyticSurface,
    /// The surface's place: rotation and translation only.
    pub world_from_surface: DAffine3,
}

/// The intersection of a ray with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Distance along the ray.
    pub distance: f32,
    /// The point, on the surface to single precision.
    pub position: Vec3,
    /// The outer unit normal.
    pub normal: Vec3,
}

/// The reach of [`PlacedSurface::refine`], as a share of the diagonal of the surface's box.
///
/// A tessellation off by `5e-5` of the diagonal can be met up to `sqrt(2 * 5e-5)` of a radius of curvature away from
/// the surface where a ray grazes it.
const REFINEMENT_REACH: f64 = 0.02;

impl PlacedSurface {
    /// The box around the surface in the world.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.surface.bounds().transformed(&self.world_from_surface)
    }

    /// The linear map from directions in the world to those in the surface's frame.
    #[inline]
    fn surface_from_world(&self) -> DMat3 {
        self.world_from_surface.matrix3.transpose()
    }

    #[inline]
    fn center(&self) -> DVec3 {
        self.world_from_surface.translation
    }

    /// The surface's implicit function at a world point, to second order.
    ///
    /// The function serves points near the surface, where its gradient has a length of about 1 for most kinds, and goes
    /// on a little beyond the surface's ends. Everything is finite for finite points, but the gradient can vanish (at
    /// the centre of a sphere, say).
    #[inline]
    pub fn taylor2(&self, point: DVec3) -> Taylor2 {
        let relative = point - self.center();
        if let AnalyticSurface::Sphere { radius } = self.surface {
            return Sphere { radius }.taylor2(relative); // turned as you like
        }
        let turn = self.surface_from_world();
        turned(&turn, &with_shape!(&self.surface, shape => shape.taylor2(turn * relative)))
    }

    /// The surface's implicit function at a world point, to third order; otherwise as [`Self::taylor2`].
    pub fn taylor3(&self, point: DVec3) -> Taylor3 {
        let relative = point - self.center();
        if let AnalyticSurface::Sphere { radius } = self.surface {
            return Sphere { radius }.taylor3(relative);
        }
        let turn = self.surface_from_world();
        let local = with_shape!(&self.surface, shape => shape.taylor3(turn * relative));
        let back = turn.transpose();
        let third = local.third.map(|third| back * third * turn);
        // The derivative by a world axis is that along the axis as it is seen from the surface.
        let along = |axis: DVec3| third[0] * axis.x + third[1] * axis.y + third[2] * axis.z;
        Taylor3 {
            lower: turned(&turn, &local.lower),
            third: [along(turn.x_axis), along(turn.y_axis), along(turn.z_axis)],
        }
    }

    /// The shape operator at a world point on (or near) the surface: the change of the outer unit normal with a
    /// tangential step is `shape * step`. Symmetric; positive where the outside is convex; steps along the normal
    /// change nothing. Zero where the gradient vanishes.
    #[inline]
    pub fn shape_operator(&self, point: DVec3) -> DMat3 {
        let taylor = self.taylor2(point);
        let length = taylor.gradient.length();
        let Some(normal) = taylor.normal() else { return DMat3::ZERO };
        let tangential = DMat3::IDENTITY - outer(normal, normal);
        let shape = tangential * taylor.hessian * tangential * (1.0 / length);
        if shape.is_finite() { shape } else { DMat3::ZERO }
    }

    /// Returns true if a world point lies within the extent of the sheet (its box, in its own frame, with a relative
    /// room of 1e-6 for rounding). The distance from the surface is not tested.
    #[inline]
    pub fn is_within_bounds(&self, point: DVec3) -> bool {
        let local = self.surface_from_world() * (point - self.center());
        let [min, max] = with_shape!(&self.surface, shape => shape.corners());
        let room = DVec3::splat(1e-6 * (max - min).length());
        local.cmpge(min - room).all() && local.cmple(max + room).all()
    }

    /// Returns true if a ray that leaves the outer side never meets the surface again.
    pub fn is_convex(&self) -> bool {
        self.surface.is_convex()
    }

    /// The first point of the ray on the surface with a distance between `near` and `far`.
    ///
    /// `direction` is of unit length. Solved in double precision; the distance is rounded to single. No first meeting
    /// is missed, but where a ray touches the surface without passing it rounding decides.
    #[inline]
    pub fn intersect(&self, origin: Vec3, direction: Vec3, near: f32, far: f32) -> Option<SurfaceHit> {
        let distance = self.first_distance(origin, direction, near, far)?;
        let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
        if let AnalyticSurface::Sphere { radius } = self.surface {
            let normal = (origin - self.center() + direction * distance).normalize();
            let position = (self.center() + normal * radius).as_vec3();
            return Some(SurfaceHit { distance: distance as f32, position, normal: normal.as_vec3() });
        }
        self.hit_at(origin, direction, distance, &self.surface_from_world())
    }

    /// The distance alone of [`Self::intersect`], in double precision.
    #[inline]
    pub fn first_distance(&self, origin: Vec3, direction: Vec3, near: f32, far: f32) -> Option<f64> {
        let direction = direction.as_dvec3();
        let relative = origin.as_dvec3() - self.center();
        let (near, far) = (near as f64, far as f64);
        if let AnalyticSurface::Sphere { radius } = self.surface {
            return Sphere { radius }.first_hit(relative, direction, near, far);
        }
        let turn = self.surface_from_world();
        let (origin, direction) = (turn * relative, turn * direction);
        with_shape!(&self.surface, shape => shape.first_hit(origin, direction, near, far))
    }

    /// The hit at a distance where the ray is on the surface; returns `None` if there is no normal.
    #[inline]
    fn hit_at(&self, origin: DVec3, direction: DVec3, distance: f64, turn: &DMat3) -> Option<SurfaceHit> {
        let point = origin + direction * distance;
        let local = *turn * (point - self.center());
        let outwards = with_shape!(&self.surface, shape => shape.outwards(local));
        let normal = (turn.transpose() * outwards).try_normalize()?;
        Some(SurfaceHit { distance: distance as f32, position: point.as_vec3(), normal: normal.as_vec3() })
    }

    /// The point where a ray meets the surface near a distance that is nearly right, such as that of a tessellation.
    ///
    /// Returns `None` if there is no such point within a 50th of the surface's size: the ray passes beside a
    /// silhouette, or beyond the surface's end.
    pub fn refine(&self, origin: Vec3, direction: Vec3, near_distance: f32) -> Option<SurfaceHit> {
        let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
        let [min, max] = with_shape!(&self.surface, shape => shape.corners());
        let size = (max - min).length();
        let start = near_distance as f64;
        let mut distance = start;
        for _ in 0..12 {
            let taylor = self.taylor2(origin + direction * distance);
            let slope = taylor.gradient.dot(direction);
            let bend = direction.dot(taylor.hessian * direction);
            // The nearer root of the parabola: value + slope s + bend s^2 / 2 = 0, without cancellation.
            let discriminant = slope * slope - 2.0 * taylor.value * bend;
            let step = if discriminant >= 0.0 {
                -2.0 * taylor.value / (slope + discriminant.sqrt().copysign(slope))
            } else {
                -slope / bend // where the ray comes nearest; from there once more
            };
            distance += step;
            if !distance.is_finite() || (distance - start).abs() > REFINEMENT_REACH * size {
                return None;
            }
            // Steps shrink at least quadratically: the next one would be lost in rounding.
            if discriminant >= 0.0 && step.abs() <= 1e-8 * size {
                let within = distance >= 0.0 && self.is_within_bounds(origin + direction * distance);
                return if within {
                    self.hit_at(origin, direction, distance, &self.surface_from_world())
                } else {
                    None
                };
            }
        }
        None
    }
}

/// A function's Taylor coefficients in world axes, from those in the surface's.
#[inline]
fn turned(turn: &DMat3, local: &Taylor2) -> Taylor2 {
    let back = turn.transpose();
    Taylor2 { value: local.value, gradient: back * local.gradient, hessian: back * local.hessian * *turn }
}
