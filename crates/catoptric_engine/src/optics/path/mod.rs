//! Specular paths: bundles of rays near a path, its derivatives, solvers for one path and for all, and the surfaces
//! that they run on.

pub mod all_roots;
pub mod bundle;
pub mod manifold;
pub mod path_derivatives;
pub mod specular_solver;
