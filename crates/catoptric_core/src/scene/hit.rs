//! Hits of rays with a scene's primitives.

use super::Scene;
use crate::surface::SurfaceHit;
use glam::Vec2;

/// The intersection of a ray with the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hit {
    /// On a triangle.
    Triangle {
        /// Distance along the ray.
        distance: f32,
        /// Index of the triangle.
        triangle: u32,
        /// Barycentric coordinates of its second and third vertex.
        barycentrics: Vec2,
    },
    /// On an analytic surface.
    Surface {
        /// Index of the object.
        object: u32,
        /// The exact intersection.
        hit: SurfaceHit,
    },
}

impl Hit {
    /// Distance along the ray.
    #[inline]
    pub fn distance(&self) -> f32 {
        match self {
            Self::Triangle { distance, .. } => *distance,
            Self::Surface { hit, .. } => hit.distance,
        }
    }

    /// Index of the object that is hit.
    #[inline]
    pub fn object(&self, scene: &Scene) -> u32 {
        match self {
            Self::Triangle { triangle, .. } => scene.triangle_objects[*triangle as usize],
            Self::Surface { object, .. } => *object,
        }
    }
}

/// The primitive that a ray hits, without the exact place on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrimitiveHit {
    /// A triangle, by its number.
    Triangle(u32),
    /// An analytic surface near a distance along the ray: the nearer, the faster the place is found.
    Surface {
        /// Index of the object.
        object: u32,
        /// Approximate distance along the ray.
        distance: f64,
    },
}
