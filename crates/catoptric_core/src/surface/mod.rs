//! Reflecting geometry alone: analytic surfaces, their ray intersections and tessellations, Taylor expansions, patches.

mod analytic;
pub mod mesh;
pub mod patch;
pub mod taylor;

#[doc(hidden)]
pub use analytic::Expression;
pub use analytic::{
    AnalyticSurface, Ellipsoid, Implicit, Instruction, PlacedSurface, Quadric, Revolution, Superquadric, SurfaceError,
    SurfaceHit, SurfaceMesh, Torus, sphere_mesh,
};
pub use patch::SurfacePatch;
pub use taylor::{Taylor2, Taylor3};
