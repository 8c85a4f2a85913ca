//! Nodes, their caches, and interpolation.

mod bake;
mod between;
mod cache;
mod field;
mod grid;
mod places;
