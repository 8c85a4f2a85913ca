//! Surfaces.

mod analytic;
mod mesh;
mod patch;
