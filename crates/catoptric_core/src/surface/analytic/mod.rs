//! Surfaces given by formulas. Rays meet them exactly (in double precision); the rasteriser draws a tessellation.
//!
//! Every kind is an implicit function `g` in its own frame: zero on the surface, positive outside, with a gradient of
//! length about 1 there where its kind allows. A surface is an open sheet where it ends.

mod derivatives;
mod implicit_shape;
mod parameters;
mod placed;
mod ray;
mod shapes;
mod tessellation;

pub use parameters::SurfaceError;
pub use placed::{PlacedSurface, SurfaceHit};
pub use shapes::{Ellipsoid, Expression, Implicit, Instruction, Quadric, Revolution, Superquadric, Torus};
pub use tessellation::mesh::{SurfaceMesh, sphere_mesh};

use crate::math::Aabb;
use glam::{DVec3, Vec3};
use implicit_shape::ImplicitShape;
use shapes::{Plane, Sphere};

/// A surface given by a formula, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum AnalyticSurface {
    /// A sphere about the origin.
    Sphere {
        /// The radius, above 0.
        radius: f64,
    },
    /// A rectangle in the xz plane, about the origin; its outer side is +y.
    Plane {
        /// Half its extent along x.
        half_width: f64,
        /// Half its extent along z.
        half_height: f64,
    },
    /// An ellipsoid about the origin.
    Ellipsoid(Ellipsoid),
    /// A polynomial of second degree, within bounds.
    Quadric(Quadric),
    /// A torus about the y axis.
    Torus(Torus),
    /// A superquadric about the origin.
    Superquadric(Superquadric),
    /// A surface of revolution about the y axis.
    Revolution(Revolution),
    /// The zeros of an expression, within bounds.
    Implicit(Implicit),
}

/// Asks the kind at hand.
macro_rules! with_shape {
    ($surface:expr, $shape:ident => $answer:expr) => {
        match $surface {
            AnalyticSurface::Sphere { radius } => {
                let $shape = &Sphere { radius: *radius };
                $answer
            }
            AnalyticSurface::Plane { half_width, half_height } => {
                let $shape = &Plane { half_width: *half_width, half_height: *half_height };
                $answer
            }
            AnalyticSurface::Ellipsoid($shape) => $answer,
            AnalyticSurface::Quadric($shape) => $answer,
            AnalyticSurface::Torus($shape) => $answer,
            AnalyticSurface::Superquadric($shape) => $answer,
            AnalyticSurface::Revolution($shape) => $answer,
            AnalyticSurface::Implicit($shape) => $answer,
        }
    };
}
use with_shape;

impl AnalyticSurface {
    /// The smallest and largest corner of the box around the surface in its own frame, in double precision.
    pub fn corners(&self) -> [DVec3; 2] {
        with_shape!(self, shape => shape.corners())
    }

    /// The box around the surface in its own frame.
    pub fn bounds(&self) -> Aabb {
        let [min, max] = self.corners();
        // Rounded outwards, so that it holds the surface.
        let below = |x: f64| if x as f32 as f64 > x { (x as f32).next_down() } else { x as f32 };
        let above = |x: f64| if (x as f32 as f64) < x { (x as f32).next_up() } else { x as f32 };
        Aabb {
            min: Vec3::new(below(min.x), below(min.y), below(min.z)),
            max: Vec3::new(above(max.x), above(max.y), above(max.z)),
        }
    }

    /// The surface, `scale` times as large.
    pub fn scaled(&self, scale: f64) -> Self {
        match self {
            Self::Sphere { radius } => Self::Sphere { radius: radius * scale },
            Self::Plane { half_width, half_height } => {
                Self::Plane { half_width: half_width * scale, half_height: half_height * scale }
            }
            Self::Ellipsoid(shape) => Self::Ellipsoid(shape.scaled(scale)),
            Self::Quadric(shape) => Self::Quadric(shape.scaled(scale)),
            Self::Torus(shape) => Self::Torus(shape.scaled(scale)),
            Self::Superquadric(shape) => Self::Superquadric(shape.scaled(scale)),
            Self::Revolution(shape) => Self::Revolution(shape.scaled(scale)),
            Self::Implicit(shape) => Self::Implicit(shape.scaled(scale)),
        }
    }

    /// The name of the kind in scene files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Plane { .. } => "plane",
            Self::Ellipsoid(_) => "ellipsoid",
            Self::Quadric(_) => "quadric",
            Self::Torus(_) => "torus",
            Self::Superquadric(_) => "superquadric",
            Self::Revolution(_) => "revolution",
            Self::Implicit(_) => "implicit",
        }
    }

    /// Triangles whose points lie on the surface, with exact normals. Points on the bounds of a surface lie on them
    /// exactly, and seams have the same points on both sides, bit for bit.
    ///
    /// No point of a triangle is further from the surface than `5e-5` of the diagonal of the surface's box: a tenth
    /// of a pixel when it is 2,000 pixels wide. Quadrics and expressions are cut by a grid with cells of a 96th of the
    /// box's longest side, `h`: they are off by `k h^2 / 2` at most, where `k` is the largest curvature (1e-4 of the
    /// longest side where no radius of curvature is below half of it), edges of an expression by a cell, and features
    /// smaller than a cell can be missing.
    pub fn tessellate(&self) -> SurfaceMesh {
        self.tessellate_to(1.0)
    }

    /// The same with about this share (from 0 to 1) of the cells along each direction: errors are larger by its inverse
    /// square.
    pub fn tessellate_to(&self, fineness: f64) -> SurfaceMesh {
        with_shape!(self, shape => shape.tessellate(fineness))
    }

    /// About as many triangles as the finest mesh has.
    pub(crate) fn finest_triangle_count(&self) -> f64 {
        match self {
            Self::Plane { .. } => 2.0,
            Self::Sphere { .. } | Self::Ellipsoid(_) | Self::Superquadric(_) => 1e5,
            Self::Quadric(_) | Self::Torus(_) | Self::Revolution(_) | Self::Implicit(_) => 2e5,
        }
    }

    /// The diagonal of the box around it.
    pub(crate) fn size(&self) -> f64 {
        let [min, max] = with_shape!(self, shape => shape.corners());
        (max - min).length()
    }

    /// Returns true if a ray that leaves the outer side never meets the surface again.
    pub fn is_convex(&self) -> bool {
        with_shape!(self, shape => shape.is_convex())
    }
}
