//! Shells of layers, and the viewpoints about them.

mod layers;
mod merging;
mod viewpoints;
