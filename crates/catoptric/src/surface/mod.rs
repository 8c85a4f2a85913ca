//! What reflects: analytic surfaces, their ray intersections and tessellations, and the ray tracer's hierarchy.

mod analytic;
pub mod patch;
pub mod site;
pub mod taylor;
pub mod tracer;
mod traversal;

pub(crate) use analytic::sphere_mesh;
pub use analytic::{
    AnalyticSurface, Ellipsoid, PlacedSurface, Quadric, Revolution, Superquadric, SurfaceError, SurfaceHit,
    SurfaceMesh, Torus,
};
pub use patch::SurfacePatch;
pub use taylor::{Taylor2, Taylor3};
