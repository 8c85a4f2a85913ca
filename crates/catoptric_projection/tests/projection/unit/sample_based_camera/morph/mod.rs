//! Nodes, what is kept about them, and what is interpolated.

mod bake;
mod between;
mod cache;
mod field;
mod grid;
mod places;
