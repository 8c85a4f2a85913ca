//! Surfaces given by formulas. Rays meet them exactly (in double precision); the rasteriser draws a tessellation.
//!
//! Every kind is an implicit function `g` in its own frame: zero on the surface, positive outside, with a gradient of
//! length about 1 there where its kind allows. A surface is an open sheet where it ends.

mod derivatives;
mod ellipsoid;
mod implicit;
mod placed;
mod plane;
mod quadric;
mod ray;
mod revolution;
mod sphere;
mod superquadric;
mod tessellation;
mod torus;

use super::taylor::{Taylor2, Taylor3};
use crate::math::Aabb;
pub use ellipsoid::Ellipsoid;
use glam::{DVec3, Vec3};
pub use implicit::{Expression, Implicit, Instruction};
pub use placed::{PlacedSurface, SurfaceHit};
use plane::Plane;
pub use quadric::Quadric;
pub use revolution::Revolution;
use sphere::Sphere;
pub use superquadric::Superquadric;
pub use tessellation::mesh::{SurfaceMesh, sphere_mesh};
pub use torus::Torus;

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

/// The reason why there is no such surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{parameter}: {problem}")]
pub struct SurfaceError {
    /// The parameter at fault, as it is called in scene files.
    pub parameter: &'static str,
    /// The fault, and the values that are allowed.
    pub problem: String,
}

impl SurfaceError {
    fn new(parameter: &'static str, problem: impl Into<String>) -> Self {
        Self { parameter, problem: problem.into() }
    }
}

/// The largest length of a surface.
const MAX_LENGTH: f64 = 1e9;
/// The smallest length of a surface: below the smallest normal single a length would be rounded to 0.
const MIN_LENGTH: f64 = 1e-9;

/// A length of a surface, checked.
fn checked_length(parameter: &'static str, length: f64) -> Result<f64, SurfaceError> {
    match (MIN_LENGTH..=MAX_LENGTH).contains(&length) {
        true => Ok(length),
        false => {
            let problem = format!("{length}; a length must be from {MIN_LENGTH:e} to {MAX_LENGTH:e}");
            Err(SurfaceError::new(parameter, problem))
        }
    }
}

/// A box that cuts a surface, checked: its corners, the smaller first.
fn checked_bounds(min: [f64; 3], max: [f64; 3]) -> Result<[DVec3; 2], SurfaceError> {
    for (parameter, corner) in [("bounds_min", min), ("bounds_max", max)] {
        if corner.iter().any(|x| x.is_nan() || x.abs() > MAX_LENGTH) {
            return Err(SurfaceError::new(parameter, format!("{corner:?}; allowed is up to {MAX_LENGTH:e}")));
        }
    }
    match (0..3).all(|axis| max[axis] - min[axis] >= MIN_LENGTH) {
        true => Ok([DVec3::from(min), DVec3::from(max)]),
        false => {
            let problem = format!("{max:?}; every number must be above that of `bounds_min` {min:?}");
            Err(SurfaceError::new("bounds_max", problem))
        }
    }
}

/// The operations of every kind of surface, in its own frame.
trait ImplicitShape {
    /// The smallest and largest corner of a box around the surface.
    fn corners(&self) -> [DVec3; 2];

    /// The implicit function to second order.
    fn taylor2(&self, point: DVec3) -> Taylor2;

    /// The implicit function to third order.
    fn taylor3(&self, point: DVec3) -> Taylor3;

    /// A vector along the gradient of the implicit function, of any length.
    fn outwards(&self, point: DVec3) -> DVec3;

    /// The smallest distance between `near` and `far` at which the ray meets the surface.
    fn first_hit(&self, origin: DVec3, direction: DVec3, near: f64, far: f64) -> Option<f64>;

    /// Triangles on the surface: with this share of the finest mesh's cells along each direction.
    fn tessellate(&self, fineness: f64) -> SurfaceMesh;

    /// Returns true if a ray that leaves the outer side never meets the surface again.
    fn is_convex(&self) -> bool {
        false
    }
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
