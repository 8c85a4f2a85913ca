//! Triangle meshes as geometry alone: vertices that are one point, triangles that are neighbours, and connected parts.

pub mod adjacency;
pub mod parts;
pub mod weld;
