//! Boxes, deterministic random numbers and small numerics.

mod aabb;
pub mod jet;
pub mod random;

pub use aabb::Aabb;
