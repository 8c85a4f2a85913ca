//! Specular paths: bundles of rays near them, solvers for one path and for all, and surfaces.

mod all_roots;
mod bundle;
mod manifold;
mod specular_solver;
