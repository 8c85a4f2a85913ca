//! Triangle meshes as geometry alone: vertices that are one point, triangles that are neighbours, connected parts,
//! convex bodies.

pub mod adjacency;
pub mod convexity;
pub mod parts;
pub mod weld;
