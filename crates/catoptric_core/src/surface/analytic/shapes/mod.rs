//! The kinds of surfaces, each with its implicit function and its own way to meet rays.

mod ellipsoid;
mod implicit;
mod plane;
mod quadric;
mod revolution;
mod sphere;
mod superquadric;
mod torus;

pub use ellipsoid::Ellipsoid;
pub use implicit::{Expression, Implicit, Instruction};
pub(super) use plane::Plane;
pub use quadric::Quadric;
pub use revolution::Revolution;
pub(super) use sphere::Sphere;
pub use superquadric::Superquadric;
pub use torus::Torus;
