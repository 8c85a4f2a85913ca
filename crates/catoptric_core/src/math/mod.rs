//! Boxes, deterministic random numbers and small numerics.

mod aabb;
pub mod interval;
pub mod jet;
pub mod lanes;
pub mod portable;
pub mod random;
pub mod roots;
pub mod scalar;

pub use aabb::Aabb;
